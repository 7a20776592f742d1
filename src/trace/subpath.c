// The walks of subpath.h: one edge at a time, and the scattering that updates the sums.
#include "trace/subpath.h"

static const float min_cos = 1e-6f;
static const float max_survival = 0.95f;

// d_vcm of the first vertex of a light's walk: mis(density of next-event estimation at the light / density of the
// walk).
static double light_d_vcm(const struct walk *walk, vec3 p, double distance2) {
    const struct emitter *emitter = walk->emitter;
    const struct emission_sample *emission = walk->emission;
    if (!walk->lights) return 0;
    struct light_point point = {p, -1, -1};
    double pmf = light_select_pmf_emitter(walk->lights, &point, emitter), direct = 1;
    if (emitter->flags & EMITTER_DELTA_POSITION)
        direct = distance2;
    else if (!(emitter->flags & EMITTER_DELTA_DIRECTION))
        direct = (double)emission->cos_theta * emitter->type->pdf_light(emitter, p,
                                                                        emitter->shape ? &emission->surface : NULL,
                                                                        vec3_neg(walk->ray.direction));
    return mis(pmf * direct / ((double)walk->emission_pmf * emission->pdf_position * emission->pdf_direction));
}

enum walk_event walk_advance(struct walk *walk, struct sampler *sampler, struct vertex *vertex) {
    struct surface *surface = &vertex->surface;
    if (!scene_intersect(walk->scene, &walk->ray, -1, surface)) return WALK_ESCAPED;
    const struct surface *from = walk->has_from ? &walk->from : NULL;
    float travelled = walk->travelled + surface->t;
    rgb absorbed = segment_absorption(from, surface, walk->ray.direction, surface->t);
    vertex->wi = vec3_neg(walk->ray.direction);
    vertex->arrived = rgb_mul(walk->beta, absorbed);
    vertex->depth = walk->depth + 1;
    double distance2 = (double)travelled * travelled;
    double per_cos = mis(1 / maxf(fabsf(vec3_dot(surface->ng, vertex->wi)), min_cos));
    vertex->d_vc = walk->d_vc * per_cos;
    if (walk->emission)
        vertex->d_vcm = light_d_vcm(walk, surface->p, distance2) * per_cos;
    else
        vertex->d_vcm = walk->d_vcm * per_cos * (walk->distant ? 1 : mis(distance2));
    vertex->flags = surface_bsdf_flags(surface);
    struct fork fork = vertex->flags & BSDF_NULL ? fork_choose(surface, vertex->wi, sampler_1d(sampler)) : fork_none();
    if (fork.passes) {
        walk->beta = rgb_mul(vertex->arrived, fork.weight);
        walk->ray = surface_spawn_ray(surface, walk->ray.direction);
        walk->travelled = travelled;
        if (walk->mirrored) walk->d_vcm = 0; // mirror_link.h sees the mirror only where it is met first
        walk->from = *surface;
        walk->has_from = true;
        return WALK_PASSED;
    }
    vertex->beta = rgb_scale(vertex->arrived, fork.inverse_share);
    vertex->scatter = rgb_mul(vertex->arrived, fork.weight);
    return WALK_HIT;
}

static bool meets_first_mirror(const struct walk *walk, const struct vertex *vertex, const struct bsdf_sample *sample) {
    return walk->mirrors && !walk->mirrored && mirror_reflects(&vertex->surface, vertex->wi, sample) &&
           mirror_at(walk->mirrors, &vertex->surface);
}

bool walk_scatter(struct walk *walk, const struct vertex *vertex, struct sampler *sampler, int rr_depth) {
    vec2 u = sampler_2d(sampler);
    vec3 number = {u.x, u.y, sampler_1d(sampler)};
    struct bsdf_sample sample;
    if (!surface_sample_bsdf(&vertex->surface, vertex->wi, number, walk->transport, &sample)) return false;
    walk->beta = rgb_mul(vertex->scatter, sample.weight);
    walk->depth = vertex->depth;
    float brightness = rgb_max(walk->beta);
    if (!(brightness > 0) || !isfinite(brightness)) return false;
    if (walk->transport == TRANSPORT_RADIANCE) walk->eta2 *= sqrf(sample.eta);
    if (walk->depth >= rr_depth) {
        float survival = minf(brightness * walk->eta2 / walk->start, max_survival);
        if (sampler_1d(sampler) >= survival) return false;
        walk->beta = rgb_scale(walk->beta, 1 / survival);
    }
    double cos_out = maxf(fabsf(vec3_dot(vertex->surface.ng, sample.wo)), min_cos);
    walk->mirrored = meets_first_mirror(walk, vertex, &sample);
    if (!walk->mirrored) walk->mirrors = NULL;
    if (sample.delta) { // the densities there and back are the same, and nothing connects to a delta
        walk->d_vc = vertex->d_vc * mis(cos_out);
        if (!walk->mirrored) walk->d_vcm = 0;
    } else {
        enum transport reverse = walk->transport == TRANSPORT_RADIANCE ? TRANSPORT_IMPORTANCE : TRANSPORT_RADIANCE;
        double pdf_reverse = surface_pdf_bsdf(&vertex->surface, sample.wo, vertex->wi, reverse);
        walk->d_vc = mis(cos_out / sample.pdf) * (vertex->d_vc * mis(pdf_reverse) + vertex->d_vcm);
        walk->d_vcm = mis(1 / (double)sample.pdf);
    }
    walk->ray = surface_spawn_ray(&vertex->surface, sample.wo);
    walk->from = vertex->surface;
    walk->vertex_p = vertex->surface.p;
    walk->has_from = true;
    walk->travelled = walk->mirrored ? walk->travelled + vertex->surface.t : 0;
    walk->distant = walk->distant && walk->mirrored;
    walk->emission = NULL;
    return true;
}
