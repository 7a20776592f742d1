// Light tracing of caustics: begin at a target with a light sample of the lamp, then hit, connect to the camera and
// scatter until no particle is left. (Arvo 1986, "Backward Ray Tracing"; the weights are those of Veach 1997, 10.3.4
// for a path whose first vertex after the light is sampled by area and whose light is sampled from there.)
// What surfaces, interiors, kept geometry and other lamps do to the light on an edge mirrors path_luminaire.c and
// path_shadow.c exactly: a lamp dims an edge by T unless one of its ends is on that lamp's own geometry.
#include "trace/caustic_trace.h"

#include <stdlib.h>

#include "trace/hull_look.h"

static const float max_survival = 0.95f;

static struct sampler particle_sampler(const struct caustic_job *job, const struct caustic_block *block, size_t i) {
    // Pixels' streams are far below 2^40.
    uint64_t stream = ((uint64_t)block->luminaire + 1) << 40 | (block->first + i);
    return sampler_make(job->seed, stream, job->pass);
}

// Of the particles of one lamp and pass.
static float stratified(const struct caustic_block *block, size_t i, float jitter) {
    double u = ((double)(block->first + i) + (double)jitter) / (double)block->total;
    return fminf((float)u, 0x1.fffffep-1f);
}

// The lamps on an edge between two vertices, but for `a` and `b`, whose geometry its ends are on (or -1).
static void add_crossings(const struct caustic_job *job, struct caustic_worker *worker, uint32_t item,
                          const struct ray *ray, float t_end, int a, int b, bool to_camera) {
    for (uint32_t i = 0; i < job->scene->luminaire_count; i++) {
        const struct luminaire_instance *instance = &job->scene->luminaires[i];
        float t_mid;
        if ((int)i == a || (int)i == b || instance->keep == KEEP_ALL) continue;
        if (to_camera && instance->appearance == APPEARANCE_GEOMETRY) continue;
        if (to_camera && instance->appearance == APPEARANCE_SURFACE && !hull_dims(job->scene, ray, (int)i)) continue;
        if (!crossing_find(instance, ray, &t_mid) || t_mid >= t_end) continue;
        crossing_add(&worker->crossings, item, i, ray, t_mid)->wants_transmittance = true;
    }
}

static void sample_lines(const struct caustic_job *job, const struct caustic_block *block,
                         struct caustic_worker *worker) {
    const struct luminaire_instance *instance = &job->scene->luminaires[block->luminaire];
    for (size_t i = 0; i < block->count; i++) {
        struct caustic_particle *particle = &worker->particles[i];
        particle->sampler = particle_sampler(job, block, i);
        float jitter = sampler_1d(&particle->sampler), pdf_area; // the targets are stratified over the particles
        caustic_targets_sample(job->targets, stratified(block, i, jitter), sampler_2d(&particle->sampler),
                               &particle->surface, &pdf_area);
        particle->beta = rgb_gray(1 / (pdf_area * (float)block->total));
        const vec2 u = sampler_2d(&particle->sampler);
        lamp_draws_ask(&worker->draws, i, instance, particle->surface.p, u, sampler_1d(&particle->sampler));
    }
    lamp_draws_answer(&worker->draws, block->count, instance);
}

// The first scattering, at the target. False: no delta, or nothing arrives. *arrives: the ray towards the lamp.
static bool begin_particle(const struct caustic_job *job, const struct luminaire_instance *instance, int luminaire,
                           vec3 to_lamp, float pdf_sa, struct caustic_particle *particle, struct ray *arrives) {
    const struct surface *surface = &particle->surface;
    struct ray line = {surface->p, to_lamp, 0, INFINITY};
    float t_mid;
    if (!(pdf_sa > 0) || !crossing_find(instance, &line, &t_mid)) return false;
    vec2 u = sampler_2d(&particle->sampler);
    struct bsdf_sample sample;
    if (!surface_sample_bsdf(surface, to_lamp, (vec3){u.x, u.y, sampler_1d(&particle->sampler)}, TRANSPORT_IMPORTANCE,
                             &sample) ||
        !sample.delta)
        return false;
    rgb scatters = rgb_sub(rgb_gray(1), surface_through(surface, to_lamp));
    rgb weight = rgb_scale(rgb_mul(sample.weight, scatters), fabsf(vec3_dot(surface->ng, to_lamp)) / pdf_sa);
    *arrives = surface_spawn_ray(surface, to_lamp);
    arrives->t_max = t_mid;
    struct lamp_view view = {false, -1, luminaire};
    weight = rgb_mul(weight, lamp_view_visibility(job->scene, job->hidden, &view, arrives));
    weight = rgb_mul(weight, segment_absorption(surface, NULL, to_lamp, t_mid));
    particle->beta = rgb_mul(particle->beta, weight);
    particle->ray = surface_spawn_ray(surface, sample.wo);
    particle->from = *surface;
    particle->has_from = true;
    particle->kept = surface->shape->luminaire;
    particle->depth = 1;
    particle->stage = CAUSTIC_IN_ROOM;
    return !rgb_is_black(particle->beta);
}

