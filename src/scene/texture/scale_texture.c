// scale: another texture times a constant (Mitsuba 0.5).
#include "scene/texture.h"

struct scale_texture {
    struct texture base;
    const struct texture *texture;
    rgb scale;
};

static enum status scale_texture_commit(struct texture *texture, struct commit_context *context, struct error *error) {
    struct scale_texture *s = (struct scale_texture *)texture;
    (void)context, (void)error;
    texture->value = rgb_mul(s->texture->value, s->scale);
    return STATUS_OK;
}

static rgb scale_texture_eval(const struct texture *texture, vec2 uv) {
    const struct scale_texture *s = (const struct scale_texture *)texture;
    return rgb_mul(texture_eval(s->texture, uv), s->scale);
}

static void scale_texture_fetch(const struct texture *texture, vec2 uv) {
    const struct texture *scaled = ((const struct scale_texture *)texture)->texture;
    if (scaled->type && scaled->type->fetch) scaled->type->fetch(scaled, uv);
}

static const struct param scale_texture_params[] = {
    {"texture", PARAM_TEXTURE, offsetof(struct scale_texture, texture), NULL,
     .help = "the nested texture, of any name"},
    {"scale", PARAM_RGB, offsetof(struct scale_texture, scale), "1", .unit = "1", .help = "factor"},
    PARAM_END,
};

const struct texture_type texture_scale = {
    .name = "scale",
    .help = "a texture times a factor",
    .params = scale_texture_params,
    .size = sizeof(struct scale_texture),
    .commit = scale_texture_commit,
    .eval = scale_texture_eval,
    .fetch = scale_texture_fetch,
};
