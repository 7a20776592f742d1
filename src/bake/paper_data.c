#include "bake/paper_data.h"

#include <string.h>

#include "bake/line_guide.h"
#include "base/parallel.h"
#include "math/warp.h"

enum { BLOCK = 64, MAX_DEPTH = 100 };
static const float inside_share = 0.1f, farthest = 12;

struct data_job {
    const struct lamp *lamp;
    const struct line_guide *guide;
    const struct paper *paper;
    uint64_t stream;
    size_t first, n;
    int traces;
    struct line_sample *lines;
    struct paper_view *views;
};

// The mean radiance that comes out along w, `exit` being where the line leaves the bounding sphere.
static rgb mean_radiance(const struct lamp *lamp, vec3 exit, vec3 w, int traces, struct sampler *sampler) {
    float origin[3], direction[3], t_near, t_far;
    vec3_store(origin, exit);
    vec3_store(direction, w);
    rgb sum = {0, 0, 0};
    if (!proxy_shape_span(&lamp->shape, origin, direction, &t_near, &t_far)) return sum;
    struct ray ray = {vec3_mad(w, 1e-3f * lamp->proxy.radius, exit), vec3_neg(w), 0, INFINITY};
    for (int k = 0; k < traces; k++) {
        struct line_hit hit;
        trace_line_radiance(lamp->scene, &ray, sampler, lamp->aims, lamp->aim_count, MAX_DEPTH, &hit);
        sum = rgb_add(sum, hit.radiance);
    }
    return rgb_scale(sum, 1 / (float)traces);
}

static void gather_line_block(void *user, size_t block, int worker) {
    (void)worker;
    const struct data_job *job = user;
    size_t begin = block * BLOCK, end = begin + BLOCK < job->n ? begin + BLOCK : job->n;
    for (size_t i = begin; i < end; i++) {
        struct sampler sampler = sampler_make(job->lamp->seed, job->stream | 4, job->first + i);
        vec3 point, w;
        float density = line_guide_sample(job->guide, &sampler, &point, &w);
        struct line_sample *line = &job->lines[i];
        *line = (struct line_sample){0};
        if (!(density > 0)) {
            vec3_store(line->point, vec3_from(job->lamp->proxy.center)); // any line of the lamp will do
            vec3_store(line->w, (vec3){0, 0, 1});
            continue;
        }
        vec3_store(line->point, point);
        vec3_store(line->w, w);
        line->mass = 1 / density;
        rgb y = rgb_scale(mean_radiance(job->lamp, point, w, job->traces, &sampler), line->mass);
        vec3_store(line->target, (vec3){y.r, y.g, y.b});
    }
}

void paper_gather_lines(struct line_sample *lines, const struct lamp *lamp, const struct line_guide *guide,
                        enum gather_stream stream, size_t first, size_t n, int traces) {
    struct data_job job = {.lamp = lamp,
                           .guide = guide,
                           .stream = (uint64_t)stream << 56,
                           .first = first,
                           .n = n,
                           .traces = traces,
                           .lines = lines};
    parallel_for(lamp->threads, (n + BLOCK - 1) / BLOCK, gather_line_block, &job);
}

static void gather_view(void *user, size_t index, int worker) {
    (void)worker;
    const struct data_job *job = user;
    const struct proxy *proxy = &job->lamp->proxy;
    struct paper_view *view = &job->views[index];
    struct sampler sampler = sampler_make(job->lamp->seed, job->stream | 5, job->first + index);
    vec3 out = warp_uniform_sphere(sampler_2d(&sampler)), center = vec3_from(proxy->center);
    float u = sampler_1d(&sampler), v = sampler_1d(&sampler);
    float distance = u < inside_share ? cbrtf(v) : powf(farthest, v);
    vec3 s = vec3_mad(out, distance * proxy->radius, center), offset = vec3_sub(s, center);
    vec3_store(view->s, s);
    for (int pixel = 0; pixel < PAPER_PIXELS; pixel++) {
        rgb sum = {0, 0, 0};
        for (int k = 0; k < PAPER_PIXEL_TRACES; k++) {
            vec2 jitter = sampler_2d(&sampler);
            float p[2] = {((float)(pixel % PAPER_SIDE) + jitter.x) / PAPER_SIDE,
                          ((float)(pixel / PAPER_SIDE) + jitter.y) / PAPER_SIDE},
                  d[3];
            paper_view_direction(job->paper, view->s, p, d);
            vec3 w = vec3_neg(vec3_from(d));
            float along = vec3_dot(offset, w), half2 = along * along - vec3_dot(offset, offset) + sqrf(proxy->radius);
            vec3 exit = vec3_mad(w, sqrtf(fmaxf(0, half2)) - along, s);
            sum = rgb_add(sum, mean_radiance(job->lamp, exit, w, 1, &sampler));
        }
        sum = rgb_scale(sum, 1.0f / PAPER_PIXEL_TRACES);
        vec3_store(view->radiance[pixel], (vec3){sum.r, sum.g, sum.b});
    }
}

void paper_gather_views(struct paper_view *views, const struct lamp *lamp, const struct paper *paper,
                        enum gather_stream stream, size_t first, size_t n) {
    struct data_job job = {
        .lamp = lamp, .paper = paper, .stream = (uint64_t)stream << 56, .first = first, .n = n, .views = views};
    parallel_for(lamp->threads, n, gather_view, &job);
}
