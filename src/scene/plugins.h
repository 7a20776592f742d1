// All tables of plugins seen alike: for look-up by name, `sconce help` and the names in error messages.
#pragma once

#include <stdbool.h>
#include <stddef.h>

#include "base/param.h"

struct plugin_view {
    const char *tag, *name, *help;
    const struct param *params, *common; // common: what every plugin of the tag takes besides; or NULL
    int min_nested, max_nested; // bsdfs: how many stand inside
};

extern const char *const plugin_tags[]; // "bsdf", "shape", "emitter", "texture", "sensor", ...; ends with NULL
// Entry `index` of the tag's table, in the table's order; false behind the last. Shapes: the luminaire and groups come
// last.
bool plugin_at(const char *tag, size_t index, struct plugin_view *view);
bool plugin_find(const char *tag, const char *name, struct plugin_view *view, size_t *index);
// The nearest name among the tag's plugins, or NULL.
const char *plugin_nearest(const char *tag, const char *name);
