// Looking at the lamp: orthographic pictures of the bounding sphere from the corners of a cube, of the light field, of
// the hull where there is one, and by traced lines.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"
#include "bake/evaluate_private.h"
#include "math/warp.h"
#include "trace/hull_look.h"

enum { PIXELS = EVALUATION_PIXELS, VIEWS = 8, MAX_DEPTH = 100 };

struct view_job {
    const struct luminaire *luminaire;
    const struct lamp *lamp;
    uint64_t stream;
    vec3 w; // of the light
    size_t samples; // of each half of a pixel
    struct image_pair *model, *reference;
    const struct scene *hull; // or NULL
    struct image_pair *surface;
};

// One sample of every pixel of a row by the hull; absorption in its glass is left out.
static void add_surface_row(const struct view_job *job, const float (*at)[3], const struct sampler *samplers,
                            float *pixels, float share) {
    struct view_point points[PIXELS];
    float radiance[PIXELS][3];
    size_t columns[PIXELS], count = 0;
    const struct hull *hull = luminaire_hull(job->luminaire);
    for (size_t column = 0; column < PIXELS; column++) {
        struct ray ray = {{at[column][0], at[column][1], at[column][2]}, vec3_neg(job->w), 0, INFINITY};
        struct sampler sampler = samplers[column];
        if (hull_trace(job->hull, hull, &ray, &sampler, &points[count])) columns[count++] = column;
    }
    if (count) luminaire_view(job->luminaire, count, points, radiance);
    for (size_t i = 0; i < count; i++)
        for (size_t c = 0; c < 3; c++) pixels[3 * columns[i] + c] += radiance[i][c] * share;
}

static void view_row(void *user, size_t row, int worker) {
    (void)worker;
    const struct view_job *job = user;
    const struct lamp *lamp = job->lamp;
    const vec3 center = {lamp->proxy.center[0], lamp->proxy.center[1], lamp->proxy.center[2]};
    const struct frame frame = frame_from_normal(job->w);
    const float step = 2 * lamp->proxy.radius / PIXELS, share = 1 / (float)job->samples;
    float at[PIXELS][3], along[PIXELS][3], radiance[PIXELS][3];
    for (int half = 0; half < 2; half++)
        for (size_t k = 0; k < job->samples; k++) {
            float *reference = job->reference->half[half].pixels + 3 * row * PIXELS;
            float *model = job->model->half[half].pixels + 3 * row * PIXELS;
            struct sampler samplers[PIXELS];
            for (size_t column = 0; column < PIXELS; column++) {
                uint64_t stream = job->stream | (uint64_t)half << 40 | row << 20 | column;
                struct sampler sampler = sampler_make(lamp->seed, stream, k);
                vec2 u = sampler_2d(&sampler);
                float x = ((float)column + u.x - 0.5f * PIXELS) * step, y = (0.5f * PIXELS - (float)row - u.y) * step;
                vec3 p = vec3_mad(frame.s, x, vec3_mad(frame.t, y, center));
                p = vec3_mad(job->w, 1.001f * lamp->proxy.radius, p);
                at[column][0] = p.x, at[column][1] = p.y, at[column][2] = p.z;
                along[column][0] = job->w.x, along[column][1] = job->w.y, along[column][2] = job->w.z;
                struct ray ray = {p, vec3_neg(job->w), 0, INFINITY};
                samplers[column] = sampler;
                struct line_hit hit;
                trace_line_radiance(lamp->scene, &ray, &sampler, lamp->aims, lamp->aim_count, MAX_DEPTH, &hit);
                reference[3 * column] += hit.radiance.r * share;
                reference[3 * column + 1] += hit.radiance.g * share;
                reference[3 * column + 2] += hit.radiance.b * share;
            }
            if (job->hull)
                add_surface_row(job, (const float(*)[3])at, samplers,
                                job->surface->half[half].pixels + 3 * row * PIXELS, share);
            luminaire_eval(job->luminaire, PIXELS, (const float(*)[3])at, (const float(*)[3])along, radiance);
            for (size_t i = 0; i < PIXELS; i++)
                if (!luminaire_seen(job->luminaire, at[i], along[i])) memset(radiance[i], 0, sizeof radiance[i]);
            for (size_t i = 0; i < PIXELS; i++)
                for (int c = 0; c < 3; c++) model[3 * i + (size_t)c] += radiance[i][c] * share;
        }
}

