// checkerboard: two textures in alternation, two squares to a unit of u and of v as in Mitsuba 3.
#include "scene/texture.h"
#include "scene/texture/uv_map.h"

struct checkerboard_texture {
    struct texture base;
    const struct texture *color0, *color1;
    struct uv_map uv_map;
};

static enum status checkerboard_texture_commit(struct texture *texture, struct commit_context *context,
                                               struct error *error) {
    struct checkerboard_texture *c = (struct checkerboard_texture *)texture;
    (void)context, (void)error;
    uv_map_init(&c->uv_map);
    texture->value = rgb_scale(rgb_add(c->color0->value, c->color1->value), 0.5f);
    return STATUS_OK;
}

static rgb checkerboard_texture_eval(const struct texture *texture, vec2 uv) {
    const struct checkerboard_texture *c = (const struct checkerboard_texture *)texture;
    vec2 t = uv_map_apply(&c->uv_map, uv);
    bool second = (t.x - floorf(t.x) > 0.5f) != (t.y - floorf(t.y) > 0.5f);
    return texture_eval(second ? c->color1 : c->color0, uv);
}

static const struct param checkerboard_texture_params[] = {
    {"color0", PARAM_TEXTURE, offsetof(struct checkerboard_texture, color0), "0.4", .unit = "1",
     .help = "the square at the origin"},
    {"color1", PARAM_TEXTURE, offsetof(struct checkerboard_texture, color1), "0.2", .unit = "1",
     .help = "its neighbours"},
    UV_MAP_PARAMS(struct checkerboard_texture, uv_map),
    PARAM_END,
};

const struct texture_type texture_checkerboard = {
    .name = "checkerboard",
    .help = "two colours or textures in squares",
    .params = checkerboard_texture_params,
    .size = sizeof(struct checkerboard_texture),
    .commit = checkerboard_texture_commit,
    .eval = checkerboard_texture_eval,
};
