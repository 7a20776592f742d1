// Particles for the baker: as the walks of subpath.h, without the sums that only connections need. Lamps have few
// emitters, so the choice in proportion to power is a plain scan.
#include "trace/particle_exit.h"

#include "trace/fork.h"

static const int max_edges = 4096; // a bound for unlimited particles in a lamp that loses nothing

static const struct emitter *choose_emitter(const struct scene *scene, float u, float *pmf) {
    float total = 0;
    for (size_t i = 0; i < scene->emitter_count; i++) total += fmaxf(rgb_mean(scene->emitters[i]->power), 0);
    const struct emitter *chosen = NULL;
    float left = u * total;
    for (size_t i = 0; i < scene->emitter_count; i++) {
        float power = fmaxf(rgb_mean(scene->emitters[i]->power), 0);
        if (!(power > 0)) continue;
        chosen = scene->emitters[i];
        *pmf = power / total;
        left -= power;
        if (left < 0) break;
    }
    return chosen;
}

void trace_particle(const struct scene *scene, struct sampler *sampler, int max_depth, struct particle_exit *exit) {
    trace_particle_source(scene, NULL, sampler, max_depth, exit, NULL);
}

// `glass` goes with `source`; absorbed: by the glass behind the source.
static void mark_source(struct particle_source *source, const bool *glass, const struct surface *surface,
                        vec3 direction, rgb *absorbed) {
    if (!source || glass[surface->shape->index]) return;
    source->surface = *surface;
    source->direction = direction;
    *absorbed = rgb_gray(1);
}

void trace_particle_source(const struct scene *scene, const bool *glass, struct sampler *sampler, int max_depth,
                           struct particle_exit *exit, struct particle_source *source) {
    *exit = (struct particle_exit){0};
    if (source) *source = (struct particle_source){0};
    rgb absorbed = rgb_gray(1);
    float pmf = 1;
    const struct emitter *emitter = choose_emitter(scene, sampler_1d(sampler), &pmf);
    struct emission_sample emission;
    vec2 u_position = sampler_2d(sampler), u_direction = sampler_2d(sampler);
    if (!emitter || !emitter->type->sample_emission(emitter, u_position, u_direction, &emission)) return;
    rgb beta =
        rgb_scale(emission.radiance, emission.cos_theta / (emission.pdf_position * emission.pdf_direction * pmf));
    float start = rgb_max(beta);
    if (!(start > 0) || !isfinite(start)) return;
    exit->point = exit->emission_point = emitter->shape ? emission.surface.p : emission.ray.origin;

    struct surface surfaces[2], *from = emitter->shape ? &emission.surface : NULL;
    struct ray ray = emission.ray;
    if (from) mark_source(source, glass, from, ray.direction, &absorbed);
    int last_edge = max_depth < 0 ? max_edges : max_depth, edge = 1, slot = 0;
    for (int rays = 0; rays < max_edges; rays++) {
        struct surface *surface = &surfaces[slot];
        exit->rays++;
        if (!scene_intersect(scene, &ray, -1, surface)) {
            if (edge > last_edge) return;
            exit->direction = ray.direction;
            exit->flux = beta;
            exit->escaped = rgb_is_finite(beta);
            if (!exit->escaped) exit->flux = rgb_gray(0);
            if (source) source->flux = rgb_make(beta.r / absorbed.r, beta.g / absorbed.g, beta.b / absorbed.b);
            return;
        }
        slot ^= 1;
        vec3 wi = vec3_neg(ray.direction);
        rgb absorption = segment_absorption(from, surface, ray.direction, surface->t);
        beta = rgb_mul(beta, absorption);
        absorbed = rgb_mul(absorbed, absorption);
        from = surface;
        struct fork fork =
            surface_bsdf_flags(surface) & BSDF_NULL ? fork_choose(surface, wi, sampler_1d(sampler)) : fork_none();
        beta = rgb_mul(beta, fork.weight);
        if (fork.passes) {
            mark_source(source, glass, surface, ray.direction, &absorbed);
            ray = surface_spawn_ray(surface, ray.direction);
            continue;
        }
        vec2 u = sampler_2d(sampler);
        struct bsdf_sample sample;
        if (++edge > last_edge ||
            !surface_sample_bsdf(surface, wi, (vec3){u.x, u.y, sampler_1d(sampler)}, TRANSPORT_IMPORTANCE, &sample))
            return;
        beta = rgb_mul(beta, sample.weight);
        float survival = rgb_max(beta) / start;
        if (survival < 1) {
            if (sampler_1d(sampler) >= survival) return;
            beta = rgb_scale(beta, 1 / survival);
        }
        exit->point = surface->p;
        mark_source(source, glass, surface, sample.wo, &absorbed);
        ray = surface_spawn_ray(surface, sample.wo);
    }
}
