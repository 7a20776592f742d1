// Rays and baked lamps (the rule is in the header). Between the room, where integrators trace, and the luminaire, which
// answers batches of lines in its own coordinates: a rotation, a translation and a uniform scale lie between the two,
// so radiance and densities per solid angle carry over unchanged.
#include "trace/luminaire_crossing.h"

#include <stdlib.h>

enum status crossing_batch_init(struct crossing_batch *batch, const struct scene *scene, size_t lines,
                                struct error *error) {
    size_t lamps = scene->luminaire_count, n = lines < 1 ? 1 : lines;
    *batch = (struct crossing_batch){.luminaire_count = lamps};
    if (!lamps) return STATUS_OK;
    if (n < lamps) n = lamps;
    batch->capacity = n;
    batch->crossings = calloc(n, sizeof *batch->crossings);
    batch->order = calloc(n, sizeof *batch->order);
    batch->starts = calloc(lamps + 1, sizeof *batch->starts);
    batch->point = calloc(n, sizeof *batch->point);
    batch->w = calloc(n, sizeof *batch->w);
    batch->answer = calloc(n, sizeof *batch->answer);
    batch->pdf = calloc(n, sizeof *batch->pdf);
    if (batch->crossings && batch->order && batch->starts && batch->point && batch->w && batch->answer && batch->pdf)
        return STATUS_OK;
    crossing_batch_fini(batch);
    return error_set(error, STATUS_MEMORY, "out of memory for rays that cross %zu luminaires", lamps);
}

void crossing_batch_fini(struct crossing_batch *batch) {
    free(batch->crossings);
    free(batch->order);
    free(batch->starts);
    free(batch->point);
    free(batch->w);
    free(batch->answer);
    free(batch->pdf);
    *batch = (struct crossing_batch){0};
}

size_t crossing_batch_lines(const struct crossing_batch *batch) {
    return batch->luminaire_count ? batch->capacity / batch->luminaire_count : SIZE_MAX;
}

rgb luminaire_power(const struct luminaire_instance *instance) {
    float flux[3];
    luminaire_flux(instance->luminaire, flux);
    return rgb_scale(rgb_mul(instance->dim, (rgb){flux[0], flux[1], flux[2]}), sqrf(instance->scale));
}

static vec3 rotate_scaled(const float m[4][4], vec3 v, float scale) {
    return (vec3){scale * (m[0][0] * v.x + m[0][1] * v.y + m[0][2] * v.z),
                  scale * (m[1][0] * v.x + m[1][1] * v.y + m[1][2] * v.z),
                  scale * (m[2][0] * v.x + m[2][1] * v.y + m[2][2] * v.z)};
}

vec3 luminaire_local_direction(const struct luminaire_instance *instance, vec3 w) {
    return rotate_scaled(instance->to_world.inverse, w, instance->scale);
}

vec3 luminaire_world_direction(const struct luminaire_instance *instance, vec3 w) {
    return rotate_scaled(instance->to_world.m, w, 1 / instance->scale);
}

vec3 luminaire_local_point(const struct luminaire_instance *instance, vec3 p) {
    const float(*m)[4] = instance->to_world.inverse;
    return vec3_add(rotate_scaled(m, p, 1), (vec3){m[0][3], m[1][3], m[2][3]});
}

bool crossing_find(const struct luminaire_instance *instance, const struct ray *ray, float *t_mid) {
    vec3 o = luminaire_local_point(instance, ray->origin), d = luminaire_local_direction(instance, ray->direction);
    float t_near, t_far;
    if (!luminaire_span(instance->luminaire, (float[3]){o.x, o.y, o.z}, (float[3]){d.x, d.y, d.z}, &t_near, &t_far))
        return false;
    *t_mid = 0.5f * (t_near + t_far) * instance->scale;
    return *t_mid > ray->t_min;
}

struct crossing *crossing_add(struct crossing_batch *batch, uint32_t item, uint32_t luminaire, const struct ray *ray,
                              float t_mid) {
    struct crossing *crossing = &batch->crossings[batch->count++];
    *crossing = (struct crossing){.item = item,
                                  .luminaire = luminaire,
                                  .t_mid = t_mid,
                                  .viewpoint = ray->origin,
                                  .direction = ray->direction,
                                  .transmittance = {1, 1, 1}};
    return crossing;
}

enum question { QUESTION_RADIANCE, QUESTION_TRANSMITTANCE, QUESTION_PDF };

static bool crossing_wants(const struct crossing *crossing, enum question question) {
    return question == QUESTION_RADIANCE        ? crossing->wants_radiance
           : question == QUESTION_TRANSMITTANCE ? crossing->wants_transmittance
                                                : crossing->wants_pdf;
}

static rgb mask_transmittance(enum lamp_mask mask, rgb transmittance) {
    if (mask == LAMP_MASK_RGB) return transmittance;
    bool through = mask == LAMP_MASK_BINARY && transmittance.r + transmittance.g + transmittance.b >= 1.5f;
    return rgb_gray(through ? 1 : 0);
}

// Whether a crossing that nobody has found misses the proxy after all.
static bool misses(const struct crossing *crossing, const struct luminaire_instance *instance, const float point[3],
                   const float w[3]) {
    float t_near, t_far;
    return crossing->t_mid == 0 && !luminaire_span(instance->luminaire, point, w, &t_near, &t_far);
}

