// Lines are drawn uniformly, as cameras around the lamp see it, and followed through clear glass to the surface where
// they end. They bring the light there themselves, or particles do, each to where it was last on such a surface: clear
// glass treats both directions alike, so the two meet in the same measure. A fixed number of lines and of particles
// makes a chunk.
#include "bake/view_bake.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bake/hull_build.h"
#include "base/parallel.h"
#include "math/warp.h"
#include "trace/line_view.h"
#include "trace/particle_exit.h"

enum {
    VIEW_STEPS = 16,
    VIEW_BATCH = 4096,
    BLOCK = 1024,
    PILOT_LINES = 1 << 16,
    MAX_DEPTH = 100,
    MOST_SCALE_CHUNKS = 16
};
static const double least_share = 0.02, least_exit_rate = 0.05; // of lines that end on a surface, of particles

struct view_training {
    const struct lamp *lamp;
    const struct hull_map *map;
    enum gather_stream stream;
    size_t first, count; // of the running gathering: lines or particles
    bool particles, trace; // particles, or lines with or without their light
    struct view_sample *to;
    size_t *block_counts; // of a block's samples
    struct view_sample *lines, *exits, *batch; // of one chunk, a slot each; of one step
};

struct view_counts { // of one chunk
    size_t lines, particles;
};

static void describe(const struct view_training *training, const struct surface *surface, vec3 w,
                     struct view_sample *sample) {
    sample->at.part = training->map->part[surface->shape->index];
    vec3_store(sample->at.point, surface->p);
    vec3_store(sample->at.normal, surface->shading.n);
    vec3_store(sample->at.w, w);
}

static bool draw_line(const struct view_training *training, size_t index, struct view_sample *sample) {
    const struct lamp *lamp = training->lamp;
    const struct proxy *proxy = &lamp->proxy;
    struct sampler sampler = sampler_make(lamp->seed, (uint64_t)training->stream << 56, index);
    vec3 w = warp_uniform_sphere(sampler_2d(&sampler)), center = {proxy->center[0], proxy->center[1], proxy->center[2]};
    vec2 disk = warp_concentric_disk(sampler_2d(&sampler));
    struct frame frame = frame_from_normal(w);
    vec3 start = frame_world_from_local(&frame, (vec3){disk.x, disk.y, 1.001f});
    struct ray ray = {vec3_mad(start, proxy->radius, center), vec3_neg(w), 0, INFINITY};
    struct line_view view;
    if (!trace_line_view(lamp->scene, training->map->glass, &ray, &sampler, &view)) return false;
    describe(training, &view.surface, vec3_neg(view.ray.direction), sample);
    sample->mass = view.weight;
    if (!training->trace) return true;
    struct line_hit hit;
    trace_line_radiance(lamp->scene, &view.ray, &sampler, lamp->aims, lamp->aim_count, MAX_DEPTH, &hit);
    rgb light = rgb_scale(hit.radiance, view.weight);
    vec3_store(sample->target, (vec3){light.r, light.g, light.b});
    return rgb_is_finite(light);
}

static bool draw_particle(const struct view_training *training, size_t index, struct view_sample *sample) {
    struct sampler sampler = sampler_make(training->lamp->seed, (uint64_t)training->stream << 56 | 1, index);
    struct particle_exit exit;
    struct particle_source source;
    trace_particle_source(training->lamp->scene, training->map->glass, &sampler, MAX_DEPTH, &exit, &source);
    if (!exit.escaped || !source.surface.shape || !rgb_is_finite(source.flux)) return false;
    describe(training, &source.surface, source.direction, sample);
    vec3_store(sample->target, (vec3){source.flux.r, source.flux.g, source.flux.b});
    return true;
}

static void draw_block(void *user, size_t block, int worker) {
    (void)worker;
    struct view_training *training = user;
    size_t begin = block * BLOCK, end = begin + BLOCK < training->count ? begin + BLOCK : training->count, count = 0;
    for (size_t i = begin; i < end; i++) {
        struct view_sample *slot = &training->to[begin + count];
        *slot = (struct view_sample){.mass = 0};
        count += training->particles ? draw_particle(training, training->first + i, slot)
                                     : draw_line(training, training->first + i, slot);
    }
    training->block_counts[block] = count;
}

// Samples into `to`, which has a slot for each of the `count` lines or particles, in their order. Targets: radiance or
// flux.
static size_t gather_views(struct view_training *training, enum gather_stream stream, bool particles, bool trace,
                           size_t first, size_t count, struct view_sample *to) {
    training->stream = stream;
    training->particles = particles;
    training->trace = trace;
    training->first = first;
    training->count = count;
    training->to = to;
    size_t blocks = (count + BLOCK - 1) / BLOCK, found = 0;
    parallel_for(training->lamp->threads, blocks, draw_block, training);
    for (size_t b = 0; b < blocks; b++) {
        memmove(to + found, to + b * BLOCK, training->block_counts[b] * sizeof *to);
        found += training->block_counts[b];
    }
    return found;
}

