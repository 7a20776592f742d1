// Choice of a light in proportion to what it is estimated to send to the shading point: power / distance^2, bounded by
// the light's extent, mixed with a uniform share so that no light is ever left out (its estimate knows nothing of
// occlusion and orientation). Lists of more than `estimate_limit` lights use their power alone, which one search
// decides. The lights of the room are one list, the own emitters of each luminaire's kept geometry are one list each; a
// live vertex takes either list with probability 1/2.
#include "trace/light_select.h"

#include <stdlib.h>

#include "math/distribution.h"
#include "trace/luminaire_crossing.h"

enum { estimate_limit = 32, bounds_samples = 16 };
static const float uniform_share = 0.1f;

struct light {
    const struct emitter *emitter; // or NULL: luminaire
    uint32_t luminaire;
    bool infinite;
    float power; // luminance
    vec3 center;
    float extent2; // squared radius
};

struct light_list {
    struct light *lights;
    size_t count;
    struct distribution by_power; // of long lists
};

struct light_select {
    struct light_list *lists; // [0]: the room; [1 + i]: the own emitters of luminaire i
    size_t list_count;
    uint32_t *emitter_slots; // index of emitter e in its list
    uint32_t *luminaire_slots; // of luminaire i in the room's list
    float scene_area; // of the disk across the scene's bounding sphere
};

static size_t emitter_list(const struct emitter *emitter) {
    return emitter->shape && emitter->shape->luminaire >= 0 ? (size_t)emitter->shape->luminaire + 1 : 0;
}

// The extent of a light from points on it. A delta position is found from the sample towards the scene's centre.
static void light_bound(struct light *light, const struct emitter *emitter) {
    light->infinite = emitter->flags & EMITTER_INFINITE;
    light->power = maxf(rgb_luminance(emitter->power), 0);
    if (light->infinite) return;
    if (!emitter->shape) {
        struct light_sample sample;
        vec3 viewpoint = vec3_add(emitter->bounds.center, (vec3){0, 0, 2 * emitter->bounds.radius});
        bool known = emitter->type->sample_light(emitter, viewpoint, (vec2){0.5f, 0.5f}, &sample);
        light->center = known ? vec3_mad(sample.direction, sample.distance, viewpoint) : emitter->bounds.center;
        light->extent2 = known ? sqrf(1e-3f * emitter->bounds.radius) : sqrf(emitter->bounds.radius);
        return;
    }
    vec3 points[bounds_samples], sum = {0};
    for (int i = 0; i < bounds_samples; i++) {
        struct surface surface;
        vec2 u = {((float)i + 0.5f) / bounds_samples, fmodf(((float)i + 0.5f) * 0.61803399f, 1)};
        shape_sample(emitter->shape, u, &surface);
        points[i] = surface.p;
        sum = vec3_add(sum, surface.p);
    }
    light->center = vec3_scale(sum, 1.0f / bounds_samples);
    for (int i = 0; i < bounds_samples; i++) {
        vec3 offset = vec3_sub(points[i], light->center);
        light->extent2 = maxf(light->extent2, vec3_dot(offset, offset));
    }
}

static void light_bound_luminaire(struct light *light, const struct luminaire_instance *instance) {
    float center[3], radius;
    luminaire_bounds(instance->luminaire, center, &radius);
    light->power = maxf(rgb_luminance(luminaire_power(instance)), 0);
    light->center = transform_point(&instance->to_world, (vec3){center[0], center[1], center[2]});
    light->extent2 = sqrf(radius * instance->scale);
}

static enum status lists_fill(struct light_select *select, const struct scene *scene) {
    for (size_t e = 0; e < scene->emitter_count; e++) select->lists[emitter_list(scene->emitters[e])].count++;
    select->lists[0].count += scene->luminaire_count;
    for (size_t l = 0; l < select->list_count; l++) {
        struct light_list *list = &select->lists[l];
        list->lights = calloc(list->count + 1, sizeof *list->lights);
        if (!list->lights) return STATUS_MEMORY;
        list->count = 0;
    }
    for (size_t e = 0; e < scene->emitter_count; e++) {
        const struct emitter *emitter = scene->emitters[e];
        struct light_list *list = &select->lists[emitter_list(emitter)];
        list->lights[list->count].emitter = emitter;
        light_bound(&list->lights[list->count], emitter);
        select->emitter_slots[e] = (uint32_t)list->count++;
    }
    for (size_t i = 0; i < scene->luminaire_count; i++) {
        struct light *light = &select->lists[0].lights[select->lists[0].count];
        light->luminaire = (uint32_t)i;
        light_bound_luminaire(light, &scene->luminaires[i]);
        select->luminaire_slots[i] = (uint32_t)select->lists[0].count++;
    }
    return STATUS_OK;
}

static enum status list_distribute(struct light_list *list, struct error *error) {
    float *weights = malloc(list->count * sizeof *weights);
    if (!weights) return error_set(error, STATUS_MEMORY, "out of memory for the choice among %zu lights", list->count);
    for (size_t i = 0; i < list->count; i++) weights[i] = list->lights[i].power;
    enum status status = distribution_init(&list->by_power, weights, list->count, error);
    free(weights);
    return status;
}

enum status light_select_create(struct light_select **result, const struct scene *scene, struct error *error) {
    struct light_select *select = calloc(1, sizeof *select);
    *result = select;
    enum status status = STATUS_MEMORY;
    if (select) {
        select->list_count = scene->luminaire_count + 1;
        select->lists = calloc(select->list_count, sizeof *select->lists);
        select->emitter_slots = calloc(scene->emitter_count + 1, sizeof *select->emitter_slots);
        select->luminaire_slots = calloc(scene->luminaire_count + 1, sizeof *select->luminaire_slots);
        select->scene_area = PI_F * sqrf(scene->bounds.radius);
        if (select->lists && select->emitter_slots && select->luminaire_slots) status = lists_fill(select, scene);
    }
    if (status == STATUS_MEMORY) error_set(error, status, "out of memory for the lists of lights");
    for (size_t l = 0; status == STATUS_OK && l < select->list_count; l++)
        if (select->lists[l].count > estimate_limit) status = list_distribute(&select->lists[l], error);
    if (status == STATUS_OK) return status;
    light_select_destroy(select);
    *result = NULL;
    return status;
}

