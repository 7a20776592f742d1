// Parallel blocks of traced samples. A block's particles write into the block's own slots and the blocks are joined in
// order, so that the result does not depend on the threads.
#include "bake/gather.h"

#include <stdlib.h>
#include <string.h>

#include "bake/line_guide.h"
#include "base/parallel.h"
#include "math/warp.h"
#include "trace/particle_exit.h"

enum { BLOCK = 2048, BLOCKS_PER_LOOK = 128, MAX_DEPTH = 100, AGREEING = 64 };
static const float straight_cos = 0.866f; // light turned by less than 30 degrees counts as having come through

struct particle_job {
    const struct lamp *lamp;
    uint64_t stream;
    size_t first, n, first_block;
    struct line_exit *exits; // slots of all particles of the call
    vec3 *origins; // or NULL
    size_t (*counts)[2]; // exits of each block, rays traced for it
};

static void trace_particle_block(void *user, size_t index, int worker) {
    (void)worker;
    const struct particle_job *job = user;
    const size_t block = job->first_block + index;
    const struct proxy *proxy = &job->lamp->proxy;
    vec3 center = vec3_from(proxy->center);
    size_t begin = block * BLOCK, end = begin + BLOCK < job->n ? begin + BLOCK : job->n, count = 0, rays = 0;
    for (size_t i = begin; i < end; i++) {
        struct sampler sampler = sampler_make(job->lamp->seed, job->stream, job->first + i);
        struct particle_exit exit;
        trace_particle(job->lamp->scene, &sampler, MAX_DEPTH, &exit);
        rays += (size_t)exit.rays;
        if (!exit.escaped) continue;
        vec3 p = vec3_sub(exit.point, center); // onto the bounding sphere
        float b = vec3_dot(p, exit.direction), c = vec3_dot(p, p) - sqrf(proxy->radius);
        float t = sqrtf(fmaxf(0, b * b - c)) - b;
        struct line_exit *slot = &job->exits[begin + count];
        vec3_store(slot->point, vec3_mad(exit.direction, t, exit.point));
        vec3_store(slot->w, exit.direction);
        vec3_store(slot->flux, (vec3){exit.flux.r, exit.flux.g, exit.flux.b});
        if (job->origins) job->origins[begin + count] = exit.point;
        count++;
    }
    job->counts[block][0] = count;
    job->counts[block][1] = rays;
}

enum status gather_exits(struct exit_list *list, const struct lamp *lamp, enum gather_stream stream, size_t first,
                         size_t n, bool origins, const struct run *run, struct error *error) {
    size_t blocks = (n + BLOCK - 1) / BLOCK;
    *list = (struct exit_list){.emitted = n};
    struct particle_job job = {.lamp = lamp, .stream = (uint64_t)stream << 56, .first = first, .n = n};
    job.exits = list->exits = malloc((n + 1) * sizeof *list->exits);
    job.counts = malloc((blocks + 1) * sizeof *job.counts);
    if (origins) job.origins = list->origin = malloc((n + 1) * sizeof *list->origin);
    if (!job.exits || !job.counts || (origins && !job.origins)) {
        free(job.counts);
        exit_list_fini(list);
        return error_set(error, STATUS_MEMORY, "out of memory for %zu particles", n);
    }
    bool cancelled = false;
    for (; job.first_block < blocks && !cancelled; job.first_block += BLOCKS_PER_LOOK) {
        size_t left = blocks - job.first_block;
        parallel_for(lamp->threads, left < BLOCKS_PER_LOOK ? left : BLOCKS_PER_LOOK, trace_particle_block, &job);
        cancelled = run && run_cancelled(run);
    }
    if (cancelled) {
        free(job.counts);
        exit_list_fini(list);
        return error_set(error, STATUS_CANCELLED, "cancelled while particles were traced");
    }
    for (size_t block = 0; block < blocks; block++) {
        memmove(list->exits + list->count, list->exits + block * BLOCK, job.counts[block][0] * sizeof *list->exits);
        if (origins)
            memmove(list->origin + list->count, list->origin + block * BLOCK,
                    job.counts[block][0] * sizeof *list->origin);
        list->count += job.counts[block][0];
        list->rays += job.counts[block][1];
    }
    free(job.counts);
    return STATUS_OK;
}