static void begin(const struct caustic_job *job, const struct caustic_block *block, struct caustic_worker *worker) {
    const struct luminaire_instance *instance = &job->scene->luminaires[block->luminaire];
    sample_lines(job, block, worker);
    worker->active_count = 0;
    worker->crossings.count = 0;
    for (uint32_t i = 0; i < block->count; i++) {
        struct caustic_particle *particle = &worker->particles[i];
        const vec3 to_lamp = lamp_draws_direction(&worker->draws, i, instance);
        struct ray arrives;
        if (!begin_particle(job, instance, (int)block->luminaire, to_lamp, worker->draws.pdfs[i], particle, &arrives))
            continue;
        struct ray line = {particle->surface.p, to_lamp, 0, INFINITY};
        crossing_add(&worker->crossings, i, block->luminaire, &line, arrives.t_max)->wants_radiance = true;
        add_crossings(job, worker, i, &arrives, arrives.t_max, (int)block->luminaire, particle->kept, false);
        worker->active[worker->active_count++] = i;
    }
    crossing_batch_answer(&worker->crossings, job->scene);
    for (size_t i = 0; i < worker->crossings.count; i++) {
        const struct crossing *crossing = &worker->crossings.crossings[i];
        struct caustic_particle *particle = &worker->particles[crossing->item];
        particle->beta =
            rgb_mul(particle->beta, crossing->wants_radiance ? crossing->radiance : crossing->transmittance);
    }
    size_t kept = 0;
    for (size_t i = 0; i < worker->active_count; i++) {
        struct caustic_particle *particle = &worker->particles[worker->active[i]];
        particle->start = rgb_max(particle->beta);
        if (particle->start > 0) worker->active[kept++] = worker->active[i];
    }
    worker->active_count = kept;
}

// In an unbiased rendering: the emitters instead.
static void emit(const struct caustic_job *job, const struct caustic_block *block, struct caustic_worker *worker) {
    worker->active_count = 0;
    for (uint32_t i = 0; i < block->count; i++) {
        struct caustic_particle *particle = &worker->particles[i];
        particle->sampler = particle_sampler(job, block, i);
        float u_emitter = stratified(block, i, sampler_1d(&particle->sampler));
        struct emission_sample emission;
        if (!residual_emit(job->residual, (int)block->luminaire, u_emitter, &particle->sampler, &emission,
                           &particle->beta))
            continue;
        particle->beta = rgb_scale(particle->beta, 1 / (float)block->total);
        particle->start = rgb_max(particle->beta);
        particle->ray = emission.ray;
        particle->from = emission.surface;
        particle->has_from = true;
        particle->kept = (int)block->luminaire;
        particle->depth = 0;
        particle->stage = CAUSTIC_IN_LAMP;
        worker->active[worker->active_count++] = i;
    }
}

static bool hit_particle(const struct caustic_job *job, struct caustic_particle *particle) {
    struct lamp_view view = {false, -1, -1};
    if (!lamp_view_intersect(job->scene, job->hidden, &view, &particle->ray, &particle->surface)) return false;
    vec3 wi = vec3_neg(particle->ray.direction);
    particle->fork = fork_none();
    if (surface_bsdf_flags(&particle->surface) & BSDF_NULL)
        particle->fork = fork_choose(&particle->surface, wi, sampler_1d(&particle->sampler));
    particle->scatters = !particle->fork.passes;
    particle->beta =
        rgb_mul(particle->beta, segment_absorption(particle->has_from ? &particle->from : NULL, &particle->surface,
                                                   particle->ray.direction, particle->surface.t));
    return !rgb_is_black(particle->beta);
}

