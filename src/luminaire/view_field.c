// Inputs of the network: a 3D hash grid at the surface point, a 4D one of (point seen from the centre, direction), a 2D
// one of the mirrored direction, an entry for the part, the plain vectors, and how the anchors, the centres of the
// emission, are seen: mirrored in the surface (the angle between its normal and the half vector, on which every
// microfacet highlight depends, with a 3D grid an anchor for whether its light gets to the point), and straight on
// through it (the offset of the line from the nearest one, with a 2D grid an anchor). The loss is the light field's,
// whose noise-proof form docs/design.md has, with the weight's exponent chosen for pictures: errors relative to L count
// nearly alike from 0.1 radiance units on.
#include "luminaire/view_field.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "luminaire/hull.h"
#include "net/kernel.h"

enum {
    OUTPUTS = 3,
    WIDTH = 64,
    POINT_LEVELS = 8,
    LINE_LEVELS = 4,
    MIRROR_LEVELS = 2,
    ANCHOR_LEVELS = 2,
    LIT_LEVELS = 2,
    MORE_ANCHOR_BITS = 1, // than of the other levels
    RAW_COUNT = 18,
    MAX_CORNERS = GRID_MAX_LOOKUPS * (GRID_MAX_DIMS + 1)
};
enum { SET_POINT, SET_LINE, SET_MIRROR, SET_PART, SET_ANCHOR, SET_LIT };
static const float anchor_reach = 0.1f; // [proxy radius]
static const float dim = 0.1f; // [radiance units]
static const float view_exponent = 1.5f;
static const float z_max = 12, z_min = -12;

static int resolution(int k, int count, float first, float last) {
    return (int)lrintf(first * powf(last / first, (float)k / (float)(count - 1)));
}

static enum status set_up(struct view_field *field, const struct view_field_options *options, struct error *error) {
    if (options->part_count < 1 || options->part_count > HULL_MAX_PARTS)
        return error_set(error, STATUS_INVALID, "%d parts of a hull are not between 1 and %d", options->part_count,
                         HULL_MAX_PARTS);
    if (options->log2_entries < 10 || options->log2_entries > 20)
        return error_set(error, STATUS_INVALID, "table size 2^%d is out of range; use 10 to 20", options->log2_entries);
    if (!(options->radiance_unit > 0) || !isfinite(options->radiance_unit) || !(options->radius > 0))
        return error_set(error, STATUS_INVALID, "the view field's radiance unit and radius must be positive");
    if (options->anchor_count < 0 || options->anchor_count > VIEW_MAX_ANCHORS)
        return error_set(error, STATUS_INVALID, "at most %d anchors of a view are possible", VIEW_MAX_ANCHORS);
    for (int i = 0; i < options->anchor_count; i++)
        for (int a = 0; a < 3; a++)
            if (!(fabsf(options->anchors[i][a] - options->center[a]) <= 10 * options->radius))
                return error_set(error, STATUS_INVALID, "anchor %d of the view is far outside the proxy", i);
    *field = (struct view_field){.options = *options, .scale = {1, 1, 1}};
    struct grid_layout *layout = &field->layout;
    int log2_entries = options->log2_entries;
    for (int k = 0; k < POINT_LEVELS; k++)
        grid_add_lookup(layout, grid_add_level(layout, 3, resolution(k, POINT_LEVELS, 8, 400), log2_entries, 1),
                        SET_POINT);
    for (int k = 0; k < LINE_LEVELS; k++)
        grid_add_lookup(layout, grid_add_level(layout, 4, resolution(k, LINE_LEVELS, 5, 32), log2_entries, 1),
                        SET_LINE);
    for (int k = 0; k < MIRROR_LEVELS; k++)
        grid_add_lookup(layout, grid_add_level(layout, 2, k ? 64 : 16, log2_entries, 1), SET_MIRROR);
    grid_add_lookup(layout, grid_add_level(layout, 1, 1, log2_entries, (uint32_t)options->part_count), SET_PART);
    int slice_bits = log2_entries + MORE_ANCHOR_BITS; // of all slices of a level together
    for (int n = options->anchor_count; n > 1; n = (n + 1) / 2) slice_bits--;
    for (int k = 0; k < ANCHOR_LEVELS && options->anchor_count; k++)
        grid_add_lookup(layout, grid_add_level(layout, 2, k ? 48 : 16, slice_bits, (uint32_t)options->anchor_count),
                        SET_ANCHOR);
    for (int k = 0; k < LIT_LEVELS && options->anchor_count; k++)
        grid_add_lookup(layout, grid_add_level(layout, 3, k ? 48 : 16, slice_bits, (uint32_t)options->anchor_count),
                        SET_LIT);
    layout->raw_count = RAW_COUNT;
    field->shape = (struct mlp_shape){grid_input_count(layout), WIDTH, OUTPUTS};
    return STATUS_OK;
}

