// The bidirectional integrator: for every pixel sample a walk from a light, whose vertices the camera sees directly
// (splats) and which are kept, then a walk from the camera that joins them.
#include "trace/bdpt.h"

#include <stdlib.h>

#include "trace/film_sample.h"
#include "trace/splat_pass.h"

struct bdpt_state {
    struct bdpt bdpt;
    struct splat_pass pass;
    struct vertex **vertices; // per worker
    int worker_count, vertex_capacity;
};

static const uint64_t light_stream = 1ull << 63; // the light's walks draw from streams of their own

static size_t trace_light(const struct bdpt *bdpt, struct sampler *sampler, struct vertex *vertices,
                          struct splat_list *splats) {
    struct walk walk;
    struct emission_sample emission;
    size_t count = 0;
    if (!light_source_emit(&bdpt->source, sampler, &walk, &emission)) return 0;
    for (;;) {
        struct vertex *vertex = &vertices[count];
        enum walk_event event = walk_advance(&walk, sampler, vertex);
        if (event == WALK_ESCAPED) return count;
        if (event == WALK_PASSED) continue;
        if (vertex->depth >= bdpt->max_depth) return count;
        if (vertex->flags & BSDF_SMOOTH) {
            if (splats) bdpt_connect_camera(bdpt->scene, &bdpt->camera, vertex, bdpt->max_depth, true, sampler, splats);
            count++;
        }
        if (vertex->depth + 1 >= bdpt->max_depth || !walk_scatter(&walk, vertex, sampler, bdpt->scene->rr_depth))
            return count;
    }
}

static rgb trace_camera(const struct bdpt *bdpt, vec2 film, vec2 lens, struct sampler *sampler,
                        const struct vertex *lights, size_t light_count) {
    struct walk walk;
    struct vertex vertex;
    rgb sum = {0};
    if (bdpt->max_depth < 1) return sum;
    camera_walk(&bdpt->camera, bdpt->scene, film, lens, &walk);
    for (;;) {
        enum walk_event event = walk_advance(&walk, sampler, &vertex);
        if (event == WALK_ESCAPED) return rgb_add(sum, bdpt_hit_environment(bdpt, &walk));
        sum = rgb_add(sum, bdpt_hit_light(bdpt, &walk, &vertex));
        if (event == WALK_PASSED) continue;
        if (vertex.depth >= bdpt->max_depth) return sum;
        if (vertex.flags & BSDF_SMOOTH) {
            sum = rgb_add(sum, bdpt_connect_light(bdpt, &vertex, sampler));
            for (size_t i = 0; i < light_count && lights[i].depth + vertex.depth + 1 <= bdpt->max_depth; i++)
                sum = rgb_add(sum, bdpt_connect_vertices(bdpt, &vertex, &lights[i], sampler));
        }
        if (!walk_scatter(&walk, &vertex, sampler, bdpt->scene->rr_depth)) return sum;
    }
}

static rgb bdpt_trace(void *user, int x, int y, uint64_t pass, const struct run *run, int worker,
                      struct splat_list *splats) {
    const struct bdpt_state *state = user;
    const struct bdpt *bdpt = &state->bdpt;
    uint64_t stream = film_pixel_stream(bdpt->scene->sensor, x, y);
    struct sampler light = sampler_make(run->seed, stream | light_stream, pass),
                   camera = sampler_make(run->seed, stream, pass);
    size_t count = trace_light(bdpt, &light, state->vertices[worker], splats);
    vec2 film = film_sample_position(bdpt->scene->sensor, x, y, sampler_2d(&camera)), lens = sampler_2d(&camera);
    return trace_camera(bdpt, film, lens, &camera, state->vertices[worker], count);
}

static void bdpt_destroy(void *user) {
    struct bdpt_state *state = user;
    if (!state) return;
    for (int i = 0; state->vertices && i < state->worker_count; i++) free(state->vertices[i]);
    free(state->vertices);
    splat_pass_fini(&state->pass);
    light_source_fini(&state->bdpt.source);
    light_select_destroy(state->bdpt.lights);
    free(state);
}

// The mean brightness of a few samples tells which connections are faint.
static void bdpt_find_roulette_scale(struct bdpt_state *state, const struct run *run) {
    enum { samples = 2048 };
    const struct sensor *sensor = state->bdpt.scene->sensor;
    double sum = 0;
    for (int i = 0; i < samples; i++) {
        int x = sensor->crop_x + (int)((unsigned)i * 7919u % (unsigned)sensor->crop_width);
        int y = sensor->crop_y + (int)((unsigned)i * 6271u % (unsigned)sensor->crop_height);
        rgb value = bdpt_trace(state, x, y, UINT64_MAX - (uint64_t)i, run, 0, NULL);
        if (rgb_is_finite(value)) sum += fminf(rgb_max(value), 1e6f);
    }
    state->bdpt.roulette_scale = 0.1f * (float)(sum / samples);
}

static enum status bdpt_create(const struct scene *scene, const struct run *run, void **result, struct error *error) {
    *result = NULL;
    if (scene->luminaire_count > 0)
        return error_set(error, STATUS_UNSUPPORTED,
                         "%s: the bidirectional integrator cannot see into a baked luminaire; use the path integrator",
                         scene->path ? scene->path : "scene");
    struct bdpt_state *state = calloc(1, sizeof *state);
    if (!state) return error_set(error, STATUS_MEMORY, "out of memory for the bidirectional integrator");
    struct bdpt *bdpt = &state->bdpt;
    bdpt->scene = scene;
    bdpt->max_depth =
        scene->max_depth < 0 || scene->max_depth > BDPT_MAX_VERTICES ? BDPT_MAX_VERTICES : scene->max_depth;
    state->worker_count = run->threads;
    state->pass.workers = run->threads;
    state->pass.sensor = scene->sensor;
    state->pass.trace = bdpt_trace;
    state->pass.user = state;
    enum status status = light_select_create(&bdpt->lights, scene, error);
    if (status == STATUS_OK) status = light_source_init(&bdpt->source, scene, bdpt->lights, error);
    if (status == STATUS_OK) {
        state->vertices = calloc((size_t)run->threads, sizeof *state->vertices);
        bool full = state->vertices;
        for (int i = 0; full && i < run->threads; i++)
            full = (state->vertices[i] = malloc(((size_t)bdpt->max_depth + 1) * sizeof **state->vertices));
        if (!full)
            status = error_set(error, STATUS_MEMORY, "out of memory for the bidirectional integrator's vertices");
    }
    if (status != STATUS_OK) {
        bdpt_destroy(state);
        return status;
    }
    camera_init(&bdpt->camera, scene);
    bdpt_find_roulette_scale(state, run);
    *result = state;
    return STATUS_OK;
}

static enum status bdpt_render_pass(void *user, struct film *film, uint64_t pass, const struct run *run,
                                    struct error *error) {
    struct bdpt_state *state = user;
    return splat_pass_run(&state->pass, film, pass, run, error);
}

const struct integrator_type bdpt_integrator = {
    .name = "bdpt",
    .help = "bidirectional path tracing: the reference for scenes without baked luminaires",
    .create = bdpt_create,
    .render_pass = bdpt_render_pass,
    .destroy = bdpt_destroy,
};
