// What caustic.c and caustic_trace.c share: a block of particles of one lamp, traced stage by stage like the blocks of
// path_state.h, so that the lamps' queries come in batches.
#pragma once

#include "trace/caustic.h"
#include "trace/caustic_target.h"
#include "trace/lamp_draws.h"
#include "trace/luminaire_crossing.h"
#include "trace/residual.h"
#include "trace/shared_view.h"
#include "trace/splat.h"
#include "trace/subpath.h"

enum { CAUSTIC_BLOCK = 512 };

enum caustic_stage {
    CAUSTIC_IN_ROOM,
    CAUSTIC_IN_LAMP, // has met nothing but its lamp so far
    CAUSTIC_NEAR, // came along a near line to its first vertex in the room, where it must be scattered by a delta
};

struct caustic_particle {
    enum caustic_stage stage;
    struct sampler sampler;
    struct ray ray;
    rgb beta;
    float start; // brightness of beta at the first vertex, for Russian roulette
    int depth; // vertices so far
    int kept; // luminaire instance whose kept geometry the last vertex is on, or -1
    bool scatters, has_from;
    struct fork fork;
    struct surface from, surface; // the ray's ends
};

struct caustic_link { // a vertex on its way to the camera
    struct ray ray;
    vec2 film;
    rgb value;
    struct shared_splat view;
};

struct caustic_views { // how pixels see what splats bring, by their source
    struct shared_splat *items;
    size_t count, capacity;
};

struct caustic_worker {
    struct caustic_particle *particles; // CAUSTIC_BLOCK
    uint32_t *active;
    size_t active_count;
    struct caustic_link *links; // CAUSTIC_BLOCK
    size_t link_count;
    struct crossing_batch crossings; // of CAUSTIC_BLOCK lines
    struct lamp_draws draws; // CAUSTIC_BLOCK
};

struct caustic_block {
    uint32_t luminaire;
    uint64_t first; // index of its first particle among the lamp's
    size_t count;
    uint64_t total; // particles of this lamp
};

struct caustic_job {
    const struct scene *scene;
    const struct residual *residual; // or NULL
    const struct camera *camera;
    const struct caustic_targets *targets; // of the block's lamp
    bool hidden; // scene_has_hidden_geometry
    uint64_t seed, pass;
};

void caustic_trace_block(const struct caustic_job *job, const struct caustic_block *block,
                         struct caustic_worker *worker, struct splat_list *splats,
                         struct caustic_views *views); // views: or NULL