enum status view_field_create(struct view_field **result, const struct view_field_options *options, size_t steps,
                              uint64_t seed, struct error *error) {

    struct view_field *field = *result = calloc(1, sizeof *field);
    if (!field) return error_set(error, STATUS_MEMORY, "out of memory for a view field");
    enum status status = set_up(field, options, error);
    if (!status && !(field->trainer = malloc(sizeof *field->trainer)))
        status = error_set(error, STATUS_MEMORY, "out of memory for a view field");
    if (!status) {
        struct trainer_rates rates = {.table = 1e-2f, .mlp = 3e-3f, .end = 1.0f / 100, .steps = steps};
        status = trainer_init(field->trainer, &field->layout, WIDTH, OUTPUTS, &rates, seed, error);
        if (status) {
            free(field->trainer);
            field->trainer = NULL;
        }
    }
    if (status) {
        view_field_destroy(field);
        *result = NULL;
    }
    return status;
}

static enum status allocate_finished(struct view_field *field, struct error *error) {
    field->mlp = calloc(mlp_layout(&field->shape).count, sizeof(float));
    field->codes = calloc((size_t)field->layout.entry_count * 2 + GRID_PADDING, 1);
    return field->mlp && field->codes ? STATUS_OK : error_set(error, STATUS_MEMORY, "out of memory for a view field");
}

enum status view_field_restore(struct view_field **result, const struct view_field_options *options, const float *mlp,
                               size_t mlp_count, const int8_t *codes, size_t code_count, const float *table_scale,
                               size_t level_count, struct error *error) {
    struct view_field *field = *result = calloc(1, sizeof *field);
    if (!field) return error_set(error, STATUS_MEMORY, "out of memory for a view field");
    enum status status = set_up(field, options, error);
    if (!status && (mlp_count != mlp_layout(&field->shape).count || level_count != (size_t)field->layout.level_count ||
                    code_count != 2 * (size_t)field->layout.entry_count))
        status =
            error_set(error, STATUS_INVALID, "the view field's tables do not fit the network that the file describes");
    if (!status) status = allocate_finished(field, error);
    if (status) {
        view_field_destroy(field);
        *result = NULL;
        return status;
    }
    memcpy(field->mlp, mlp, mlp_count * sizeof(float));
    memcpy(field->codes, codes, code_count);
    memcpy(field->table_scale, table_scale, level_count * sizeof(float));
    return STATUS_OK;
}

void view_field_destroy(struct view_field *field) {
    if (!field) return;
    if (field->trainer) trainer_fini(field->trainer);
    free(field->trainer);
    free(field->mlp);
    free(field->codes);
    free(field);
}

void view_field_plan(struct view_field *field, size_t steps) { field->trainer->rates.steps = steps; }

enum status view_field_finish(struct view_field *field, struct error *error) {
    if (!field->trainer) return STATUS_OK;
    enum status status = allocate_finished(field, error);
    if (status) return status;
    memcpy(field->mlp, field->trainer->mlp, field->trainer->mlp_count * sizeof(float));
    grid_quantise(&field->layout, field->trainer->table, field->codes, field->table_scale);
    trainer_fini(field->trainer);
    free(field->trainer);
    field->trainer = NULL;
    return STATUS_OK;
}

size_t view_field_bytes(int log2_entries, size_t anchor_count) {
    const struct view_field_options options = {.radius = 1,
                                               .part_count = 1,
                                               .log2_entries = log2_entries,
                                               .radiance_unit = 1,
                                               .anchor_count = (int)anchor_count};
    struct view_field field;
    if (set_up(&field, &options, NULL)) return 0;
    return mlp_layout(&field.shape).count * sizeof *field.mlp + 2 * (size_t)field.layout.entry_count;
}

