// Path tracer: the baked lamps that a ray meets before its surface. Each adds its radiance, dimmed by the lamps in
// front of it, and dims what comes after. Not met are: the lamp whose kept geometry the ray leaves (its own light is in
// L, and the geometry itself does the dimming, or its sheet is left), and on rays that look at it a lamp that shows its
// real geometry or its hull. A path that ends on a lamp's kept geometry gets that lamp's L wherever on the chord the
// surface stands, and no T.
#include "trace/path_state.h"

#include <stdlib.h>

static bool stops_inside(const struct path *path, int luminaire) {
    return path->status == PATH_SCATTERS && path->surface.shape->luminaire == luminaire;
}

static void path_find_crossings(const struct path_tracer *tracer, struct path_worker *worker, uint32_t index) {
    struct path *path = &worker->paths[index];
    for (size_t i = 0; i < tracer->scene->luminaire_count; i++) {
        const struct luminaire_instance *instance = &tracer->scene->luminaires[i];
        if ((int)i == path->vertex.kept || (path->look && instance->appearance != APPEARANCE_NEURAL)) continue;
        float t_mid;
        if (!crossing_find(instance, &path->ray, &t_mid)) continue;
        bool stops = stops_inside(path, (int)i);
        float t_end = path->status == PATH_MISSES ? path->ray.t_max : path->surface.t;
        if (t_mid >= t_end && !stops) continue;
        struct crossing *crossing = crossing_add(&worker->crossings, index, (uint32_t)i, &path->ray, t_mid);
        crossing->viewpoint = path->mirror_pdf > 0 ? path->mirrored : path->vertex.p;
        crossing->looks = path->look;
        // Sheet, mirror, lamp: a ten-thousandth of the light and half of the noise, met by chance only. Left out.
        crossing->wants_radiance = !path_is_caustic(tracer, path) && !(path->from_sheet && path->pdf == 0);
        crossing->wants_transmittance = instance->keep != KEEP_ALL && !stops;
        crossing->wants_pdf = path->mirror_pdf > 0 || (path->pdf > 0 && tracer->strategy != PATH_BSDF_ONLY);
        path->dimmed |= crossing->wants_transmittance;
    }
}

static int crossing_order(const void *a, const void *b) {
    float ta = ((const struct crossing *)a)->t_mid, tb = ((const struct crossing *)b)->t_mid;
    return (ta > tb) - (ta < tb);
}

// A light sample of this lamp looks past its kept geometry as far as the event: so must the ray that ended there.
static rgb visibility_beyond(const struct path_tracer *tracer, const struct path *path,
                             const struct crossing *crossing) {
    if (!stops_inside(path, (int)crossing->luminaire) || crossing->t_mid <= path->surface.t) return rgb_gray(1);
    struct ray rest = surface_spawn_ray(&path->surface, path->ray.direction);
    rest.t_max = crossing->t_mid - path->surface.t;
    struct lamp_view view = {false, -1, (int)crossing->luminaire};
    return lamp_view_visibility(tracer->scene, tracer->hidden, &view, &rest);
}

// Light that the lamp stops is scattered, by chance: the path then ends its edge there. *u: used up by degrees.
static bool path_scatters_at_lamp(const struct path_tracer *tracer, struct path *path, const struct crossing *crossing,
                                  float *u) {
    const struct luminaire_instance *instance = &tracer->scene->luminaires[crossing->luminaire];
    const rgb through = rgb_mul(path->beta, crossing->transmittance), stopped = rgb_sub(path->beta, through);
    float scatters = 0, chance = 0;
    if (instance->sheet) scatters = rgb_luminance(rgb_mul(stopped, bsdf_albedo(instance->sheet->bsdf, (vec2){0, 0})));
    if (scatters > 0) chance = scatters / (scatters + rgb_luminance(through));
    path->beta = rgb_scale(through, chance < 1 ? 1 / (1 - chance) : 0);
    if (*u >= chance) {
        *u = chance > 0 ? (*u - chance) / (1 - chance) : *u;
        return false;
    }
    path->beta = rgb_scale(stopped, 1 / chance);
    luminaire_sheet_hit(instance, &path->ray, crossing->t_mid, &path->surface);
    path->status = PATH_SCATTERS;
    path->fork = fork_none();
    return true;
}

static void path_meet(const struct path_tracer *tracer, struct path_worker *worker, struct crossing *crossings,
                      size_t count) {
    if (count > 1) qsort(crossings, count, sizeof *crossings, crossing_order);
    struct path *path = &worker->paths[crossings[0].item];
    struct sampler sampler = path_sampler(path, PATH_DIMENSION_SHEET);
    float u = sampler_1d(&sampler);
    for (size_t i = 0; i < count; i++) {
        const struct crossing *crossing = &crossings[i];
        float weight = path_crossing_weight(tracer, path, crossing);
        if (weight > 0 && !rgb_is_black(crossing->radiance)) {
            rgb radiance = rgb_mul(crossing->radiance, visibility_beyond(tracer, path, crossing));
            if (stops_inside(path, (int)crossing->luminaire)) radiance = rgb_mul(radiance, path->fork.weight);
            const rgb contribution = rgb_scale(rgb_mul(path->beta, radiance), weight);
            path_record_lamp(path, contribution, crossing->t_mid);
            path_add(worker, path, contribution);
        }
        if (crossing->wants_transmittance && path_scatters_at_lamp(tracer, path, crossing, &u)) return;
    }
}

void path_luminaire(const struct path_tracer *tracer, struct path_worker *worker) {
    size_t lines = crossing_batch_lines(&worker->crossings);
    for (size_t first = 0; first < worker->active_count; first += lines) {
        worker->crossings.count = 0;
        for (size_t i = first; i < worker->active_count && i - first < lines; i++)
            path_find_crossings(tracer, worker, worker->active[i]);
        crossing_batch_answer(&worker->crossings, tracer->scene);
        struct crossing *crossings = worker->crossings.crossings;
        for (size_t i = 0, n; i < worker->crossings.count; i += n) {
            for (n = 1; i + n < worker->crossings.count && crossings[i + n].item == crossings[i].item;) n++;
            path_meet(tracer, worker, crossings + i, n);
        }
    }
}