// The line along which a particle leaves its lamp ends where it first scatters in the room.
static void leave_lamp(const struct caustic_job *job, int luminaire, struct caustic_particle *particle) {
    const struct surface *surface = &particle->surface;
    if (particle->stage != CAUSTIC_IN_LAMP || !particle->scatters || surface->shape->luminaire == luminaire) return;
    bool near = residual_line_is_near(job->residual, luminaire, surface->p, particle->ray.direction);
    particle->stage = near ? CAUSTIC_NEAR : CAUSTIC_IN_ROOM;
}

static void hit(const struct caustic_job *job, int luminaire, struct caustic_worker *worker) {
    size_t kept = 0;
    worker->crossings.count = 0;
    for (size_t i = 0; i < worker->active_count; i++) {
        uint32_t index = worker->active[i];
        struct caustic_particle *particle = &worker->particles[index];
        if (!hit_particle(job, particle)) continue;
        leave_lamp(job, luminaire, particle);
        add_crossings(job, worker, index, &particle->ray, particle->surface.t, particle->kept,
                      particle->scatters ? particle->surface.shape->luminaire : -1, false);
        worker->active[kept++] = index;
    }
    worker->active_count = kept;
    crossing_batch_answer(&worker->crossings, job->scene);
    for (size_t i = 0; i < worker->crossings.count; i++) {
        const struct crossing *crossing = &worker->crossings.crossings[i];
        struct caustic_particle *particle = &worker->particles[crossing->item];
        particle->beta = rgb_mul(particle->beta, crossing->transmittance);
    }
}

// A camera sees the real geometry of a lamp that shows it, from where path_hit.c gathers the lamp's own light another
// way: those vertices are not in the class.
static bool camera_finds(const struct caustic_job *job, const struct surface *surface) {
    int i = surface->shape->luminaire;
    return i < 0 || job->scene->luminaires[i].appearance != APPEARANCE_GEOMETRY;
}

// What the camera sees of what arrives at a particle's surface.
static struct shared_splat view_particle(const struct caustic_particle *particle, vec3 to_camera) {
    const struct surface *surface = &particle->surface;
    const struct shared_view view = shared_view_of(surface, to_camera, 0);
    const rgb broad = shared_view_share(&view, surface, to_camera, vec3_neg(particle->ray.direction));
    return (struct shared_splat){
        .surface = shared_view_exists(surface) ? view.surface : 0,
        .n = view.n,
        .part = SHARED_CAUSTIC,
        .share = {[SHARED_BROAD] = broad, [SHARED_GLOSS] = rgb_sub(rgb_gray(1), broad)},
        .weight = {[SHARED_BROAD] = rgb_scale(view.broad, particle->fork.inverse_share), [SHARED_GLOSS] = rgb_gray(1)}};
}

// The number by which splats find it.
static uint32_t keep_view(struct caustic_views *views, const struct shared_splat *view, struct splat_list *splats) {
    if (views->count == views->capacity) {
        const size_t capacity = views->capacity ? 2 * views->capacity : CAUSTIC_BLOCK;
        struct shared_splat *items = realloc(views->items, capacity * sizeof *items);
        if (!items) {
            splats->out_of_memory = true;
            return 0;
        }
        views->items = items;
        views->capacity = capacity;
    }
    views->items[views->count] = *view;
    return (uint32_t)views->count++;
}