void light_select_destroy(struct light_select *select) {
    if (!select) return;
    for (size_t l = 0; select->lists && l < select->list_count; l++) {
        free(select->lists[l].lights);
        distribution_fini(&select->lists[l].by_power);
    }
    free(select->lists);
    free(select->emitter_slots);
    free(select->luminaire_slots);
    free(select);
}

// pmf of every light of a short list; returns how many can be chosen.
static size_t list_estimate(const struct light_select *select, const struct light_list *list,
                            const struct light_point *point, float *pmf) {
    float total = 0;
    size_t candidates = 0;
    for (size_t i = 0; i < list->count; i++) {
        const struct light *light = &list->lights[i];
        pmf[i] = -1;
        if (!light->emitter && (int)light->luminaire == point->kept) continue;
        vec3 offset = vec3_sub(light->center, point->p);
        pmf[i] = light->infinite
                     ? light->power / select->scene_area
                     : light->power / (4 * PI_F * maxf(maxf(vec3_dot(offset, offset), light->extent2), 1e-12f));
        total += pmf[i];
        candidates++;
    }
    if (!candidates) return 0;
    float uniform = 1.0f / (float)candidates, share = total > 0 && isfinite(total) ? uniform_share : 1;
    for (size_t i = 0; i < list->count; i++)
        pmf[i] = pmf[i] < 0 ? 0 : share * uniform + (share < 1 ? (1 - share) * pmf[i] / total : 0);
    return candidates;
}

static float list_pmf(const struct light_select *select, const struct light_list *list, const struct light_point *point,
                      size_t index) {
    if (list->count > estimate_limit)
        return uniform_share / (float)list->count + (1 - uniform_share) * distribution_pmf(&list->by_power, index);
    if (list->count == 1) return list->lights[0].emitter || (int)list->lights[0].luminaire != point->kept;
    float pmf[estimate_limit];
    return list_estimate(select, list, point, pmf) ? pmf[index] : 0;
}

static bool list_sample(const struct light_select *select, const struct light_list *list,
                        const struct light_point *point, float u, size_t *index, float *pmf) {
    if (!list->count) return false;
    if (list->count > estimate_limit) {
        if (u < uniform_share) {
            *index = (size_t)(u / uniform_share * (float)list->count);
            if (*index >= list->count) *index = list->count - 1;
        } else {
            *index = distribution_sample(&list->by_power,
                                         minf((u - uniform_share) / (1 - uniform_share), 0x1.fffffep-1f), NULL);
        }
        *pmf = list_pmf(select, list, point, *index);
        const struct light *light = &list->lights[*index];
        return light->emitter || (int)light->luminaire != point->kept;
    }
    if (list->count == 1) {
        *index = 0;
        *pmf = list_pmf(select, list, point, 0);
        return *pmf > 0;
    }
    float each[estimate_limit];
    if (!list_estimate(select, list, point, each)) return false;
    size_t last = 0;
    for (size_t i = 0; i < list->count; i++) {
        if (each[i] <= 0) continue;
        last = i;
        if (u < each[i]) break;
        u -= each[i];
    }
    *index = last;
    *pmf = each[last];
    return true;
}

static bool list_is_open(const struct light_select *select, const struct light_point *point, size_t list) {
    if (list > 0) return point->live >= 0 && list == (size_t)point->live + 1 && select->lists[list].count > 0;
    const struct light_list *room = &select->lists[0];
    bool only_kept = room->count == 1 && !room->lights[0].emitter && (int)room->lights[0].luminaire == point->kept;
    return room->count > 0 && !only_kept;
}

bool light_select_sample(const struct light_select *select, const struct light_point *point, float u,
                         struct light_choice *choice) {
    size_t own = point->live >= 0 ? (size_t)point->live + 1 : 0, l = 0;
    float share = 1;
    if (own && list_is_open(select, point, own)) {
        l = own;
        if (list_is_open(select, point, 0)) {
            share = 0.5f;
            l = u < 0.5f ? 0 : own;
            u = 2 * u - (u < 0.5f ? 0.0f : 1.0f);
        }
    }
    size_t index;
    if (!list_sample(select, &select->lists[l], point, u, &index, &choice->pmf)) return false;
    choice->emitter = select->lists[l].lights[index].emitter;
    choice->luminaire = select->lists[l].lights[index].luminaire;
    choice->pmf *= share;
    return choice->pmf > 0;
}

static float slot_pmf(const struct light_select *select, const struct light_point *point, size_t l, size_t index) {
    if (!list_is_open(select, point, l)) return 0;
    size_t other = l ? 0 : (size_t)(point->live + 1);
    float share = other != l && list_is_open(select, point, other) ? 0.5f : 1;
    return share * list_pmf(select, &select->lists[l], point, index);
}

float light_select_pmf_emitter(const struct light_select *select, const struct light_point *point,
                               const struct emitter *emitter) {
    return slot_pmf(select, point, emitter_list(emitter), select->emitter_slots[emitter->index]);
}

float light_select_pmf_luminaire(const struct light_select *select, const struct light_point *point,
                                 uint32_t luminaire) {
    if ((int)luminaire == point->kept) return 0;
    return slot_pmf(select, point, 0, select->luminaire_slots[luminaire]);
}
