// Single lines through a lamp. Where a path scatters by no delta, a second one starts from there towards the emitters
// and goes on for as long as it meets deltas only: through whatever clear glass stands in between, which is where a
// shadow ray would have stopped. What the two both reach is shared by the balance heuristic (Veach and Guibas 1995), so
// that no path's weight grows, however often white surfaces scatter it. An emitter's cone is chosen in proportion to
// its solid angle: the density of the choice is (cones that hold w) / (their sum).
#include "trace/line_radiance.h"

#include "trace/fork.h"

static const int roulette_depth = 6;
enum { DIMENSIONS_PER_EDGE = 8, AIMED_DIMENSIONS = 1 << 20, DIMENSIONS_PER_AIMED = 1 << 10 };
enum { SPLIT_DIMENSIONS = 1 << 22 }; // shifted by how many splits are left: no two of a line's paths have the same

// Cosine of the cone's half angle; -1 (every direction) from inside the sphere.
static float aim_cos_max(const struct aim *aim, vec3 p, vec3 *axis) {
    vec3 offset = vec3_sub(aim->center, p);
    float distance2 = vec3_dot(offset, offset), radius2 = sqrf(aim->radius);
    if (distance2 <= radius2) {
        *axis = (vec3){0, 0, 1};
        return -1;
    }
    *axis = vec3_scale(offset, 1 / sqrtf(distance2));
    return sqrtf(1 - radius2 / distance2);
}

// 1 - cos without the cancellation of narrow cones; [sr] / 2 pi.
static float aim_weight(const struct aim *aim, vec3 p) {
    vec3 offset = vec3_sub(aim->center, p);
    float distance2 = vec3_dot(offset, offset), radius2 = sqrf(aim->radius);
    if (distance2 <= radius2) return 2;
    float sin2 = radius2 / distance2;
    return sin2 / (1 + sqrtf(1 - sin2));
}

static float aims_pdf(const struct aim *aims, size_t count, vec3 p, vec3 w) {
    float total = 0, held = 0;
    for (size_t i = 0; i < count; i++) {
        vec3 axis;
        float cos_max = aim_cos_max(&aims[i], p, &axis);
        total += aim_weight(&aims[i], p);
        held += vec3_dot(axis, w) >= cos_max ? 1.0f : 0.0f;
    }
    return total > 0 ? held / (2 * PI_F * total) : 0;
}

static vec3 aims_sample(const struct aim *aims, size_t count, vec3 p, float u_choice, vec2 u) {
    float total = 0;
    for (size_t i = 0; i < count; i++) total += aim_weight(&aims[i], p);
    float left = u_choice * total;
    size_t chosen = 0;
    for (; chosen + 1 < count; chosen++) {
        left -= aim_weight(&aims[chosen], p);
        if (left < 0) break;
    }
    vec3 axis;
    aim_cos_max(&aims[chosen], p, &axis);
    float height = u.x * aim_weight(&aims[chosen], p), cos_theta = 1 - height; // uniform in the cone
    float sin_theta = sqrtf(fmaxf(0, height * (2 - height))), phi = 2 * PI_F * u.y;
    struct frame frame = frame_from_normal(axis);
    return frame_world_from_local(&frame, (vec3){sin_theta * cosf(phi), sin_theta * sinf(phi), cos_theta});
}

// To the next surface of the lamp, and what the way there absorbs.
static bool walk_advance(struct line_walk *walk) {
    while (scene_intersect(walk->scene, &walk->ray, -1, &walk->surface)) {
        walk->beta = rgb_mul(walk->beta, segment_absorption(walk->has_from ? &walk->from : NULL, &walk->surface,
                                                            walk->ray.direction, walk->surface.t));
        if (walk->surface.shape->luminaire == walk->luminaire) return true;
        walk->beta = rgb_mul(walk->beta, surface_through(&walk->surface, vec3_neg(walk->ray.direction)));
        if (rgb_is_black(walk->beta)) return false;
        walk->from = walk->surface;
        walk->has_from = true;
        walk->ray = surface_spawn_ray(&walk->surface, walk->ray.direction);
    }
    return false;
}

bool line_walk_begin(struct line_walk *walk, const struct scene *scene, int luminaire, const struct ray *ray,
                     const struct surface *from) {
    walk->scene = scene;
    walk->luminaire = luminaire;
    walk->ray = *ray;
    walk->beta = rgb_gray(1);
    if ((walk->has_from = from != NULL)) walk->from = *from;
    walk->particles_too = false;
    return walk_advance(walk);
}

void line_walk_begin_at(struct line_walk *walk, const struct scene *scene, const struct ray *ray,
                        const struct surface *from, const struct surface *surface) {
    walk->scene = scene;
    walk->luminaire = surface->shape->luminaire;
    walk->ray = *ray;
    walk->surface = *surface;
    walk->has_from = false;
    walk->particles_too = false;
    walk->beta = segment_absorption(from, surface, ray->direction, surface->t);
}

