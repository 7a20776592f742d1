// bitmap: an image over uv. The image's first row lies at v = 0, as in Mitsuba 3 (whose OBJ reader flips v, as ours
// does).
#include <stdint.h>

#include "base/file.h"
#include "image/image.h"
#include "scene/texture.h"
#include "scene/texture/uv_map.h"

enum { FILTER_BILINEAR, FILTER_TRILINEAR, FILTER_EWA, FILTER_NEAREST }; // the second and third are read as the first
enum { WRAP_REPEAT, WRAP_CLAMP, WRAP_MIRROR, WRAP_ZERO, WRAP_ONE };
enum { CHANNEL_ALL, CHANNEL_R, CHANNEL_G, CHANNEL_B, CHANNEL_A };

struct bitmap_texture {
    struct texture base;
    const char *filename;
    int filter, wrap, channel;
    bool raw;
    float gamma;
    struct uv_map uv_map;
    int width, height;
    const rgb *pixels;
};

static rgb image_pixel(const struct bitmap_texture *b, const struct image *image, size_t index) {
    const float *p = image->pixels + index * (size_t)image->channels;
    bool has_alpha = image->channels == 2 || image->channels == 4, is_color = image->channels >= 3;
    rgb v = is_color ? (rgb){p[0], p[1], p[2]} : rgb_gray(p[0]);
    if (b->channel == CHANNEL_A) v = rgb_gray(has_alpha ? p[image->channels - 1] : 1);
    if (b->channel != CHANNEL_ALL && b->channel != CHANNEL_A && is_color) v = rgb_gray(p[b->channel - CHANNEL_R]);
    if (b->gamma <= 0 || b->channel == CHANNEL_A) return v;
    return (rgb){powf(fmaxf(v.r, 0), b->gamma), powf(fmaxf(v.g, 0), b->gamma), powf(fmaxf(v.b, 0), b->gamma)};
}

static enum status bitmap_texture_commit(struct texture *texture, struct commit_context *context, struct error *error) {
    struct bitmap_texture *b = (struct bitmap_texture *)texture;
    char path[4096];
    path_resolve(path, sizeof path, context->object->place.file, b->filename);
    struct image image;
    struct error cause = {0};
    uv_map_init(&b->uv_map);
    enum status status = image_load(&image, path, b->raw || b->gamma > 0, &cause);
    if (status == STATUS_IO && context->skip_missing) {
        const struct place place = context->object->place;
        run_warn(context->run, "%s:%d:%d: %s; the texture is a middle gray", place.file, place.line, place.column,
                 cause.text);
        rgb *gray = arena_alloc(context->arena, 1, sizeof *gray);
        if (!gray) return error_set(error, STATUS_MEMORY, "no memory for the texture %s", path);
        b->width = b->height = 1;
        b->pixels = gray;
        texture->value = *gray = rgb_gray(0.5f);
        return STATUS_OK;
    }
    if (status != STATUS_OK) {
        error_at(error, context->object->place, "%s", cause.text);
        if (error) error->status = status;
        return status;
    }
    size_t count = (size_t)image.width * (size_t)image.height;
    rgb *pixels = arena_alloc(context->arena, count, sizeof *pixels);
    double sum[3] = {0, 0, 0};
    for (size_t i = 0; pixels && i < count; ++i) {
        pixels[i] = image_pixel(b, &image, i);
        sum[0] += pixels[i].r;
        sum[1] += pixels[i].g;
        sum[2] += pixels[i].b;
    }
    b->width = image.width;
    b->height = image.height;
    b->pixels = pixels;
    image_fini(&image);
    if (!pixels) return error_set(error, STATUS_MEMORY, "no memory for the texture %s", path);
    double scale = 1.0 / (double)count;
    texture->value = (rgb){(float)(sum[0] * scale), (float)(sum[1] * scale), (float)(sum[2] * scale)};
    return STATUS_OK;
}

// Where coordinate t falls on an axis of n texels, in texels and one period (mirror: two) from the first.
static float axis_position(int wrap, float t, int n) {
    if (!(fabsf(t) < 1e9f)) return 0; // also not-a-number
    if (wrap == WRAP_CLAMP || wrap >= WRAP_ZERO) return clampf(t, 0, 1) * (float)n;
    float period = wrap == WRAP_MIRROR ? 2.0f : 1.0f;
    return (t - period * floorf(t / period)) * (float)n;
}

