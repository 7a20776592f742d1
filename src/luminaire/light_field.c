// The light field L(u, w) = exp(z) * radiance_unit * scale. Its loss is docs/design.md's: the Kullback-Leibler form
// sum mass L - target log L, whose gradient in z = log L is mass L - target, weighted by L / (L + 0.01) with that
// weight's gradient stopped. Both terms are linear in the data, so noise of any size leaves the minimum where it is.
#include "luminaire/light_field.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "net/kernel.h"

static const float dim = 0.01f; // radiance below which the weight falls off, in radiance units
static const float z_max = 12, z_min = -12; // beyond, only gradients that lead back count

// A NaN, which only a file with absurd weights can give, becomes darkness.
static float clamp_log(float z) { return z > z_min ? (z < z_max ? z : z_max) : z_min; }

enum status light_field_create(struct light_field **field, const struct light_field_options *options,
                               struct error *error) {
    *field = NULL;
    if (!(options->radiance_unit > 0) || !isfinite(options->radiance_unit))
        return error_set(error, STATUS_INVALID, "radiance unit %g must be positive", (double)options->radiance_unit);
    if (!(options->proxy.radius > 0)) return error_set(error, STATUS_INVALID, "the proxy's radius must be positive");
    if (options->anchor_count > ENCODING_MAX_ANCHORS || options->shell_count > ENCODING_MAX_SHELLS)
        return error_set(error, STATUS_INVALID, "at most %d anchors and %d shells are possible", ENCODING_MAX_ANCHORS,
                         ENCODING_MAX_SHELLS);
    struct light_field *f = calloc(1, sizeof *f);
    struct encoding_options *encoding = calloc(1, sizeof *encoding);
    enum status status = STATUS_OK;
    if (!f || !encoding)
        status = error_set(error, STATUS_MEMORY, "out of memory for a light field");
    else {
        float inverse = 1 / options->proxy.radius;
        encoding->anchor_count = (int)options->anchor_count;
        for (size_t i = 0; i < options->anchor_count; i++)
            for (int a = 0; a < 3; a++)
                encoding->anchors[i][a] = (options->anchors[i][a] - options->proxy.center[a]) * inverse;
        encoding->anchor_radius = options->anchor_count ? options->anchor_radius * inverse : 0;
        encoding->shell_count = (int)options->shell_count;
        for (size_t i = 0; i < options->shell_count; i++) encoding->shells[i] = options->shell_radii[i];
        encoding->use_grid4 = options->use_grid4;
        encoding->log2_entries = options->log2_entries;
        struct trainer_rates rates = {.table = 1e-2f, .mlp = 3e-3f, .end = 1.0f / 100, .steps = options->steps};
        f->radiance_unit = options->radiance_unit;
        for (int c = 0; c < 3; c++) f->scale[c] = 1;
        status = field_net_create(&f->net, options->proxy.center, options->proxy.radius, encoding, &rates,
                                  options->seed, error);
        f->loss = options->loss;
    }
    free(encoding);
    if (status)
        free(f);
    else
        *field = f;
    return status;
}

void light_field_destroy(struct light_field *field) {
    if (field) field_net_fini(&field->net);
    free(field);
}

struct job {
    const struct field_net *net;
    const struct line_sample *samples;
    enum light_loss loss;
};

static void job_encode(const void *user, size_t first, int count, struct grid_input *input) {
    const struct job *job = user;
    struct line_block lines;
    float point[NET_LANES][3], w[NET_LANES][3];
    for (int l = 0; l < count; l++)
        for (int a = 0; a < 3; a++) {
            point[l][a] = job->samples[first + (size_t)l].point[a];
            w[l][a] = job->samples[first + (size_t)l].w[a];
        }
    line_block_load(&lines, job->net->center, job->net->radius, count, (const float(*)[3])point, (const float(*)[3])w);
    encoding_encode(&job->net->encoding, &lines, input);
}

// Both losses have this form: of `count` lines with L [FIELD_OUTPUTS][NET_LANES] in radiance units.
static double likelihood_loss(const struct line_sample *samples, int count, const float *z, const float *radiance,
                              float *d_z) {
    double loss = 0;
    for (int c = 0; c < FIELD_OUTPUTS; c++)
        for (int l = 0; l < count; l++) {
            const int i = c * NET_LANES + l;
            const struct line_sample *sample = &samples[l];
            float gradient = sample->mass * radiance[i] - sample->target[c];
            d_z[i] = gradient * radiance[i] / (radiance[i] + dim);
            loss += (double)(sample->mass * radiance[i] - sample->target[c] * z[i]);
        }
    return loss;
}