static void store_octahedral(float (*set)[NET_LANES], int l, vec3 w) { // to [0,1]^2
    float scale = 1 / (fabsf(w.x) + fabsf(w.y) + fabsf(w.z) + 1e-20f), x = w.x * scale, y = w.y * scale;
    float folded_x = (1 - fabsf(y)) * (x < 0 ? -1.0f : 1.0f), folded_y = (1 - fabsf(x)) * (y < 0 ? -1.0f : 1.0f);
    set[0][l] = 0.5f + 0.5f * (w.z < 0 ? folded_x : x);
    set[1][l] = 0.5f + 0.5f * (w.z < 0 ? folded_y : y);
}

struct anchor_view {
    float tangent2, mirror_distance2; // of the anchor best aligned: tan^2 between normal and half vector
    vec3 offset; // of the nearest anchor from the line
    float offset2;
    int nearest, mirrored;
};

static struct anchor_view view_anchors(const struct view_field_options *options, vec3 p, vec3 n, vec3 w) {
    struct anchor_view view = {1e4f, 1, {1, 0, 0}, 1, 0, 0};
    float best = 0, closest = INFINITY;
    const float inverse = 1 / options->radius;
    for (int i = 0; i < options->anchor_count; i++) {
        const float *a = options->anchors[i];
        vec3 to = vec3_sub(vec3_make((a[0] - options->center[0]) * inverse, (a[1] - options->center[1]) * inverse,
                                     (a[2] - options->center[2]) * inverse),
                           p);
        float distance2 = vec3_dot(to, to) + 1e-8f;
        vec3 half = vec3_mad(to, 1 / sqrtf(distance2), w);
        float cosine = vec3_dot(to, n) > 0 ? vec3_dot(half, n) : 0; // behind the surface: no highlight
        float cosine2 = cosine > 0 ? sqrf(cosine) / (vec3_dot(half, half) + 1e-12f) : 0;
        if (cosine2 > best) {
            best = cosine2;
            view.mirror_distance2 = distance2;
            view.mirrored = i;
        }
        vec3 offset = vec3_mad(w, -vec3_dot(to, w), to);
        float offset2 = vec3_dot(offset, offset);
        if (offset2 < closest) {
            closest = view.offset2 = offset2;
            view.offset = offset;
            view.nearest = i;
        }
    }
    if (best > 1e-4f) view.tangent2 = best < 1 ? (1 - best) / best : 0;
    return view;
}

static void encode_lane(const struct view_field_options *options, const struct view_point *at, int l,
                        struct grid_input *input) {
    const float inverse = 1 / options->radius;
    vec3 p = vec3_make((at->point[0] - options->center[0]) * inverse, (at->point[1] - options->center[1]) * inverse,
                       (at->point[2] - options->center[2]) * inverse);
    vec3 w = vec3_from(at->w), n = vec3_from(at->normal);
    float cosine = vec3_dot(n, w);
    if (cosine < 0) {
        n = vec3_neg(n);
        cosine = -cosine;
    }
    vec3 mirrored = vec3_sub(vec3_scale(n, 2 * cosine), w);
    struct anchor_view view = view_anchors(options, p, n, w);
    struct frame frame = frame_from_normal(w);
    float scale = 1 / anchor_reach, r2 = view.offset2 * scale * scale, r = sqrtf(r2);
    float contract = r > 1 ? (2 - 1 / r) / r : 1, t2 = view.tangent2;
    const float raw[RAW_COUNT] = {p.x,
                                  p.y,
                                  p.z,
                                  n.x,
                                  n.y,
                                  n.z,
                                  w.x,
                                  w.y,
                                  w.z,
                                  cosine,
                                  contract * r,
                                  1 / (1 + 4 * r2),
                                  0.5f * logf(1e-4f + t2),
                                  0.5f * logf(1e-2f + t2),
                                  1 / (1 + 1000 * t2),
                                  1 / (1 + 60 * t2),
                                  1 / (1 + 4 * t2),
                                  0.5f * logf(view.mirror_distance2)};
    for (int i = 0; i < RAW_COUNT; i++) input->raw[i][l] = raw[i];
    for (int a = 0; a < 3; a++) input->set[SET_POINT][a][l] = input->set[SET_LIT][a][l] = 0.5f + 0.5f * raw[a];
    store_octahedral(input->set[SET_LINE], l, p);
    store_octahedral(input->set[SET_LINE] + 2, l, w);
    store_octahedral(input->set[SET_MIRROR], l, mirrored);
    input->set[SET_PART][0][l] = 0;
    input->set[SET_ANCHOR][0][l] = 0.5f + 0.25f * contract * scale * vec3_dot(view.offset, frame.s);
    input->set[SET_ANCHOR][1][l] = 0.5f + 0.25f * contract * scale * vec3_dot(view.offset, frame.t);
    input->slice[SET_POINT][l] = input->slice[SET_LINE][l] = input->slice[SET_MIRROR][l] = 0;
    input->slice[SET_PART][l] = (int32_t)at->part;
    input->slice[SET_ANCHOR][l] = view.nearest;
    input->slice[SET_LIT][l] = view.mirrored;
}