static void release(struct view_training *training) {
    free(training->lines);
    free(training->exits);
    free(training->batch);
    free(training->block_counts);
    training->lines = training->exits = training->batch = NULL;
    training->block_counts = NULL;
}

static bool make_room(struct view_training *training, const struct view_counts *counts) {
    release(training);
    size_t most = counts->lines > counts->particles ? counts->lines : counts->particles;
    training->lines = malloc((counts->lines + 1) * sizeof *training->lines);
    training->exits = malloc((counts->particles + 1) * sizeof *training->exits);
    training->batch = malloc((counts->lines + counts->particles + 1) * sizeof *training->batch);
    training->block_counts = malloc((most / BLOCK + 1) * sizeof *training->block_counts);
    return training->lines && training->exits && training->batch && training->block_counts;
}

// The last step: the field's integral over looking lines against the light of those that were traced or of the exits,
// colour by colour.
static enum status scale_field(struct view_training *training, struct view_field *field, enum data_source data,
                               const struct view_counts *counts, size_t chunks, struct error *error) {
    const bool particles = data == DATA_PARTICLES;
    const double measure = (double)LINE_MEASURE(training->lamp->proxy.radius);
    double shown[3] = {0, 0, 0}, traced[3] = {0, 0, 0};
    for (size_t k = 0; k < chunks; k++) {
        size_t count = gather_views(training, STREAM_VIEW_SCALE, false, !particles, k * counts->lines, counts->lines,
                                    training->lines);
        struct view_point *points = malloc((count + 1) * sizeof *points);
        float(*radiance)[3] = malloc((count + 1) * sizeof *radiance);
        if (points && radiance) {
            for (size_t i = 0; i < count; i++) points[i] = training->lines[i].at;
            view_field_eval(field, count, points, radiance);
            for (size_t i = 0; i < count; i++)
                for (int c = 0; c < 3; c++) {
                    shown[c] += (double)(radiance[i][c] * training->lines[i].mass) / (double)counts->lines;
                    traced[c] += (double)training->lines[i].target[c] / (double)counts->lines;
                }
        }
        free(points);
        free(radiance);
        if (!points || !radiance) return error_set(error, STATUS_MEMORY, "out of memory for the view field's scale");
        if (!particles) continue;
        count = gather_views(training, STREAM_VIEW_SCALE, true, true, k * counts->particles, counts->particles,
                             training->exits);
        for (size_t i = 0; i < count; i++)
            for (int c = 0; c < 3; c++)
                traced[c] += (double)training->exits[i].target[c] / ((double)counts->particles * measure);
    }
    for (int c = 0; c < 3; c++) field->scale[c] = shown[c] > 0 ? (float)(traced[c] / shown[c]) : 1;
    return STATUS_OK;
}

// Step `step` of VIEW_STEPS of a chunk with `lines` and `exits` samples, normalised as view_field.h wants it.
static size_t compose_batch(struct view_training *training, const struct view_field *field, size_t lines, size_t exits,
                            enum data_source data, const struct view_counts *counts, size_t step) {
    const float exit_share = data == DATA_CAMERA ? 0 : data == DATA_PARTICLES ? 1 : 0.5f;
    const float unit = field->options.radiance_unit, mass = (float)VIEW_STEPS / (float)counts->lines;
    const float line_scale = (1 - exit_share) * mass / unit;
    const float exit_scale =
        exit_share * (float)VIEW_STEPS / ((float)counts->particles * LINE_MEASURE(training->lamp->proxy.radius) * unit);
    size_t n = 0;
    for (size_t i = lines * step / VIEW_STEPS; i < lines * (step + 1) / VIEW_STEPS; i++) {
        struct view_sample *to = &training->batch[n++];
        *to = training->lines[i];
        to->mass *= mass;
        for (int c = 0; c < 3; c++) to->target[c] *= line_scale;
    }
    for (size_t i = exits * step / VIEW_STEPS; i < exits * (step + 1) / VIEW_STEPS; i++) {
        struct view_sample *to = &training->batch[n++];
        *to = training->exits[i];
        for (int c = 0; c < 3; c++) to->target[c] *= exit_scale;
    }
    return n;
}