// One query for the crossings order[0..n) of one lamp.
static void ask(struct crossing_batch *batch, const struct luminaire_instance *instance, const uint32_t *order,
                size_t n, enum question question) {
    size_t asked = 0;
    for (size_t i = 0; i < n; i++) {
        const struct crossing *crossing = &batch->crossings[order[i]];
        if (!crossing_wants(crossing, question)) continue;
        vec3 d = luminaire_local_direction(instance, crossing->direction);
        vec3_store(batch->point[asked], luminaire_local_point(instance, crossing->viewpoint));
        vec3_store(batch->w[asked], question == QUESTION_PDF ? d : vec3_neg(d));
        asked++;
    }
    if (!asked) return;
    const float(*point)[3] = (const float(*)[3])batch->point, (*w)[3] = (const float(*)[3])batch->w;
    switch (question) {
    case QUESTION_RADIANCE:
        luminaire_eval_met(instance->luminaire, asked, point, w, batch->answer);
        break;
    case QUESTION_TRANSMITTANCE:
        luminaire_transmittance_met(instance->luminaire, asked, point, w, batch->answer);
        break;
    case QUESTION_PDF:
        luminaire_pdf(instance->luminaire, asked, point, w, batch->pdf);
        break;
    }
    asked = 0;
    for (size_t i = 0; i < n; i++) {
        struct crossing *crossing = &batch->crossings[order[i]];
        if (!crossing_wants(crossing, question)) continue;
        rgb answer = {batch->answer[asked][0], batch->answer[asked][1], batch->answer[asked][2]};
        if (question != QUESTION_PDF && misses(crossing, instance, point[asked], w[asked]))
            answer = rgb_gray(question == QUESTION_RADIANCE ? 0 : 1);
        if (question == QUESTION_RADIANCE) crossing->radiance = rgb_mul(answer, instance->dim);
        if (question == QUESTION_RADIANCE && crossing->looks && !rgb_is_black(answer) &&
            !luminaire_seen(instance->luminaire, point[asked], w[asked]))
            crossing->radiance = rgb_gray(0);
        if (question == QUESTION_TRANSMITTANCE) crossing->transmittance = mask_transmittance(instance->mask, answer);
        if (question == QUESTION_PDF) crossing->pdf_sa = batch->pdf[asked];
        asked++;
    }
}

void crossing_batch_answer(struct crossing_batch *batch, const struct scene *scene) {
    size_t lamps = batch->luminaire_count;
    for (size_t l = 0; l <= lamps; l++) batch->starts[l] = 0;
    for (size_t i = 0; i < batch->count; i++) batch->starts[batch->crossings[i].luminaire]++;
    for (size_t l = 0, sum = 0; l <= lamps; l++) {
        sum += batch->starts[l];
        batch->starts[l] = (uint32_t)sum; // the end of lamp l, moved to its start by the placing below
    }
    for (size_t i = batch->count; i-- > 0;) batch->order[--batch->starts[batch->crossings[i].luminaire]] = (uint32_t)i;
    for (size_t l = 0; l < lamps; l++) {
        size_t n = batch->starts[l + 1] - batch->starts[l];
        for (int question = QUESTION_RADIANCE; n && question <= QUESTION_PDF; question++)
            ask(batch, &scene->luminaires[l], batch->order + batch->starts[l], n, (enum question)question);
    }
}

bool scene_has_hidden_geometry(const struct scene *scene) {
    for (size_t i = 0; i < scene->luminaire_count; i++)
        if (scene->luminaires[i].appearance == APPEARANCE_GEOMETRY && scene->luminaires[i].keep != KEEP_ALL)
            return true;
    return false;
}

bool lamp_view_hides(const struct scene *scene, const struct lamp_view *view, const struct shape *shape) {
    int i = shape->luminaire;
    if (i < 0) return false;
    if (i == view->ignore) return true;
    const struct luminaire_instance *instance = &scene->luminaires[i];
    if (instance->appearance != APPEARANCE_GEOMETRY || view->look || view->live == i) return false;
    bool clear = shape->emitter || (shape->bsdf->flags & BSDF_TRANSMISSION);
    return instance->keep == KEEP_NONE || (instance->keep == KEEP_OPAQUE && clear);
}

bool lamp_view_intersect(const struct scene *scene, bool hidden, const struct lamp_view *view, const struct ray *ray,
                         struct surface *surface) {
    if (!hidden) return scene_intersect(scene, ray, view->ignore, surface);
    struct ray rest = *ray;
    float travelled = 0;
    while (scene_intersect(scene, &rest, view->ignore, surface)) {
        travelled += surface->t;
        if (!lamp_view_hides(scene, view, surface->shape)) {
            surface->t = travelled;
            return true;
        }
        rest = surface_spawn_ray(surface, ray->direction);
        rest.t_max = ray->t_max - travelled;
    }
    return false;
}

rgb lamp_view_visibility(const struct scene *scene, bool hidden, const struct lamp_view *view, const struct ray *ray) {
    if (!hidden) return scene_visibility(scene, ray, view->ignore);
    rgb visibility = rgb_gray(1);
    struct ray rest = *ray;
    struct surface surface;
    while (lamp_view_intersect(scene, hidden, view, &rest, &surface)) {
        if (!(surface_bsdf_flags(&surface) & BSDF_NULL)) return rgb_gray(0);
        visibility = rgb_mul(visibility, surface_through(&surface, vec3_neg(ray->direction)));
        if (rgb_is_black(visibility)) return visibility;
        float t_max = rest.t_max - surface.t;
        rest = surface_spawn_ray(&surface, ray->direction);
        rest.t_max = t_max;
    }
    return visibility;
}