struct job {
    const struct view_field *field;
    const struct view_sample *samples;
};

static void job_encode(const void *user, size_t first, int count, struct grid_input *input) {
    const struct job *job = user;
    for (int l = 0; l < NET_LANES; l++)
        encode_lane(&job->field->options, &job->samples[first + (size_t)(l < count ? l : count - 1)].at, l, input);
}

// A NaN, which only a file with absurd weights can give, becomes darkness.
static float clamp_log(float z) { return z > z_min ? (z < z_max ? z : z_max) : z_min; }

static double job_loss(const void *user, size_t first, int count, const float *z, float *d_z) {
    const struct job *job = user;
    _Alignas(64) float radiance[OUTPUTS * NET_LANES];
    for (int i = 0; i < OUTPUTS * NET_LANES; i++) radiance[i] = clamp_log(z[i]);
    kernel_best()->exponential(radiance, OUTPUTS * NET_LANES);
    double loss = 0;
    for (int c = 0; c < OUTPUTS; c++)
        for (int l = 0; l < NET_LANES; l++) {
            int i = c * NET_LANES + l;
            d_z[i] = 0;
            if (l >= count) continue;
            const struct view_sample *sample = &job->samples[first + (size_t)l];
            float gradient = sample->mass * radiance[i] - sample->target[c];
            if ((z[i] > z_max && gradient < 0) || (z[i] < z_min && gradient > 0)) continue;
            d_z[i] = gradient * radiance[i] / powf(radiance[i] + dim, view_exponent);
            loss += (double)(sample->mass * radiance[i] - sample->target[c] * z[i]);
        }
    return loss;
}

void view_field_train(struct view_field *field, const struct view_sample *samples, size_t n, int threads,
                      double *loss) {
    struct job job = {field, samples};
    double sum = trainer_step(field->trainer, &(struct trainer_batch){n, &job, job_encode, job_loss}, threads);
    if (loss) *loss = sum;
}

static void forward_block(const struct view_field *field, const struct grid_input *input, float *z) {
    const struct kernel *kernel = kernel_best();
    const struct grid_layout *layout = &field->layout;
    _Alignas(64) float x[MLP_MAX_INPUTS * NET_LANES], h1[WIDTH * NET_LANES], h2[WIDTH * NET_LANES];
    if (field->trainer) {
        _Alignas(64) int32_t index[MAX_CORNERS * NET_LANES];
        _Alignas(64) float weight[MAX_CORNERS * NET_LANES];
        kernel->index(layout, input, index, weight);
        kernel->gather_float(layout, field->trainer->table, input, index, weight, x);
    } else
        kernel->lookup(layout, field->codes, field->table_scale, input, x);
    kernel->forward(&field->shape, field->trainer ? field->trainer->mlp : field->mlp, x, h1, h2, z);
}

void view_field_eval(const struct view_field *field, size_t n, const struct view_point *points, float (*radiance)[3]) {
    struct grid_input input;
    _Alignas(64) float z[OUTPUTS * NET_LANES];
    for (size_t first = 0; first < n; first += NET_LANES) {
        size_t count = n - first < NET_LANES ? n - first : NET_LANES;
        for (int l = 0; l < NET_LANES; l++)
            encode_lane(&field->options, &points[first + ((size_t)l < count ? (size_t)l : count - 1)], l, &input);
        forward_block(field, &input, z);
        for (int i = 0; i < OUTPUTS * NET_LANES; i++) z[i] = clamp_log(z[i]);
        kernel_best()->exponential(z, OUTPUTS * NET_LANES);
        for (size_t l = 0; l < count; l++)
            for (int c = 0; c < 3; c++)
                radiance[first + l][c] = z[(size_t)c * NET_LANES + l] * field->options.radiance_unit * field->scale[c];
    }
}