static void connect_particle(const struct caustic_job *job, struct caustic_worker *worker,
                             struct caustic_particle *particle, bool viewed) {
    const struct surface *surface = &particle->surface;
    struct camera_link link;
    if (!(surface_bsdf_flags(surface) & BSDF_SMOOTH) || !camera_finds(job, surface)) return;
    if (!camera_connect(job->camera, surface->p, sampler_2d(&particle->sampler), &link)) return;
    rgb value = surface_eval_bsdf(surface, vec3_neg(particle->ray.direction), link.direction, TRANSPORT_IMPORTANCE);
    value = rgb_scale(rgb_mul(particle->beta, value), particle->fork.inverse_share * link.response);
    if (rgb_is_black(value)) return;
    struct ray ray = surface_spawn_ray(surface, link.direction);
    ray.t_max = link.reach;
    struct lamp_view view = {true, -1, -1};
    value = rgb_mul(value, lamp_view_visibility(job->scene, job->hidden, &view, &ray));
    value = rgb_mul(value, segment_absorption(surface, NULL, link.direction, link.distance));
    if (rgb_is_black(value) || hulls_block(job->scene, &ray)) return;
    add_crossings(job, worker, (uint32_t)worker->link_count, &ray, ray.t_max, surface->shape->luminaire, -1, true);
    struct caustic_link *kept = &worker->links[worker->link_count++];
    *kept = (struct caustic_link){ray, link.film, value, {0}};
    if (viewed) kept->view = view_particle(particle, link.direction);
}

static void connect(const struct caustic_job *job, struct caustic_worker *worker, struct splat_list *splats,
                    struct caustic_views *views) {
    worker->link_count = 0;
    worker->crossings.count = 0;
    for (size_t i = 0; i < worker->active_count; i++) {
        struct caustic_particle *particle = &worker->particles[worker->active[i]];
        if (particle->scatters && particle->stage != CAUSTIC_NEAR) connect_particle(job, worker, particle, views);
    }
    crossing_batch_answer(&worker->crossings, job->scene);
    for (size_t i = 0; i < worker->crossings.count; i++) {
        const struct crossing *crossing = &worker->crossings.crossings[i];
        struct caustic_link *link = &worker->links[crossing->item];
        link->value = rgb_mul(link->value, crossing->transmittance);
    }
    for (size_t i = 0; i < worker->link_count; i++) {
        const struct caustic_link *link = &worker->links[i];
        if (views) splats->source = keep_view(views, &link->view, splats);
        splat_add(splats, job->scene->sensor, link->film, link->value);
    }
}

static bool scatter_particle(const struct caustic_job *job, struct caustic_particle *particle) {
    if (!particle->scatters) {
        particle->beta = rgb_mul(particle->beta, particle->fork.weight);
        particle->ray = surface_spawn_ray(&particle->surface, particle->ray.direction);
    } else {
        particle->depth++;
        if (job->scene->max_depth >= 0 && particle->depth + 1 >= job->scene->max_depth) return false;
        vec2 u = sampler_2d(&particle->sampler);
        vec3 number = {u.x, u.y, sampler_1d(&particle->sampler)};
        struct bsdf_sample sample;
        if (!surface_sample_bsdf(&particle->surface, vec3_neg(particle->ray.direction), number, TRANSPORT_IMPORTANCE,
                                 &sample))
            return false;
        if (particle->stage == CAUSTIC_NEAR) {
            if (!sample.delta) return false;
            particle->stage = CAUSTIC_IN_ROOM;
        }
        particle->beta = rgb_mul(particle->beta, rgb_mul(sample.weight, particle->fork.weight));
        float survival = fminf(rgb_max(particle->beta) / particle->start, max_survival);
        if (!(sampler_1d(&particle->sampler) < survival)) return false;
        particle->beta = rgb_scale(particle->beta, 1 / survival);
        particle->ray = surface_spawn_ray(&particle->surface, sample.wo);
        particle->kept = particle->surface.shape->luminaire;
    }
    particle->from = particle->surface;
    return !rgb_is_black(particle->beta);
}

static void scatter(const struct caustic_job *job, struct caustic_worker *worker) {
    size_t kept = 0;
    for (size_t i = 0; i < worker->active_count; i++)
        if (scatter_particle(job, &worker->particles[worker->active[i]])) worker->active[kept++] = worker->active[i];
    worker->active_count = kept;
}

void caustic_trace_block(const struct caustic_job *job, const struct caustic_block *block,
                         struct caustic_worker *worker, struct splat_list *splats, struct caustic_views *views) {
    if (job->residual)
        emit(job, block, worker);
    else
        begin(job, block, worker);
    while (worker->active_count) {
        hit(job, (int)block->luminaire, worker);
        connect(job, worker, splats, views);
        scatter(job, worker);
    }
}