void exit_list_fini(struct exit_list *list) {
    free(list->exits);
    free(list->origin);
    *list = (struct exit_list){0};
}

struct line_job {
    const struct lamp *lamp;
    const struct line_guide *guide;
    uint64_t stream;
    size_t first, n;
    bool trace;
    int repeats, round; // of the transmittance's traces
    float cos_limit; // of these: what is turned further is left out
    const struct transparency *learner;
    struct line_sample *lines;
};

static bool lamp_span(const struct lamp *lamp, vec3 point, vec3 w) {
    float origin[3], direction[3], t_near, t_far;
    vec3_store(origin, point);
    vec3_store(direction, w);
    return proxy_shape_span(&lamp->shape, origin, direction, &t_near, &t_far);
}

// From just outside the bounding sphere into the lamp, against the light.
static struct ray camera_ray(const struct lamp *lamp, vec3 point, vec3 w) {
    return (struct ray){vec3_mad(w, 1e-3f * lamp->proxy.radius, point), vec3_neg(w), 0, INFINITY};
}

static void trace_line(const struct lamp *lamp, struct line_sample *line, struct sampler *sampler) {
    struct ray ray = camera_ray(lamp, vec3_from(line->point), vec3_from(line->w));
    struct line_hit hit;
    trace_line_radiance(lamp->scene, &ray, sampler, lamp->aims, lamp->aim_count, MAX_DEPTH, &hit);
    rgb y = rgb_scale(hit.radiance, line->mass);
    vec3_store(line->target, (vec3){y.r, y.g, y.b});
}

static void gather_line_block(void *user, size_t block, int worker) {
    (void)worker;
    const struct line_job *job = user;
    size_t begin = block * BLOCK, end = begin + BLOCK < job->n ? begin + BLOCK : job->n;
    for (size_t i = begin; i < end; i++) {
        struct sampler sampler = sampler_make(job->lamp->seed, job->stream, job->first + i);
        vec3 point, w;
        float density = line_guide_sample(job->guide, &sampler, &point, &w);
        struct line_sample *line = &job->lines[i];
        *line = (struct line_sample){0};
        if (!(density > 0) || !lamp_span(job->lamp, point, w)) {
            vec3_store(line->point, vec3_from(job->lamp->proxy.center)); // any line of the lamp will do
            vec3_store(line->w, (vec3){0, 0, 1});
            continue;
        }
        vec3_store(line->point, point);
        vec3_store(line->w, w);
        line->mass = 1 / density;
        if (job->trace) trace_line(job->lamp, line, &sampler);
    }
}

void gather_lines(struct line_sample *lines, const struct lamp *lamp, const struct line_guide *guide,
                  enum gather_stream stream, size_t first, size_t n, bool trace) {
    struct line_job job = {.lamp = lamp,
                           .guide = guide,
                           .stream = (uint64_t)stream << 56 | 1,
                           .first = first,
                           .n = n,
                           .trace = trace,
                           .lines = lines};
    parallel_for(lamp->threads, (n + BLOCK - 1) / BLOCK, gather_line_block, &job);
}

static void retrace_block(void *user, size_t block, int worker) {
    (void)worker;
    const struct line_job *job = user;
    for (size_t i = block * BLOCK; i < (block + 1) * BLOCK && i < job->n; i++) {
        struct sampler sampler = sampler_make(job->lamp->seed, job->stream, job->first + i);
        if (job->lines[i].mass > 0) trace_line(job->lamp, &job->lines[i], &sampler);
    }
}

