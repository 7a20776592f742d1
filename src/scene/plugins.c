// One view over the tables of all plugins, and the tables of those objects that are read here and have no type of their
// own.
#include "scene/plugins.h"

#include <string.h>

#include "format/description.h"
#include "scene/bsdf.h"
#include "scene/emitter.h"
#include "scene/load_private.h"
#include "scene/sensor.h"
#include "scene/shape.h"
#include "scene/texture.h"

const char *const plugin_tags[] = {"shape", "bsdf",    "texture", "emitter", "sensor", "integrator",
                                   "film",  "sampler", "rfilter", "medium",  NULL};

// Objects whose types differ in name only, or that are read straight into the scene.
static const struct plugin_view fixed_plugins[] = {
    {"shape", "luminaire", "a lamp: its XML as geometry, or its baked file", luminaire_params, .common = NULL},
    {"shape", "shapegroup", "shapes that instances place; by itself it is nowhere", shapegroup_params, .common = NULL},
    {"shape", "instance", "the shapes of a shapegroup, placed", instance_params, .common = NULL},
    {"shape", "merge", "shapes side by side", merge_params, .common = NULL},
    {"integrator", "path", "path tracing with next-event estimation", integrator_params, .common = NULL},
    {"integrator", "bdpt", "bidirectional path tracing", integrator_params, .common = NULL},
    {"integrator", "particle", "particle tracing from the lights", integrator_params, .common = NULL},
    {"film", "hdrfilm", "size and crop of the image; other films are read alike", film_params, .common = NULL},
    {"sampler", "independent", "samples per pixel; other samplers are read alike", sampler_params, .common = NULL},
    {"rfilter", "gaussian", "truncated at four standard deviations", rfilter_params, .common = NULL},
    {"rfilter", "box", "one pixel wide", rfilter_params, .common = NULL},
    {"rfilter", "tent", "a triangle, two pixels wide", rfilter_params, .common = NULL},
    {"medium", "homogeneous", "absorption inside a shape, without scattering", medium_params, .common = NULL},
};

static bool fixed_plugin_at(const char *tag, size_t index, struct plugin_view *view) {
    for (size_t i = 0; i < sizeof fixed_plugins / sizeof *fixed_plugins; i++) {
        if (strcmp(fixed_plugins[i].tag, tag) || index--) continue;
        *view = fixed_plugins[i];
        return true;
    }
    return false;
}

#define VIEW_OF(table, common_params)                                                                                  \
    do {                                                                                                               \
        size_t count = 0;                                                                                              \
        while (table[count]) count++;                                                                                  \
        if (index < count)                                                                                             \
            *view = (struct plugin_view){tag, table[index]->name, table[index]->help, table[index]->params,            \
                                         .common = common_params};                                                     \
        found = index < count;                                                                                         \
        index -= found ? 0 : count;                                                                                    \
    } while (0)

bool plugin_at(const char *tag, size_t index, struct plugin_view *view) {
    bool found = false;
    if (!strcmp(tag, "bsdf")) {
        VIEW_OF(bsdf_table, NULL);
        if (found) {
            view->min_nested = bsdf_table[index]->min_children;
            view->max_nested = bsdf_table[index]->max_children;
        }
    } else if (!strcmp(tag, "texture"))
        VIEW_OF(texture_table, NULL);
    else if (!strcmp(tag, "emitter"))
        VIEW_OF(emitter_table, NULL);
    else if (!strcmp(tag, "sensor"))
        VIEW_OF(sensor_table, sensor_common_params);
    else if (!strcmp(tag, "shape")) {
        VIEW_OF(shape_table, shape_common_params);
        found = found || fixed_plugin_at(tag, index, view);
    } else
        found = fixed_plugin_at(tag, index, view);
    return found;
}

bool plugin_find(const char *tag, const char *name, struct plugin_view *view, size_t *index) {
    for (*index = 0; plugin_at(tag, *index, view); ++*index)
        if (param_name_equal(view->name, name)) return true;
    return false;
}

const char *plugin_nearest(const char *tag, const char *name) {
    const char *names[64];
    size_t n = 0;
    struct plugin_view view;
    while (n < 64 && plugin_at(tag, n, &view)) names[n++] = view.name;
    return nearest_name(name, names, n);
}
