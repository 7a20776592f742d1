// The particle integrator (light tracing): walks from the lights only, every vertex seen by the camera. Independent of
// the weights of bdpt.c, and the only plain technique that finds caustics of lights behind smooth glass. What only a
// camera ray can see stays black: anything seen through smooth glass or in mirrors other than a single plane one. Light
// at infinity that the camera sees directly is added by a camera ray.
#include <stdlib.h>

#include "trace/bdpt.h"
#include "trace/film_sample.h"
#include "trace/mirror_link.h"
#include "trace/splat_pass.h"

struct particle_state {
    const struct scene *scene;
    struct light_source source;
    struct camera camera;
    struct splat_pass pass;
    int max_depth;
};

static rgb emitter_value(const struct walk *walk, const struct camera_link *link, vec3 direction) {
    const struct surface *surface = &walk->emission->surface;
    float cos_theta = fabsf(vec3_dot(surface->ng, direction));
    return rgb_scale(surface_emission(surface, direction),
                     cos_theta * link->response / (walk->emission->pdf_position * walk->emission_pmf));
}

static void splat_emitter(const struct particle_state *state, const struct walk *walk, struct sampler *sampler,
                          struct splat_list *splats) {
    const struct surface *surface = &walk->emission->surface;
    struct camera_link link;
    if (!camera_connect(&state->camera, surface->p, sampler_2d(sampler), &link)) return;
    rgb value = emitter_value(walk, &link, link.direction);
    if (!(rgb_max(value) > 0)) return;
    struct ray ray = surface_spawn_ray(surface, link.direction);
    ray.t_max = link.reach;
    value = rgb_mul(value, scene_visibility(state->scene, &ray, -1));
    splat_add(splats, state->scene->sensor, link.film,
              rgb_mul(value, segment_absorption(surface, NULL, link.direction, link.distance)));
}

static void splat_emitter_in_mirrors(const struct particle_state *state, const struct walk *walk,
                                     struct sampler *sampler, struct splat_list *splats) {
    const struct surface *surface = &walk->emission->surface;
    for (size_t i = 0; i < state->camera.mirrors.count; i++) {
        struct mirror_link link;
        if (!mirror_link_find(&state->camera.mirrors.mirrors[i], &state->camera, surface->p, sampler_2d(sampler),
                              &link))
            continue;
        rgb value = emitter_value(walk, &link.camera, link.direction);
        if (!(rgb_max(value) > 0)) continue;
        value = rgb_mul(value, mirror_link_transmits(&link, &state->camera, state->scene, surface, sampler));
        splat_add(splats, state->scene->sensor, link.camera.film, value);
    }
}

static rgb see_environment(const struct particle_state *state, int x, int y, struct sampler *sampler) {
    const struct emitter *environment = state->scene->environment;
    const struct sensor *sensor = state->scene->sensor;
    if (!environment || state->scene->hide_emitters) return rgb_gray(0);
    struct ray ray;
    vec2 film = film_sample_position(sensor, x, y, sampler_2d(sampler));
    sensor->type->sample_ray(sensor, film, sampler_2d(sampler), &ray);
    return rgb_mul(scene_visibility(state->scene, &ray, -1),
                   environment->type->eval(environment, NULL, vec3_neg(ray.direction)));
}

static rgb particle_trace(void *user, int x, int y, uint64_t pass, const struct run *run, int worker,
                          struct splat_list *splats) {
    (void)worker;
    const struct particle_state *state = user;
    if (state->max_depth < 1) return rgb_gray(0);
    struct sampler sampler = sampler_make(run->seed, film_pixel_stream(state->scene->sensor, x, y), pass);
    rgb seen = see_environment(state, x, y, &sampler);
    struct walk walk;
    struct emission_sample emission;
    struct vertex vertex;
    if (!light_source_emit(&state->source, &sampler, &walk, &emission)) return seen;
    if (walk.emitter->shape && !state->scene->hide_emitters) splat_emitter(state, &walk, &sampler, splats);
    if (walk.emitter->shape && state->max_depth >= 2) splat_emitter_in_mirrors(state, &walk, &sampler, splats);
    for (;;) {
        enum walk_event event = walk_advance(&walk, &sampler, &vertex);
        if (event == WALK_ESCAPED) return seen;
        if (event == WALK_PASSED) continue;
        if (vertex.depth >= state->max_depth) return seen;
        if (vertex.flags & BSDF_SMOOTH)
            bdpt_connect_camera(state->scene, &state->camera, &vertex, state->max_depth, false, &sampler, splats);
        if (vertex.depth + 1 >= state->max_depth || !walk_scatter(&walk, &vertex, &sampler, state->scene->rr_depth))
            return seen;
    }
}

static void particle_destroy(void *user) {
    struct particle_state *state = user;
    if (!state) return;
    splat_pass_fini(&state->pass);
    light_source_fini(&state->source);
    free(state);
}

static enum status particle_create(const struct scene *scene, const struct run *run, void **result,
                                   struct error *error) {
    *result = NULL;
    if (scene->luminaire_count > 0)
        return error_set(error, STATUS_UNSUPPORTED,
                         "%s: light tracing cannot see into a baked luminaire; use the path integrator",
                         scene->path ? scene->path : "scene");
    struct particle_state *state = calloc(1, sizeof *state);
    if (!state) return error_set(error, STATUS_MEMORY, "out of memory for the particle integrator");
    state->scene = scene;
    state->max_depth = scene->max_depth < 0 ? BDPT_MAX_VERTICES : scene->max_depth;
    state->pass.workers = run->threads;
    state->pass.sensor = scene->sensor;
    state->pass.trace = particle_trace;
    state->pass.user = state;
    enum status status = light_source_init(&state->source, scene, NULL, error);
    if (status != STATUS_OK) {
        particle_destroy(state);
        return status;
    }
    camera_init(&state->camera, scene);
    *result = state;
    return STATUS_OK;
}

static enum status particle_render_pass(void *user, struct film *film, uint64_t pass, const struct run *run,
                                        struct error *error) {
    struct particle_state *state = user;
    return splat_pass_run(&state->pass, film, pass, run, error);
}

const struct integrator_type particle_integrator = {
    .name = "particle",
    .help = "light tracing: particles from the lights, seen by the camera wherever they land",
    .create = particle_create,
    .render_pass = particle_render_pass,
    .destroy = particle_destroy,
};