void gather_again(struct line_sample *lines, const struct lamp *lamp, enum gather_stream stream, size_t n) {
    struct line_job job = {.lamp = lamp, .stream = (uint64_t)stream << 56 | 3, .n = n, .lines = lines};
    parallel_for(lamp->threads, (n + BLOCK - 1) / BLOCK, retrace_block, &job);
}

static rgb mean_transmittance(const struct line_job *job, size_t index, vec3 exit, vec3 w) {
    const struct ray ray = camera_ray(job->lamp, exit, w);
    const uint64_t stream = job->stream | (uint64_t)(index + 1) << 16 | (uint64_t)(job->round + 1) << 8;
    rgb sum = rgb_gray(0), first = rgb_gray(0);
    bool varies = false;
    int k = 0;
    for (; k < job->repeats && (varies || k < AGREEING); k++) {
        struct sampler sampler = sampler_make(job->lamp->seed, stream, (uint64_t)k);
        rgb t = trace_line_transmittance(job->lamp->scene, &ray, &sampler, MAX_DEPTH, job->cos_limit);
        if (k == 0) first = t;
        varies = varies || rgb_max(rgb_sub(t, first)) > 1e-3f || rgb_max(rgb_sub(first, t)) > 1e-3f;
        sum = rgb_add(sum, t);
    }
    return rgb_scale(sum, 1 / (float)k);
}

static void gather_transmittance_block(void *user, size_t block, int worker) {
    (void)worker;
    const struct line_job *job = user;
    const struct proxy *proxy = &job->lamp->proxy;
    vec3 center = vec3_from(proxy->center);
    size_t begin = block * BLOCK, end = begin + BLOCK < job->n ? begin + BLOCK : job->n;
    for (size_t i = begin; i < end; i++) {
        struct sampler sampler = sampler_make(job->lamp->seed, job->stream, job->first + i);
        struct line_sample *line = &job->lines[i];
        vec3 exit, w;
        do { // every proxy fills a good part of its bounding sphere's cross-section
            w = warp_uniform_sphere(sampler_2d(&sampler));
            vec2 disk = warp_concentric_disk(sampler_2d(&sampler));
            struct frame frame = frame_from_normal(w);
            float rise = sqrtf(fmaxf(0, 1 - disk.x * disk.x - disk.y * disk.y));
            exit = vec3_mad(frame_world_from_local(&frame, (vec3){disk.x, disk.y, rise}), proxy->radius, center);
        } while (!lamp_span(job->lamp, exit, w));
        vec3_store(line->point, exit);
        vec3_store(line->w, w);
        line->mass = !job->learner || transparency_learns(job->learner, line->point, line->w) ? 1.0f : 0.0f;
        if (!(line->mass > 0)) continue;
        rgb t = mean_transmittance(job, job->first + i, exit, w);
        vec3_store(line->target, (vec3){t.r, t.g, t.b});
    }
}

void gather_transmittance(struct line_sample *lines, const struct lamp *lamp, enum gather_stream stream, size_t first,
                          size_t n, int repeats, int round, const struct transparency *learner) {
    struct line_job job = {.lamp = lamp,
                           .stream = (uint64_t)stream << 56 | 2,
                           .first = first,
                           .n = n,
                           .repeats = repeats,
                           .round = round,
                           .cos_limit = straight_cos,
                           .learner = learner,
                           .lines = lines};
    parallel_for(lamp->threads, (n + BLOCK - 1) / BLOCK, gather_transmittance_block, &job);
}

void gather_escapes(struct line_sample *lines, const struct lamp *lamp, enum gather_stream stream, size_t n,
                    bool onward) {
    struct line_job job = {.lamp = lamp,
                           .stream = (uint64_t)stream << 56 | 2,
                           .n = n,
                           .repeats = 1,
                           .cos_limit = onward ? 0.0f : -1.0f,
                           .lines = lines};
    parallel_for(lamp->threads, (n + BLOCK - 1) / BLOCK, gather_transmittance_block, &job);
}
