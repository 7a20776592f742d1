// The bidirectional path tracer: one walk from a light and one from the camera per pixel sample, every technique that
// joins them (Veach 1997, ch. 10), weighted by the power heuristic with the running sums of subpath.h.
#pragma once

#include "trace/integrator.h"
#include "trace/splat.h"
#include "trace/subpath.h"

enum { BDPT_MAX_VERTICES = 512 }; // of one walk; Russian roulette ends longer ones with a probability beyond 1 - 1e-10

struct bdpt {
    const struct scene *scene;
    struct light_select *lights;
    struct light_source source;
    struct camera camera;
    int max_depth; // edges, always bounded
    float roulette_scale; // brightness below which a connection is tested by chance only
};

// Contributions to the pixel of the camera's walk. All test their shadow rays themselves.
rgb bdpt_connect_light(const struct bdpt *bdpt, const struct vertex *camera,
                       struct sampler *sampler); // next-event estimation
rgb bdpt_connect_vertices(const struct bdpt *bdpt, const struct vertex *camera, const struct vertex *light,
                          struct sampler *sampler);
rgb bdpt_hit_light(const struct bdpt *bdpt, const struct walk *walk, const struct vertex *camera);
rgb bdpt_hit_environment(const struct bdpt *bdpt, const struct walk *walk);
// The light's vertex seen by the camera, directly and, where max_depth has an edge left, in its mirrors: `weighted` by
// multiple importance sampling, or alone (light tracing).
void bdpt_connect_camera(const struct scene *scene, const struct camera *camera, const struct vertex *light,
                         int max_depth, bool weighted, struct sampler *sampler, struct splat_list *splats);