// Sums of squared differences of log(1 + x), free of noise but for the logarithm's curvature.
static void log_errors(const struct image_pair *model, const struct image_pair *reference, double *squared,
                       double *black) {
    for (size_t i = 0; i < 3 * PIXELS * PIXELS; i++) {
        double r0 = log1p((double)reference->half[0].pixels[i]), r1 = log1p((double)reference->half[1].pixels[i]);
        double a = log1p(0.5 * (double)(model->half[0].pixels[i] + model->half[1].pixels[i]));
        *squared += (a - r0) * (a - r1);
        *black += r0 * r1;
    }
}

// The same for pictures whose halves are independent of each other, but not of the reference's halves.
static void log_errors_by_halves(const struct image_pair *model, const struct image_pair *reference, double *squared) {
    for (size_t i = 0; i < 3 * PIXELS * PIXELS; i++) {
        double difference[2];
        for (int half = 0; half < 2; half++)
            difference[half] =
                log1p((double)model->half[half].pixels[i]) - log1p((double)reference->half[half].pixels[i]);
        *squared += difference[0] * difference[1];
    }
}

struct view_sums {
    double squared, surface_squared, black, flip, surface_flip, flip_noise, flip_black;
};

static enum status compare_view(const struct view_job *job, struct view_sums *sums, struct error *error) {
    double one, one_noise, one_black;
    parallel_for(job->lamp->threads, PIXELS, view_row, (void *)job);
    log_errors(job->model, job->reference, &sums->squared, &sums->black);
    // The picture of the light field has the same places in each pixel: only the reference's noise counts.
    struct image_pair still = {0};
    enum status status = image_pair_mean(job->model, &still.half[0], error);
    still.half[1] = still.half[0];
    if (status == STATUS_OK) status = image_pair_flip(&still, job->reference, &one, &one_noise, &one_black, error);
    if (status == STATUS_OK) {
        sums->flip += one / VIEWS;
        sums->flip_noise += one_noise / VIEWS;
        sums->flip_black += one_black / VIEWS;
    }
    image_fini(&still.half[0]);
    if (!job->hull || status != STATUS_OK) return status;
    log_errors_by_halves(job->surface, job->reference, &sums->surface_squared);
    status = image_pair_flip(job->surface, job->reference, &one, &one_noise, &one_black, error);
    sums->surface_flip += one / VIEWS;
    return status;
}

static float gain_db(double squared, double black) {
    return squared > 0 && black > 0 ? (float)(10 * log10(black / squared)) : 0;
}

enum status evaluate_views(const struct luminaire *luminaire, const struct lamp *lamp, int samples,
                           struct evaluation *evaluation, struct error *error) {
    const bool has_hull = luminaire_hull(luminaire) != NULL;
    struct view_sums sums = {0};
    struct scene hull = {0};
    enum status status = has_hull ? scene_init_hull(&hull, luminaire, lamp->threads, error) : STATUS_OK;
    if (status != STATUS_OK) return status;
    for (int view = 0; view < VIEWS && status == STATUS_OK; view++) {
        struct image_pair model, reference = {0}, surface = {0};
        status = image_pair_init(&model, error);
        if (status == STATUS_OK) status = image_pair_init(&reference, error);
        if (status == STATUS_OK) status = image_pair_init(&surface, error);
        struct view_job job = {
            .luminaire = luminaire,
            .lamp = lamp,
            .stream = (uint64_t)STREAM_EVALUATION << 56 | 5ull << 48 | (uint64_t)view << 42,
            .w = vec3_normalize((vec3){view & 1 ? 1.0f : -1.0f, view & 2 ? 1.0f : -1.0f, view & 4 ? 1.0f : -1.0f}),
            .samples = samples < 2 ? 1 : (size_t)samples / 2,
            .model = &model,
            .reference = &reference,
            .hull = has_hull ? &hull : NULL,
            .surface = &surface};
        if (status == STATUS_OK) status = compare_view(&job, &sums, error);
        image_pair_fini(&model);
        image_pair_fini(&reference);
        image_pair_fini(&surface);
    }
    evaluation->view_gain_db = gain_db(sums.squared, sums.black);
    evaluation->view_flip = (float)sums.flip;
    evaluation->view_flip_noise = (float)sums.flip_noise;
    evaluation->view_flip_black = (float)sums.flip_black;
    evaluation->view_measured = status == STATUS_OK;
    evaluation->surface_gain_db = gain_db(sums.surface_squared, sums.black);
    evaluation->surface_flip = (float)sums.surface_flip;
    evaluation->surface_measured = status == STATUS_OK && has_hull;
    scene_fini(&hull);
    return status;
}