struct line_path {
    struct line_walk walk;
    struct sampler sampler;
    uint32_t first_dimension;
    int depth;
    float eta, travelled;
    float share; // of what it reaches by deltas only: the rest is its aimed twin's
    bool aimed; // is such a twin
    int splits; // that are left
    float split_share; // of the light that is not left to chance, in beta
};

static bool survives(struct line_path *path, float u) {
    if (path->depth < roulette_depth) return true;
    float survival = fminf(rgb_max(path->walk.beta) * path->eta * path->eta / path->split_share, 0.95f);
    if (u >= survival) return false;
    path->walk.beta = rgb_scale(path->walk.beta, 1 / survival);
    return true;
}

// A twin of the path at the surface it has met, on its way to an emitter.
static bool aim_twin(struct line_path *twin, const struct line_path *path, vec3 wi, const struct fork *fork,
                     const struct aim *aims, size_t aim_count) {
    *twin = *path;
    const struct surface *surface = &path->walk.surface;
    twin->first_dimension = path->first_dimension + AIMED_DIMENSIONS + (uint32_t)path->depth * DIMENSIONS_PER_AIMED;
    twin->aimed = true;
    twin->share = 1;
    float u_choice = sampler_1d(&twin->sampler);
    vec3 wo = aims_sample(aims, aim_count, surface->p, u_choice, sampler_2d(&twin->sampler));
    rgb f = surface_eval_bsdf(surface, wi, wo, TRANSPORT_RADIANCE);
    if (rgb_is_black(f)) return false;
    float pdf = surface_pdf_bsdf(surface, wi, wo, TRANSPORT_RADIANCE) + aims_pdf(aims, aim_count, surface->p, wo);
    if (!(pdf > 0)) return false;
    twin->walk.beta = rgb_mul(path->walk.beta, rgb_scale(f, fork->inverse_share / pdf));
    twin->walk.from = *surface;
    twin->walk.has_from = true;
    twin->walk.ray = surface_spawn_ray(surface, wo);
    twin->depth++;
    return !rgb_is_black(twin->walk.beta);
}

bool surface_split(const struct surface *surface, vec3 wi, struct bsdf_sample *reflected,
                   struct bsdf_sample *refracted) {
    static const vec3 reflects = {0.5f, 0.5f, 0}, refracts = {0.5f, 0.5f, 0.99999994f};
    return surface_bsdf_flags(surface) == (BSDF_DELTA | BSDF_TRANSMISSION) &&
           surface_sample_bsdf(surface, wi, reflects, TRANSPORT_RADIANCE, reflected) &&
           surface_sample_bsdf(surface, wi, refracts, TRANSPORT_RADIANCE, refracted) && reflected->eta == 1 &&
           refracted->eta != 1 && reflected->delta && refracted->delta;
}

static void take_way(struct line_path *path, const struct bsdf_sample *way) {
    path->walk.from = path->walk.surface;
    path->walk.has_from = true;
    path->walk.beta = rgb_mul(path->walk.beta, rgb_scale(way->weight, way->pdf));
    path->split_share *= way->pdf;
    path->eta *= way->eta;
    path->depth++;
    path->splits--;
    path->walk.ray = surface_spawn_ray(&path->walk.from, way->wo);
}

static void path_follow(struct line_path *path, const struct aim *aims, size_t aim_count, int max_depth,
                        struct line_hit *out) {
    struct line_walk *walk = &path->walk;
    for (uint32_t edge = 0;; edge++) {
        path->sampler.dimension = path->first_dimension + edge * DIMENSIONS_PER_EDGE;
        vec3 wi = vec3_neg(walk->ray.direction);
        path->travelled += walk->surface.t;
        rgb emitted = rgb_scale(rgb_mul(walk->beta, surface_emission(&walk->surface, wi)), path->share);
        bool first = walk->particles_too && path->depth == 0;
        if (rgb_is_finite(emitted) && !(first && walk->scene->hide_emitters))
            out->radiance = rgb_add(out->radiance, emitted);
        struct fork fork = fork_none();
        float u_fork = sampler_1d(&path->sampler), u_roulette = sampler_1d(&path->sampler);
        unsigned flags = surface_bsdf_flags(&walk->surface);
        if (flags & BSDF_NULL) fork = fork_choose(&walk->surface, wi, u_fork);
        if (!fork.passes && !out->hit) {
            out->hit = true;
            out->distance = path->travelled;
        }
        struct bsdf_sample reflected, refracted;
        if (path->splits > 0 && surface_split(&walk->surface, wi, &reflected, &refracted)) {
            struct line_path twin = *path;
            twin.first_dimension += SPLIT_DIMENSIONS << path->splits;
            take_way(&twin, &reflected);
            if ((max_depth < 0 || twin.depth < max_depth) && survives(&twin, u_roulette) && walk_advance(&twin.walk))
                path_follow(&twin, aims, aim_count, max_depth, out);
            take_way(path, &refracted);
        } else if (fork.passes) {
            walk->beta = rgb_mul(walk->beta, fork.weight);
            walk->from = walk->surface;
            walk->ray = surface_spawn_ray(&walk->from, walk->ray.direction);
        } else {
            float u_third = sampler_1d(&path->sampler);
            vec2 u = sampler_2d(&path->sampler);
            bool aims_too = aim_count > 0 && (flags & BSDF_SMOOTH);
            struct line_path twin;
            if (aims_too && !path->aimed && !first && aim_twin(&twin, path, wi, &fork, aims, aim_count) &&
                (max_depth < 0 || twin.depth < max_depth) && walk_advance(&twin.walk))
                path_follow(&twin, aims, aim_count, max_depth, out);
            walk->from = walk->surface;
            struct bsdf_sample sample;
            if (!surface_sample_bsdf(&walk->from, wi, (vec3){u.x, u.y, u_third}, TRANSPORT_RADIANCE, &sample)) break;
            if (!sample.delta && (path->aimed || first)) break;
            if (!sample.delta)
                path->share =
                    aims_too ? sample.pdf / (sample.pdf + aims_pdf(aims, aim_count, walk->from.p, sample.wo)) : 1;
            walk->beta = rgb_mul(walk->beta, rgb_mul(sample.weight, fork.weight));
            path->eta *= sample.eta;
            path->depth++;
            walk->ray = surface_spawn_ray(&walk->from, sample.wo);
        }
        walk->has_from = true;
        if (!rgb_is_finite(walk->beta) || rgb_is_black(walk->beta) || !survives(path, u_roulette)) break;
        if ((max_depth >= 0 && path->depth >= max_depth) || !walk_advance(walk)) break;
    }
}

