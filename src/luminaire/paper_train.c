// Training of the three networks: inputs and losses.
#include <math.h>
#include <string.h>

#include "luminaire/paper_private.h"

enum status paper_train_begin(struct paper *paper, enum paper_net net, size_t most, uint64_t seed,
                              struct error *error) {
    enum status status = dense_trainer_init(&paper->trainer, &paper_shapes[net], most, seed + (uint64_t)net, error);
    if (status == STATUS_OK) paper->training = (int)net;
    return status;
}

void paper_train_end(struct paper *paper, enum paper_net net) {
    memcpy(paper->parameters[net], paper->trainer.parameters, paper_parameters(net) * sizeof(float));
    dense_packed_set(&paper->packed[net], paper->parameters[net]);
    dense_trainer_fini(&paper->trainer);
    paper->training = -1;
}

struct line_job {
    const struct paper *paper;
    const struct line_sample *samples;
    float scale; // of the masses, so that the loss is a mean
};

static void line_inputs(const void *user, size_t first, int count, float *x) {
    const struct line_job *job = user;
    float point[DENSE_SLICE][3], w[DENSE_SLICE][3], hit[DENSE_SLICE];
    for (int l = 0; l < count; l++) {
        memcpy(point[l], job->samples[first + (size_t)l].point, sizeof point[l]);
        memcpy(w[l], job->samples[first + (size_t)l].w, sizeof w[l]);
    }
    paper_encode_lines(job->paper, count, (const float(*)[3])point, (const float(*)[3])w, x, hit);
}

static double eval_loss(const void *user, size_t first, int count, const float *z, float *d_z) {
    const struct line_job *job = user;
    double loss = 0;
    for (int l = 0; l < count; l++) {
        const struct line_sample *sample = &job->samples[first + (size_t)l];
        if (!(sample->mass > 0)) continue;
        float weight = sample->mass * job->scale;
        for (int c = 0; c < 3; c++) {
            float difference = z[c * DENSE_SLICE + l] - log1pf(sample->target[c] / sample->mass);
            d_z[c * DENSE_SLICE + l] = 2 * weight * difference;
            loss += (double)(weight * difference * difference);
        }
    }
    return loss;
}

static double transparency_loss(const void *user, size_t first, int count, const float *z, float *d_z) {
    const struct line_job *job = user;
    double loss = 0;
    _Alignas(64) float t[3 * DENSE_SLICE];
    memcpy(t, z, sizeof t);
    paper_sigmoid(t, 3 * DENSE_SLICE);
    for (int l = 0; l < count; l++)
        for (int c = 0; c < 3; c++) {
            float value = t[c * DENSE_SLICE + l];
            float difference = log1pf(value) - log1pf(job->samples[first + (size_t)l].target[c]);
            d_z[c * DENSE_SLICE + l] = 2 * job->scale * difference / (1 + value) * value * (1 - value);
            loss += (double)(job->scale * difference * difference);
        }
    return loss;
}

void paper_train_lines(struct paper *paper, enum paper_net net, const struct line_sample *samples, size_t n,
                       int threads, double *loss) {
    struct line_job job = {paper, samples, 1 / (3 * (float)n)};
    if (net == PAPER_EVAL) job.scale /= LINE_MEASURE(paper->radius);
    struct dense_batch batch = {n, &job, line_inputs, net == PAPER_EVAL ? eval_loss : transparency_loss};
    *loss = dense_trainer_step(&paper->trainer, &batch, threads);
}

struct view_job {
    const struct paper *paper;
    const struct paper_view *views;
    size_t n;
};

static void view_inputs(const void *user, size_t first, int count, float *x) {
    const struct view_job *job = user;
    float s[DENSE_SLICE][3];
    for (int l = 0; l < count; l++) memcpy(s[l], job->views[first + (size_t)l].s, sizeof s[l]);
    paper_encode_points(job->paper, count, (const float(*)[3])s, x);
}

// The mean over pixels and channels, and the same of the pictures' means.
static double view_loss(const void *user, size_t first, int count, const float *z, float *d_z) {
    const struct view_job *job = user;
    const float pixel_share = 1 / (3.0f * PAPER_PIXELS * (float)job->n), mean_share = 1 / (3 * (float)job->n);
    double loss = 0;
    for (int l = 0; l < count; l++) {
        const struct paper_view *view = &job->views[first + (size_t)l];
        float mean[3] = {0, 0, 0};
        for (int pixel = 0; pixel < PAPER_PIXELS; pixel++)
            for (int c = 0; c < 3; c++) {
                int at = (3 * pixel + c) * DENSE_SLICE + l;
                float difference = z[at] - log1pf(view->radiance[pixel][c]);
                d_z[at] = 2 * pixel_share * difference;
                loss += (double)(pixel_share * difference * difference);
                mean[c] += difference / PAPER_PIXELS;
            }
        for (int c = 0; c < 3; c++) {
            loss += (double)(mean_share * mean[c] * mean[c]);
            for (int pixel = 0; pixel < PAPER_PIXELS; pixel++)
                d_z[(3 * pixel + c) * DENSE_SLICE + l] += 2 * mean_share * mean[c] / PAPER_PIXELS;
        }
    }
    return loss;
}

void paper_train_views(struct paper *paper, const struct paper_view *views, size_t n, int threads, double *loss) {
    struct view_job job = {paper, views, n};
    struct dense_batch batch = {n, &job, view_inputs, view_loss};
    *loss = dense_trainer_step(&paper->trainer, &batch, threads);
}
