// Light from all around the scene by an equirectangular image, with Mitsuba 3's orientation and interpolation: column
// u = atan2(x, -z) / 2 pi (periodic, texel centres at half integers), row v = acos(y) / pi (the first and the last row
// lie on the poles). Importance sampled by the flux of each interpolation cell, uniform in both angles within
// it.
#include "base/file.h"
#include "image/image.h"
#include "scene/distribution_arena.h"
#include "scene/emitter/infinite.h"

struct envmap_emitter {
    struct emitter base;
    const char *filename;
    float scale;
    struct transform to_world;
    size_t width, height; // height >= 2
    rgb *pixels;
    struct distribution2d cells; // width x (height - 1); x of cell i reaches from the centre of texel i to the next
};

static const struct param envmap_params[] = {
    {.name = "filename",
     .type = PARAM_STRING,
     .offset = offsetof(struct envmap_emitter, filename),
     .help = "equirectangular image (EXR, PNG, JPEG, HDR), relative to the scene file"},
    {.name = "scale",
     .type = PARAM_FLOAT,
     .offset = offsetof(struct envmap_emitter, scale),
     .fallback = "1",
     .min = 0,
     .max = 1e30,
     .help = "multiplies the radiance"},
    {.name = "to_world",
     .type = PARAM_TRANSFORM,
     .offset = offsetof(struct envmap_emitter, to_world),
     .fallback = "",
     .help = "turns the map; +y is up"},
    PARAM_END};

static rgb image_pixel(const struct image *image, size_t i) {
    const float *p = image->pixels + i * (size_t)image->channels;
    return image->channels >= 3 ? rgb_make(p[0], p[1], p[2]) : rgb_gray(p[0]);
}

static enum status envmap_copy(struct envmap_emitter *self, const struct image *image, struct commit_context *context,
                               struct error *error) {
    size_t n = (size_t)image->width * (size_t)image->height;
    self->width = (size_t)image->width;
    self->height = image->height > 1 ? (size_t)image->height : 2;
    self->pixels = arena_alloc(context->arena, self->width * self->height, sizeof *self->pixels);
    if (!self->pixels)
        return error_set(error, STATUS_MEMORY, "out of memory for the environment map %s", self->filename);
    for (size_t i = 0; i < self->width * self->height; ++i) {
        rgb v = rgb_scale(image_pixel(image, i % n), self->scale); // a single row is repeated
        if (!rgb_is_finite(v) || v.r < 0 || v.g < 0 || v.b < 0)
            return error_at(error, context->object->place,
                            "%s: pixel %zu,%zu is negative or not finite; repair the image", self->filename,
                            i % self->width, i / self->width);
        self->pixels[i] = v;
    }
    return STATUS_OK;
}

// The integrals over the rows theta0..theta1 of sin(theta) times the weights of the upper and of the lower row of
// texels.
static void row_integrals(size_t y, size_t rows, double *upper, double *lower) {
    double step = 3.14159265358979323846 / (double)rows, theta0 = step * (double)y, theta1 = step * (double)(y + 1);
    *lower = (sin(theta1) - sin(theta0)) / step - cos(theta1);
    *upper = cos(theta0) - cos(theta1) - *lower;
}

static enum status envmap_build_cells(struct envmap_emitter *self, struct commit_context *context,
                                      struct error *error) {
    size_t w = self->width, rows = self->height - 1;
    float *weights = arena_alloc(context->arena, w * rows, sizeof *weights);
    if (!weights) return error_set(error, STATUS_MEMORY, "out of memory for the environment map %s", self->filename);
    for (size_t y = 0; y < rows; ++y) {
        double upper, lower;
        row_integrals(y, rows, &upper, &lower);
        const rgb *row = self->pixels + y * w;
        for (size_t x = 0; x < w; ++x) {
            size_t next = (x + 1) % w;
            weights[y * w + x] = (float)upper * (rgb_mean(row[x]) + rgb_mean(row[next])) +
                                 (float)lower * (rgb_mean(row[w + x]) + rgb_mean(row[w + next]));
        }
    }
    return distribution2d_init_arena(&self->cells, weights, w, rows, context->arena, error);
}

static enum status envmap_commit(struct emitter *emitter, struct commit_context *context, struct error *error) {
    struct envmap_emitter *self = (struct envmap_emitter *)emitter;
    struct transform proper = self->to_world, mirror = transform_scale(vec3_make(-1, 1, 1));
    if (transform_flips_handedness(&proper)) proper = transform_multiply(&proper, &mirror);
    if (!(transform_uniform_scale(&proper) > 0))
        return error_at(error, context->object->place, "to_world of an environment map may only rotate or mirror it");
    char path[4096];
    path_resolve(path, sizeof path, context->object->place.file, self->filename);
    struct image image;
    struct error inner = {0};
    enum status status = image_load(&image, path, false, &inner);
    if (status != STATUS_OK) {
        error_at(error, context->object->place, "%s", inner.text);
        if (error) error->status = status;
        return status;
    }
    status = envmap_copy(self, &image, context, error);
    image_fini(&image);
    return status == STATUS_OK ? envmap_build_cells(self, context, error) : status;
}

static enum status envmap_ready(struct emitter *emitter, struct commit_context *context, struct error *error) {
    (void)context, (void)error;
    const struct envmap_emitter *self = (const struct envmap_emitter *)emitter;
    size_t w = self->width, rows = self->height - 1;
    double cell = 2 * 3.14159265358979323846 / (double)w;
    rgb flux = {0};
    for (size_t y = 0; y < rows; ++y) {
        double upper, lower, sum[3] = {0};
        row_integrals(y, rows, &upper, &lower);
        for (size_t x = 0; x < w; ++x) {
            rgb a = self->pixels[y * w + x], b = self->pixels[(y + 1) * w + x];
            sum[0] += upper * (double)a.r + lower * (double)b.r;
            sum[1] += upper * (double)a.g + lower * (double)b.g;
            sum[2] += upper * (double)a.b + lower * (double)b.b;
        }
        flux = rgb_add(flux, rgb_make((float)(sum[0] * cell), (float)(sum[1] * cell), (float)(sum[2] * cell)));
    }
    emitter->power = rgb_scale(flux, 1 / bounds_disk_pdf(&emitter->bounds));
    return STATUS_OK;
}