// scale_chunks: that the scale is to be found from, half as many as are learned from or less.
static enum status train(struct view_training *training, struct view_field *field, const struct view_plan *plan,
                         const struct view_counts *counts, const struct run *run, size_t *scale_chunks,
                         struct error *error) {
    const double start = clock_wall_s();
    const bool timed = plan->seconds > 0, trace = plan->data != DATA_PARTICLES;
    double end = plan->seconds;
    *scale_chunks = plan->chunks / 2 < MOST_SCALE_CHUNKS ? plan->chunks / 2 + 1 : MOST_SCALE_CHUNKS;
    for (size_t chunk = 0; timed || chunk < plan->chunks; chunk++) {
        double elapsed = clock_wall_s() - start, loss = 0;
        if (timed && chunk > 0) {
            double chunk_s = elapsed / (double)chunk, most = fmax(1, 0.2 * plan->seconds / chunk_s);
            *scale_chunks = most < MOST_SCALE_CHUNKS ? (size_t)most : MOST_SCALE_CHUNKS;
            end = plan->seconds - (double)*scale_chunks * chunk_s;
            if (elapsed >= end) break;
            double left = (end - elapsed) / chunk_s;
            view_field_plan(field, (chunk + (size_t)left + 1) * VIEW_STEPS);
        }
        if (run_cancelled(run)) return error_set(error, STATUS_CANCELLED, "cancelled while the hull was learned");
        size_t exits = 0, lines = gather_views(training, STREAM_VIEW, false, trace, chunk * counts->lines,
                                               counts->lines, training->lines);
        if (plan->data != DATA_CAMERA)
            exits = gather_views(training, STREAM_VIEW, true, true, chunk * counts->particles, counts->particles,
                                 training->exits);
        for (size_t step = 0; step < VIEW_STEPS; step++) {
            size_t n = compose_batch(training, field, lines, exits, plan->data, counts, step);
            if (n) view_field_train(field, training->batch, n, training->lamp->threads, &loss);
        }
        char detail[64];
        snprintf(detail, sizeof detail, "loss %.4f", loss);
        double fraction = timed ? elapsed / plan->seconds : (double)(chunk + 1) / (double)plan->chunks;
        run_progress(run, "hull", fraction < 1 ? fraction : 1, clock_wall_s() - start, detail);
    }
    return STATUS_OK;
}

static enum status learn(struct view_result *result, struct view_training *training, const struct view_plan *plan,
                         const struct run *run, struct error *error) {
    const struct lamp *lamp = training->lamp;
    struct view_counts counts = {PILOT_LINES, PILOT_LINES};
    if (!make_room(training, &counts)) return error_set(error, STATUS_MEMORY, "out of memory for views");
    double share =
        (double)gather_views(training, STREAM_VIEW_PILOT, false, false, 0, PILOT_LINES, training->lines) / PILOT_LINES;
    size_t exits = gather_views(training, STREAM_VIEW_PILOT, true, true, 0, PILOT_LINES, training->exits);
    double exit_rate = (double)exits / PILOT_LINES, flux = 0;
    for (size_t i = 0; i < exits; i++)
        for (int c = 0; c < 3; c++) flux += (double)training->exits[i].target[c] / (3.0 * PILOT_LINES);
    if (!(flux > 0)) return STATUS_OK; // lights without surfaces
    struct view_field_options options = {
        .center = {lamp->proxy.center[0], lamp->proxy.center[1], lamp->proxy.center[2]},
        .radius = lamp->proxy.radius,
        .part_count = (int)result->hull->part_count,
        .log2_entries = plan->log2_entries,
        .anchor_count = (int)lamp->aim_count};
    for (size_t i = 0; i < lamp->aim_count; i++) vec3_store(options.anchors[i], lamp->aims[i].center);
    options.radiance_unit = (float)(flux / (double)LINE_MEASURE(lamp->proxy.radius) / fmax(share, least_share));
    enum status status = view_field_create(&result->field, &options, plan->chunks * VIEW_STEPS, lamp->seed, error);
    if (status) return status;
    double half = plan->data == DATA_CAMERA ? 1 : 0.5;
    counts.lines = (size_t)(half * VIEW_STEPS * VIEW_BATCH / fmax(share, least_share));
    counts.particles = (size_t)((1 - half) * VIEW_STEPS * VIEW_BATCH / fmax(exit_rate, least_exit_rate)) + 1;
    if (!make_room(training, &counts)) return error_set(error, STATUS_MEMORY, "out of memory for views");
    size_t scale_chunks;
    status = train(training, result->field, plan, &counts, run, &scale_chunks, error);
    return status ? status : scale_field(training, result->field, plan->data, &counts, scale_chunks, error);
}

enum status view_bake(struct view_result *result, const struct hull_map *map, const struct lamp *lamp,
                      const struct view_plan *plan, const struct run *run, struct error *error) {
    if (!result->hull) return STATUS_OK;
    struct view_training training = {.lamp = lamp, .map = map};
    enum status status = learn(result, &training, plan, run, error);
    release(&training);
    if (status == STATUS_OK && result->field) return STATUS_OK;
    hull_destroy(result->hull);
    view_field_destroy(result->field);
    *result = (struct view_result){NULL, NULL};
    return status;
}
