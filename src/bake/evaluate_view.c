// Looking at the lamp: orthographic pictures of the bounding sphere from the corners of a cube, of the light field and
// by traced lines.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"
#include "bake/evaluate_private.h"
#include "math/warp.h"

enum { PIXELS = EVALUATION_PIXELS, VIEWS = 8, MAX_DEPTH = 100 };

struct view_job {
    const struct luminaire *luminaire;
    const struct lamp *lamp;
    uint64_t stream;
    vec3 w; // of the light
    size_t samples; // of each half of a pixel
    struct image_pair *model, *reference;
};

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
                struct line_hit hit;
                trace_line_radiance(lamp->scene, &ray, &sampler, lamp->aims, lamp->aim_count, MAX_DEPTH, &hit);
                reference[3 * column] += hit.radiance.r * share;
                reference[3 * column + 1] += hit.radiance.g * share;
                reference[3 * column + 2] += hit.radiance.b * share;
            }
            luminaire_eval(job->luminaire, PIXELS, (const float(*)[3])at, (const float(*)[3])along, radiance);
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

enum status evaluate_views(const struct luminaire *luminaire, const struct lamp *lamp, int samples,
                           struct evaluation *evaluation, struct error *error) {
    double squared = 0, black = 0, flip = 0, flip_noise = 0, flip_black = 0;
    enum status status = STATUS_OK;
    for (int view = 0; view < VIEWS && status == STATUS_OK; view++) {
        struct image_pair model, reference = {0};
        status = image_pair_init(&model, error);
        if (status == STATUS_OK) status = image_pair_init(&reference, error);
        if (status == STATUS_OK) {
            vec3 w = vec3_normalize((vec3){view & 1 ? 1.0f : -1.0f, view & 2 ? 1.0f : -1.0f, view & 4 ? 1.0f : -1.0f});
            struct view_job job = {luminaire,
                                   lamp,
                                   (uint64_t)STREAM_EVALUATION << 56 | 5ull << 48 | (uint64_t)view << 42,
                                   w,
                                   samples < 2 ? 1 : (size_t)samples / 2,
                                   &model,
                                   &reference};
            parallel_for(lamp->threads, PIXELS, view_row, &job);
            log_errors(&model, &reference, &squared, &black);
            double one, one_noise, one_black;
            // The picture of the light field has the same places in each pixel: only the reference's noise counts.
            struct image_pair still = {{model.half[0], model.half[0]}};
            status = image_pair_mean(&model, &still.half[0], error);
            still.half[1] = still.half[0];
            if (status == STATUS_OK) status = image_pair_flip(&still, &reference, &one, &one_noise, &one_black, error);
            if (status == STATUS_OK) image_fini(&still.half[0]);
            flip += one / VIEWS;
            flip_noise += one_noise / VIEWS;
            flip_black += one_black / VIEWS;
        }
        image_pair_fini(&model);
        image_pair_fini(&reference);
    }
    evaluation->view_gain_db = squared > 0 && black > 0 ? (float)(10 * log10(black / squared)) : 0;
    evaluation->view_flip = (float)flip;
    evaluation->view_flip_noise = (float)flip_noise;
    evaluation->view_flip_black = (float)flip_black;
    evaluation->view_measured = status == STATUS_OK;
    return status;
}
