// Path tracer: rays that looked at a lamp and ended on a part of its hull other than glass. The view field's radiance
// there is all the light that the lamp sends along the ray. An opaque part ends the path; behind a translucent one it
// goes straight on, dimmed by the transparency, past everything else of that lamp.
#include "luminaire/hull.h"
#include "luminaire/view_field.h"
#include "trace/path_state.h"

static bool ends_on_hull(const struct path *path) {
    const struct hull_part *part = path->status == PATH_MISSES ? NULL : path->surface.shape->hull;
    return part && part->kind != HULL_GLASS;
}

static struct view_point view_point_make(const struct path *path, const struct luminaire_instance *instance) {
    const struct surface *surface = &path->surface;
    struct view_point at = {.part = (uint32_t)(surface->shape->hull - luminaire_hull(instance->luminaire)->parts)};
    vec3_store(at.point, luminaire_local_point(instance, surface->p));
    vec3_store(at.normal, luminaire_local_direction(instance, surface->shading.n));
    vec3_store(at.w, luminaire_local_direction(instance, vec3_neg(path->ray.direction)));
    return at;
}

static void show(struct path_worker *worker, struct path *path, const struct luminaire_instance *instance,
                 const float radiance[3]) {
    rgb light = rgb_mul(rgb_make(radiance[0], radiance[1], radiance[2]), instance->dim);
    rgb absorption =
        segment_absorption(path->has_from ? &path->from : NULL, NULL, path->ray.direction, path->surface.t);
    path_add(worker, path, rgb_mul(rgb_mul(path->beta, absorption), light));
}

static void go_on(struct path *path, const float transmittance[3]) {
    path->beta = rgb_mul(path->beta, rgb_make(transmittance[0], transmittance[1], transmittance[2]));
    path->status = rgb_is_black(path->beta) ? PATH_DONE : PATH_PASSES;
    path->through = path->surface.shape->luminaire;
}

enum { BATCH = 64 };

static void answer(struct path_worker *worker, const struct luminaire_instance *instance, const uint32_t *indices,
                   size_t count) {
    struct view_point points[BATCH] = {0};
    float radiance[BATCH][3], at[BATCH][3], w[BATCH][3];
    for (size_t i = 0; i < count; i++) {
        points[i] = view_point_make(&worker->paths[indices[i]], instance);
        for (int a = 0; a < 3; a++) at[i][a] = points[i].point[a], w[i][a] = points[i].w[a];
    }
    luminaire_view(instance->luminaire, count, points, radiance);
    for (size_t i = 0; i < count; i++) show(worker, &worker->paths[indices[i]], instance, radiance[i]);
    luminaire_transmittance(instance->luminaire, count, (const float(*)[3])at, (const float(*)[3])w, radiance);
    for (size_t i = 0; i < count; i++) {
        struct path *path = &worker->paths[indices[i]];
        if (path->surface.shape->hull->kind == HULL_OPAQUE)
            path->status = PATH_DONE;
        else
            go_on(path, radiance[i]);
    }
}

void path_view(const struct path_tracer *tracer, struct path_worker *worker) {
    for (size_t l = 0; l < tracer->scene->luminaire_count; l++) {
        const struct luminaire_instance *instance = &tracer->scene->luminaires[l];
        uint32_t indices[BATCH];
        size_t count = 0;
        for (size_t i = 0; instance->appearance == APPEARANCE_SURFACE && i < worker->active_count; i++) {
            const struct path *path = &worker->paths[worker->active[i]];
            if (!ends_on_hull(path) || path->surface.shape->luminaire != (int)l) continue;
            indices[count++] = worker->active[i];
            if (count < BATCH) continue;
            answer(worker, instance, indices, count);
            count = 0;
        }
        if (count) answer(worker, instance, indices, count);
    }
}