static void walk_radiance(const struct line_walk *begun, struct sampler *sampler, const struct aim *aims,
                          size_t aim_count, int max_depth, int splits, struct line_hit *out) {
    *out = (struct line_hit){.distance = begun->ray.t_max};
    struct line_path path = {.walk = *begun,
                             .sampler = *sampler,
                             .first_dimension = sampler->dimension,
                             .eta = 1,
                             .share = 1,
                             .splits = splits,
                             .split_share = 1};
    path_follow(&path, aims, aim_count, max_depth, out);
}

void line_walk_radiance(const struct line_walk *begun, struct sampler *sampler, const struct aim *aims,
                        size_t aim_count, int max_depth, struct line_hit *out) {
    walk_radiance(begun, sampler, aims, aim_count, max_depth, 0, out);
}

void trace_line_radiance_split(const struct scene *scene, const struct ray *ray, struct sampler *sampler,
                               const struct aim *aims, size_t aim_count, int max_depth, int splits,
                               struct line_hit *out) {
    struct line_walk walk;
    if (line_walk_begin(&walk, scene, -1, ray, NULL))
        walk_radiance(&walk, sampler, aims, aim_count, max_depth, splits, out);
    else
        *out = (struct line_hit){.distance = ray->t_max};
}

void trace_line_radiance(const struct scene *scene, const struct ray *ray, struct sampler *sampler,
                         const struct aim *aims, size_t aim_count, int max_depth, struct line_hit *out) {
    trace_line_radiance_split(scene, ray, sampler, aims, aim_count, max_depth, 0, out);
}

rgb trace_line_transmittance(const struct scene *scene, const struct ray *straight, struct sampler *sampler,
                             int max_depth, float cos_limit) {
    struct ray ray = *straight;
    struct surface surface, from;
    bool has_from = false;
    rgb beta = rgb_gray(1);
    const uint32_t first_dimension = sampler->dimension;
    for (uint32_t edge = 0; max_depth < 0 || edge < (uint32_t)max_depth; edge++) {
        if (!scene_intersect(scene, &ray, -1, &surface))
            return vec3_dot(ray.direction, straight->direction) >= cos_limit ? beta : rgb_gray(0);
        sampler->dimension = first_dimension + edge * DIMENSIONS_PER_EDGE;
        vec3 wi = vec3_neg(ray.direction), wo = ray.direction;
        beta = rgb_mul(beta, segment_absorption(has_from ? &from : NULL, &surface, ray.direction, surface.t));
        struct fork fork = fork_none();
        float u_fork = sampler_1d(sampler);
        if (surface_bsdf_flags(&surface) & BSDF_NULL) fork = fork_choose(&surface, wi, u_fork);
        beta = rgb_mul(beta, fork.weight);
        if (!fork.passes) {
            struct bsdf_sample sample;
            vec2 u = sampler_2d(sampler);
            if (!surface_sample_bsdf(&surface, wi, (vec3){u.x, u.y, sampler_1d(sampler)}, TRANSPORT_RADIANCE, &sample))
                return rgb_gray(0);
            bool reflects = vec3_dot(sample.wo, surface.ng) * vec3_dot(wi, surface.ng) >= 0;
            if (reflects && cos_limit > 0) return rgb_gray(0);
            beta = rgb_mul(beta, sample.weight);
            wo = sample.wo;
        }
        if (!rgb_is_finite(beta) || rgb_is_black(beta)) return rgb_gray(0);
        ray = surface_spawn_ray(&surface, wo);
        from = surface;
        has_from = true;
    }
    return rgb_gray(0);
}