static double logarithm_loss(const struct line_sample *samples, int count, const float *z, const float *radiance,
                             float *d_z) {
    (void)z;
    double loss = 0;
    for (int c = 0; c < FIELD_OUTPUTS; c++)
        for (int l = 0; l < count; l++) {
            const int i = c * NET_LANES + l;
            const struct line_sample *sample = &samples[l];
            d_z[i] = 0;
            if (!(sample->mass > 0)) continue;
            float difference = log1pf(radiance[i]) - log1pf(sample->target[c] / sample->mass);
            d_z[i] = sample->mass * 2 * difference * radiance[i] / (1 + radiance[i]);
            loss += (double)(sample->mass * difference * difference);
        }
    return loss;
}

static double (*const losses[LIGHT_LOSSES])(const struct line_sample *samples, int count, const float *z,
                                            const float *radiance, float *d_z) = {
    [LIGHT_LOSS_LIKELIHOOD] = likelihood_loss, [LIGHT_LOSS_LOGARITHM] = logarithm_loss};

static double light_loss(const void *user, size_t first, int count, const float *z, float *d_z) {
    const struct job *job = user;
    _Alignas(64) float radiance[FIELD_OUTPUTS * NET_LANES];
    for (int i = 0; i < FIELD_OUTPUTS * NET_LANES; i++) radiance[i] = clamp_log(z[i]), d_z[i] = 0;
    kernel_best()->exponential(radiance, FIELD_OUTPUTS * NET_LANES);
    double loss = losses[job->loss](job->samples + first, count, z, radiance, d_z);
    for (int i = 0; i < FIELD_OUTPUTS * NET_LANES; i++) // d_z has the gradient's sign
        if ((z[i] > z_max && d_z[i] < 0) || (z[i] < z_min && d_z[i] > 0)) d_z[i] = 0;
    return loss;
}

void light_field_train(struct light_field *field, const struct line_sample *samples, size_t n, int threads,
                       double *loss) {
    struct job job = {&field->net, samples, field->loss};
    double sum = trainer_step(field->net.trainer, &(struct trainer_batch){n, &job, job_encode, light_loss}, threads);
    if (loss) *loss = sum;
}

void light_field_plan(struct light_field *field, size_t steps) { field->net.trainer->rates.steps = steps; }

// The colour is kept.
static void keep_below_ceiling(const struct light_field *field, const float passed[NET_LANES], float *radiance) {
    const float beyond = anchor_contract(field->ceiling_offset);
    for (int l = 0; l < NET_LANES; l++) {
        const float mean = (radiance[l] + radiance[NET_LANES + l] + radiance[2 * NET_LANES + l]) / 3;
        const float factor = passed[l] > beyond && mean > field->ceiling ? field->ceiling / mean : 1;
        for (int c = 0; c < FIELD_OUTPUTS; c++) radiance[c * NET_LANES + l] *= factor;
    }
}

void light_field_eval(const struct light_field *field, size_t n, const float (*point)[3], const float (*w)[3],
                      float (*radiance)[3]) {
    for (size_t first = 0; first < n; first += NET_LANES) {
        int count = (int)(n - first < NET_LANES ? n - first : NET_LANES);
        _Alignas(64) float z[FIELD_OUTPUTS * NET_LANES];
        float hit[NET_LANES], passed[NET_LANES];
        field_net_eval(&field->net, count, point + first, w + first, NULL, z, hit, field->ceiling > 0 ? passed : NULL);
        for (int i = 0; i < FIELD_OUTPUTS * NET_LANES; i++) z[i] = clamp_log(z[i]);
        kernel_best()->exponential(z, FIELD_OUTPUTS * NET_LANES);
        if (field->ceiling > 0) keep_below_ceiling(field, passed, z);
        for (int l = 0; l < count; l++)
            for (int c = 0; c < 3; c++)
                radiance[first + (size_t)l][c] = z[c * NET_LANES + l] * field->radiance_unit * field->scale[c] * hit[l];
    }
}

enum status light_field_finish(struct light_field *field, struct error *error) {
    return field_net_finish(&field->net, error);
}

size_t light_field_bytes(const struct light_field *field) { return field_net_bytes(&field->net); }

void light_field_set_scale(struct light_field *field, const float scale[3]) {
    for (int c = 0; c < 3; c++) field->scale[c] = scale[c];
}