static int axis_texel(int wrap, int i, int n) { // i within one period of the image
    if (wrap == WRAP_CLAMP || wrap >= WRAP_ZERO) return i < 0 ? 0 : i >= n ? n - 1 : i;
    int period = wrap == WRAP_MIRROR ? 2 * n : n;
    i = i < 0 ? i + period : i >= period ? i - period : i;
    return i < n ? i : 2 * n - 1 - i;
}

struct texels { // and how much of the second column and row
    const rgb *upper[2], *lower[2];
    float x, y;
};

static struct texels find_texels(const struct bitmap_texture *b, vec2 t) {
    float x = axis_position(b->wrap, t.x, b->width), y = axis_position(b->wrap, t.y, b->height);
    if (b->filter == FILTER_NEAREST) {
        int column = axis_texel(b->wrap, (int)x, b->width), row = axis_texel(b->wrap, (int)y, b->height);
        const rgb *only = b->pixels + (size_t)row * (size_t)b->width + (size_t)column;
        return (struct texels){{only, only}, {only, only}, 0, 0};
    }
    float left = floorf(x - 0.5f), top = floorf(y - 0.5f);
    int x0 = axis_texel(b->wrap, (int)left, b->width), x1 = axis_texel(b->wrap, (int)left + 1, b->width);
    int y0 = axis_texel(b->wrap, (int)top, b->height), y1 = axis_texel(b->wrap, (int)top + 1, b->height);
    const rgb *row0 = b->pixels + (size_t)y0 * (size_t)b->width, *row1 = b->pixels + (size_t)y1 * (size_t)b->width;
    return (struct texels){{row0 + x0, row0 + x1}, {row1 + x0, row1 + x1}, x - 0.5f - left, y - 0.5f - top};
}

static rgb bitmap_texture_eval(const struct texture *texture, vec2 uv) {
    const struct bitmap_texture *b = (const struct bitmap_texture *)texture;
    vec2 t = uv_map_apply(&b->uv_map, uv);
    if (b->wrap >= WRAP_ZERO && !(t.x >= 0 && t.x <= 1 && t.y >= 0 && t.y <= 1)) return rgb_gray(b->wrap == WRAP_ONE);
    struct texels texels = find_texels(b, t);
    rgb upper = rgb_add(rgb_scale(*texels.upper[0], 1.0f - texels.x), rgb_scale(*texels.upper[1], texels.x));
    rgb lower = rgb_add(rgb_scale(*texels.lower[0], 1.0f - texels.x), rgb_scale(*texels.lower[1], texels.x));
    return rgb_add(rgb_scale(upper, 1.0f - texels.y), rgb_scale(lower, texels.y));
}

static void bitmap_texture_fetch(const struct texture *texture, vec2 uv) {
    const struct bitmap_texture *b = (const struct bitmap_texture *)texture;
    struct texels texels = find_texels(b, uv_map_apply(&b->uv_map, uv));
    __builtin_prefetch(texels.upper[0]);
    __builtin_prefetch(texels.lower[0]);
}

static const struct param bitmap_texture_params[] = {
    {"filename", PARAM_STRING, offsetof(struct bitmap_texture, filename), NULL,
     .help = "EXR, PNG, JPEG or HDR, relative to the scene file"},
    {"filter_type", PARAM_CHOICE, offsetof(struct bitmap_texture, filter), "bilinear",
     .choices = "bilinear|trilinear|ewa|nearest", .help = "interpolation; trilinear and ewa are read as bilinear"},
    {"wrap_mode", PARAM_CHOICE, offsetof(struct bitmap_texture, wrap), "repeat",
     .choices = "repeat|clamp|mirror|zero|one", .help = "what lies outside the unit square"},
    {"raw", PARAM_BOOL, offsetof(struct bitmap_texture, raw), "false",
     .help = "8-bit values are data (a normal map, a roughness), not sRGB colours"},
    {"gamma", PARAM_FLOAT, offsetof(struct bitmap_texture, gamma), "-1", .min = -1, .max = 100,
     .help = "of the file: 1 is linear; -1 or 0: sRGB for 8-bit files, else linear"},
    {"channel", PARAM_CHOICE, offsetof(struct bitmap_texture, channel), "all", .choices = "all|r|g|b|a",
     .help = "one of them as a gray texture"},
    UV_MAP_PARAMS(struct bitmap_texture, uv_map),
    PARAM_END,
};

const struct texture_type texture_bitmap = {
    .name = "bitmap",
    .help = "an image",
    .params = bitmap_texture_params,
    .size = sizeof(struct bitmap_texture),
    .commit = bitmap_texture_commit,
    .eval = bitmap_texture_eval,
    .fetch = bitmap_texture_fetch,
};
