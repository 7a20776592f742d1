#include "scene/emitter_groups.h"

#include <stdio.h>
#include <string.h>

#include "luminaire/group_setting.h"

static const char *group_name(const struct emitter *emitter, size_t index, enum emitter_grouping grouping,
                              struct arena *arena) {
    if (!emitter->id[0]) return grouping == GROUP_NAMED ? "rest" : arena_printf(arena, "emitter_%zu", index + 1);
    if (grouping == GROUP_EACH) return emitter->id;
    return arena_printf(arena, "%.*s", (int)strcspn(emitter->id, "."), emitter->id);
}

enum status emitter_groups_find(struct emitter_groups *groups, struct emitter *const *emitters, size_t n,
                                enum emitter_grouping grouping, struct arena *arena, struct error *error) {
    *groups = (struct emitter_groups){.names = arena_alloc(arena, n + 1, sizeof *groups->names),
                                      .of_emitter = arena_alloc(arena, n + 1, sizeof *groups->of_emitter)};
    if (!groups->names || !groups->of_emitter)
        return error_set(error, STATUS_MEMORY, "out of memory for the groups of %zu emitters", n);
    for (size_t i = 0; i < n; i++) {
        const char *name = group_name(emitters[i], i, grouping, arena);
        if (!name) return error_set(error, STATUS_MEMORY, "out of memory for the groups of %zu emitters", n);
        enum status status = group_name_check(name, error);
        if (status) return status;
        size_t g = 0;
        while (g < groups->count && strcmp(groups->names[g], name)) g++;
        groups->of_emitter[i] = g;
        if (g == groups->count) groups->names[groups->count++] = name;
    }
    return STATUS_OK;
}
