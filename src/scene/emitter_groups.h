// The emitters of a lamp in groups, which are baked and dimmed separately. Mitsuba refuses properties that it does not
// know, so an emitter's id names its group.
#pragma once

#include "luminaire/luminaire.h"
#include "scene/scene.h"

enum emitter_grouping {
    GROUP_NAMED, // by what stands before the first '.' of the id (Blender numbers copies so); "rest" without an id
    GROUP_EACH, // every emitter is a group: its id, or "emitter_1" and so on by its place in the lamp
};

struct emitter_groups {
    size_t count;
    const char **names; // [count]
    size_t *of_emitter; // [emitters] group of each
};

// Of emitters[0 .. n); everything is in the arena. Errors: an id that cannot name a group.
enum status emitter_groups_find(struct emitter_groups *groups, struct emitter *const *emitters, size_t n,
                                enum emitter_grouping grouping, struct arena *arena, struct error *error);