// Position in cells, [0,1]^2, of the environment's direction w; its sine of the polar angle.
static vec2 cells_from_direction(const struct envmap_emitter *self, vec3 w, float *sine) {
    struct transform local = transform_inverse(&self->to_world);
    vec3 v = vec3_normalize(transform_vector(&local, w));
    *sine = sqrtf(v.x * v.x + v.z * v.z);
    float x = atan2f(v.x, -v.z) * 0.5f * INV_PI_F - 0.5f / (float)self->width;
    x -= floorf(x);
    return (vec2){x < 1 ? x : 0, clampf(atan2f(*sine, v.y) * INV_PI_F, 0, 1)};
}

static vec3 direction_from_cells(const struct envmap_emitter *self, vec2 p, float *sine) {
    float phi = 2 * PI_F * (p.x + 0.5f / (float)self->width), theta = PI_F * p.y;
    *sine = sinf(theta);
    return vec3_normalize(
        transform_vector(&self->to_world, vec3_make(*sine * sinf(phi), cosf(theta), -*sine * cosf(phi))));
}

static rgb envmap_lookup(const struct envmap_emitter *self, vec2 p) {
    float x = p.x * (float)self->width, y = p.y * (float)(self->height - 1);
    size_t x0 = (size_t)x < self->width ? (size_t)x : self->width - 1, x1 = (x0 + 1) % self->width;
    size_t y0 = (size_t)y < self->height - 1 ? (size_t)y : self->height - 2;
    float fx = x - (float)x0, fy = y - (float)y0;
    const rgb *top = self->pixels + y0 * self->width, *bottom = top + self->width;
    rgb a = rgb_add(rgb_scale(top[x0], 1 - fx), rgb_scale(top[x1], fx));
    rgb b = rgb_add(rgb_scale(bottom[x0], 1 - fx), rgb_scale(bottom[x1], fx));
    return rgb_add(rgb_scale(a, 1 - fy), rgb_scale(b, fy));
}

static float cells_pdf_sa(float pdf, float sine) { return sine > 0 ? pdf / (2 * PI_F * PI_F * sine) : 0; }

static rgb envmap_eval(const struct emitter *emitter, const struct surface *surface, vec3 w) {
    (void)surface;
    const struct envmap_emitter *self = (const struct envmap_emitter *)emitter;
    float sine;
    return envmap_lookup(self, cells_from_direction(self, vec3_neg(w), &sine));
}

static vec3 envmap_sample_direction(const struct envmap_emitter *self, vec2 u, rgb *radiance, float *pdf_sa) {
    float pdf, sine;
    vec2 p = distribution2d_sample(&self->cells, u, &pdf);
    vec3 direction = direction_from_cells(self, p, &sine);
    *radiance = envmap_lookup(self, p);
    *pdf_sa = cells_pdf_sa(pdf, sine);
    return direction;
}

static bool envmap_sample_light(const struct emitter *emitter, vec3 p, vec2 u, struct light_sample *sample) {
    (void)p;
    *sample = (struct light_sample){.distance = INFINITY};
    sample->direction =
        envmap_sample_direction((const struct envmap_emitter *)emitter, u, &sample->radiance, &sample->pdf_sa);
    sample->n = vec3_neg(sample->direction);
    return sample->pdf_sa > 0 && !rgb_is_black(sample->radiance);
}

static float envmap_pdf_light(const struct emitter *emitter, vec3 p, const struct surface *surface, vec3 direction) {
    (void)p, (void)surface;
    const struct envmap_emitter *self = (const struct envmap_emitter *)emitter;
    float sine;
    vec2 at = cells_from_direction(self, direction, &sine);
    return cells_pdf_sa(distribution2d_pdf(&self->cells, at), sine);
}

static bool envmap_sample_emission(const struct emitter *emitter, vec2 u_position, vec2 u_direction,
                                   struct emission_sample *sample) {
    *sample = (struct emission_sample){.cos_theta = 1, .pdf_position = bounds_disk_pdf(&emitter->bounds)};
    sample->n = vec3_neg(envmap_sample_direction((const struct envmap_emitter *)emitter, u_direction, &sample->radiance,
                                                 &sample->pdf_direction));
    sample->ray = bounds_disk_ray(&emitter->bounds, sample->n, u_position);
    return sample->pdf_direction > 0 && !rgb_is_black(sample->radiance);
}

static void envmap_pdf_emission(const struct emitter *emitter, const struct surface *surface, vec3 direction,
                                float *pdf_position, float *pdf_direction) {
    *pdf_position = bounds_disk_pdf(&emitter->bounds);
    *pdf_direction = envmap_pdf_light(emitter, emitter->bounds.center, surface, vec3_neg(direction));
}

const struct emitter_type emitter_envmap = {
    .name = "envmap",
    .help = "an equirectangular image around the scene",
    .params = envmap_params,
    .size = sizeof(struct envmap_emitter),
    .flags = EMITTER_INFINITE,
    .commit = envmap_commit,
    .ready = envmap_ready,
    .eval = envmap_eval,
    .sample_light = envmap_sample_light,
    .pdf_light = envmap_pdf_light,
    .sample_emission = envmap_sample_emission,
    .pdf_emission = envmap_pdf_emission,
};
