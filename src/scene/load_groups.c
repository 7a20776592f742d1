// The `groups` of a <shape type="luminaire">: as factors of a baked lamp's groups, or of the emitters of geometry.
#include <stdio.h>
#include <string.h>

#include "luminaire/group_setting.h"
#include "scene/emitter_groups.h"
#include "scene/load_private.h"

static const struct place *groups_place(const struct object *object) {
    for (size_t i = 0; i < object->property_count; i++)
        if (param_name_equal(object->properties[i].name, "groups")) return &object->properties[i].place;
    return &object->place;
}

// What `emitter` sends out, before the glass of the lamp.
static rgb emitter_flux(struct emitter *emitter) {
    rgb power = emitter->power;
    struct error unused;
    emitter->type->ready(emitter, NULL, &unused); // of an area emitter: from radiance and area alone
    rgb flux = emitter->power;
    emitter->power = power;
    return flux;
}

static enum status apply_to_emitters(struct loader *loader, const char *text, enum emitter_grouping grouping,
                                     size_t first, struct error *error) {
    struct scene *scene = loader->scene;
    struct emitter_groups groups;
    enum status status = emitter_groups_find(&groups, scene->emitters + first, scene->emitter_count - first, grouping,
                                             &scene->arena, error);
    if (status) return status;
    struct group_light *lights = load_alloc(loader, (groups.count + 1) * sizeof *lights);
    if (!lights) return STATUS_MEMORY;
    for (size_t g = 0; g < groups.count; g++)
        lights[g] = (struct group_light){.name = groups.names[g], .factor = {1, 1, 1}};
    for (size_t i = first; i < scene->emitter_count; i++) {
        rgb flux = emitter_flux(scene->emitters[i]);
        struct group_light *light = &lights[groups.of_emitter[i - first]];
        light->flux[0] += flux.r, light->flux[1] += flux.g, light->flux[2] += flux.b;
    }
    status = group_settings_apply(text, lights, groups.count, error);
    for (size_t i = first; i < scene->emitter_count && !status; i++) {
        const float *factor = lights[groups.of_emitter[i - first]].factor;
        scene->emitters[i]->factor = rgb_mul(scene->emitters[i]->factor, (rgb){factor[0], factor[1], factor[2]});
    }
    return status;
}

enum status load_groups_geometry(struct loader *loader, const struct object *object, const char *text, size_t first) {
    struct error named = {0}, each = {0};
    enum status status = apply_to_emitters(loader, text, GROUP_NAMED, first, &named);
    if (status == STATUS_INVALID && !apply_to_emitters(loader, text, GROUP_EACH, first, &each)) return STATUS_OK;
    return status ? error_at(loader->error, *groups_place(object), "%s", named.text) : STATUS_OK;
}

enum status load_groups_baked(struct loader *loader, const struct object *object, const char *text,
                              const struct luminaire *luminaire, float scale, struct luminaire **dimmed,
                              float factors[LUMINAIRE_MAX_GROUPS][3]) {
    struct error inner = {0};
    enum status status = luminaire_group_factors(luminaire, text, scale, factors, &inner);
    if (status) return error_at(loader->error, *groups_place(object), "%s", inner.text);
    return luminaire_dim(dimmed, luminaire, (const float(*)[3])factors, loader->error);
}

static size_t find_group(const struct luminaire *luminaire, const char *name) {
    size_t g = 0, count = luminaire_group_count(luminaire);
    while (g < count && strcmp(luminaire_group(luminaire, g, NULL), name)) g++;
    return g;
}

enum status load_groups_kept(struct loader *loader, const struct object *object, const struct luminaire *luminaire,
                             const float (*factors)[3], size_t first) {
    struct scene *scene = loader->scene;
    const size_t count = luminaire_group_count(luminaire), n = scene->emitter_count - first;
    struct emitter_groups named, each;
    enum status status =
        emitter_groups_find(&named, scene->emitters + first, n, GROUP_NAMED, &scene->arena, loader->error);
    if (!status)
        status = emitter_groups_find(&each, scene->emitters + first, n, GROUP_EACH, &scene->arena, loader->error);
    for (size_t i = 0; i < n && !status; i++) {
        struct emitter *emitter = scene->emitters[first + i];
        size_t g = 0;
        if (count) { // a full id first: it is a name before its first '.' only where the two are the same
            g = find_group(luminaire, each.names[each.of_emitter[i]]);
            if (g == count) g = find_group(luminaire, named.names[named.of_emitter[i]]);
            if (g == count)
                return error_at(loader->error, object->place,
                                "the geometry's emitter '%s' is in no group of the baked lamp; bake it again",
                                each.names[each.of_emitter[i]]);
        }
        emitter->factor = rgb_mul(emitter->factor, (rgb){factors[g][0], factors[g][1], factors[g][2]});
    }
    return status;
}
