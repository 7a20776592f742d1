// Sums over the grid stand for integrals: cells must be smaller than what the lamp has in them.
#include "evidence/cone_image.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"
#include "math/warp.h"

enum { MAX_DEPTH = 100 };

enum status cone_image_init(struct cone_image *image, const struct luminaire *luminaire, vec3 out, float distance,
                            int side, struct error *error) {
    float center[3], radius;
    luminaire_bounds(luminaire, center, &radius);
    const float sin2 = 1 / sqrf(distance);
    const size_t cells = (size_t)side * (size_t)side;
    *image = (struct cone_image){
        .point = vec3_mad(out, distance * radius, vec3_from(center)),
        .view = {0, false, frame_from_normal(vec3_neg(out)), sin2 / (1 + sqrtf(1 - sin2))},
        .side = side,
        .direction = malloc(cells * sizeof *image->direction),
        .value = calloc(cells, sizeof *image->value),
    };
    if (!image->direction || !image->value) {
        cone_image_fini(image);
        return error_set(error, STATUS_MEMORY, "out of memory for an image of %d x %d directions", side, side);
    }
    image->solid_angle = 2 * PI_F * image->view.rim / (float)cells;
    for (int i = 0; i < side * side; i++) {
        const vec2 p = {((float)(i % side) + 0.5f) / (float)side, ((float)(i / side) + 0.5f) / (float)side};
        vec3 d = sampling_direction_from_image(&image->view, p);
        memcpy(image->direction[i], &(float[3]){d.x, d.y, d.z}, sizeof image->direction[i]);
    }
    return STATUS_OK;
}

void cone_image_fini(struct cone_image *image) {
    free(image->direction);
    free(image->value);
    *image = (struct cone_image){0};
}

static float cosine_of(const struct cone_image *image, const float direction[3]) {
    return vec3_dot(vec3_from(direction), image->view.frame.n);
}

void cone_image_predict(struct cone_image *image, const struct luminaire *luminaire) {
    enum { BLOCK = 64 };
    const int cells = image->side * image->side;
    for (int first = 0; first < cells; first += BLOCK) {
        float point[BLOCK][3], w[BLOCK][3], radiance[BLOCK][3];
        const int n = cells - first < BLOCK ? cells - first : BLOCK;
        for (int i = 0; i < n; i++) {
            memcpy(point[i], &(float[3]){image->point.x, image->point.y, image->point.z}, sizeof point[i]);
            for (int c = 0; c < 3; c++) w[i][c] = -image->direction[first + i][c];
        }
        luminaire_eval(luminaire, (size_t)n, point, w, radiance);
        for (int i = 0; i < n; i++)
            image->value[first + i] = rgb_luminance((rgb){radiance[i][0], radiance[i][1], radiance[i][2]}) *
                                      cosine_of(image, image->direction[first + i]);
    }
}

struct trace_job {
    struct cone_image *image;
    const struct lamp *lamp;
    int samples;
    uint64_t stream;
};

static void trace_row(void *user, size_t row, int worker) {
    (void)worker;
    const struct trace_job *job = user;
    struct cone_image *image = job->image;
    const float step = 1 / (float)image->side;
    for (int column = 0; column < image->side; column++) {
        const size_t cell = row * (size_t)image->side + (size_t)column;
        double sum = 0;
        for (int k = 0; k < job->samples; k++) {
            struct sampler sampler = sampler_make(job->lamp->seed, job->stream | cell, (uint64_t)k);
            vec2 u = sampler_2d(&sampler);
            vec3 d = sampling_direction_from_image(&image->view,
                                                   (vec2){((float)column + u.x) * step, ((float)row + u.y) * step});
            struct ray ray = {image->point, d, 0, INFINITY};
            struct line_hit hit;
            trace_line_radiance(job->lamp->scene, &ray, &sampler, job->lamp->aims, job->lamp->aim_count, MAX_DEPTH,
                                &hit);
            sum += (double)(rgb_luminance(hit.radiance) * cosine_of(image, (float[3]){d.x, d.y, d.z}));
        }
        image->value[cell] = (float)(sum / job->samples);
    }
}

void cone_image_trace(struct cone_image *image, const struct lamp *lamp, int samples, uint64_t stream) {
    struct trace_job job = {image, lamp, samples, stream};
    parallel_for(lamp->threads, (size_t)image->side, trace_row, &job);
}

void cone_image_density(struct cone_image *image, const struct luminaire *luminaire) {
    enum { BLOCK = 64 };
    const int cells = image->side * image->side;
    for (int first = 0; first < cells; first += BLOCK) {
        float point[BLOCK][3];
        const int n = cells - first < BLOCK ? cells - first : BLOCK;
        for (int i = 0; i < n; i++)
            memcpy(point[i], &(float[3]){image->point.x, image->point.y, image->point.z}, sizeof point[i]);
        luminaire_pdf(luminaire, (size_t)n, point, image->direction + first, image->value + first);
    }
}

void cone_image_average(const struct cone_image *image, int coarse, float *mean) {
    const int block = image->side / coarse;
    memset(mean, 0, (size_t)coarse * (size_t)coarse * sizeof *mean);
    for (int y = 0; y < block * coarse; y++)
        for (int x = 0; x < block * coarse; x++)
            mean[y / block * coarse + x / block] += image->value[y * image->side + x] / (float)(block * block);
}

double cone_image_variance(const struct cone_image *image, const float *density) {
    double mean = 0, square = 0, cell = (double)image->solid_angle;
    for (int i = 0; i < image->side * image->side; i++) {
        const double value = (double)image->value[i];
        if (!(value > 0)) continue;
        mean += value * cell;
        square += value * value / (double)density[i] * cell;
    }
    return mean > 0 ? square / (mean * mean) - 1 : 0;
}
