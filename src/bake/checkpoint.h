// What an interrupted bake needs to go on: a folder OUTPUT.checkpoint with state.json and the state of both networks.
// The networks are written under the slot that state.json does not name, then state.json is replaced: whatever moment
// the program is killed at, state.json names two whole files.
#pragma once

#include "bake/training.h"

struct checkpoint {
    char identity[80]; // of the lamp's geometry and the options: another bake's checkpoint is refused
    int slot;
    struct light_recipe recipe;
    size_t transparency_chunks, light_chunks; // done
    size_t traced;
    double seconds; // wall time used so far
};

// `transparency` may be NULL: another checkpoint has it.
// STATUS_OK with *found = false where there is none. STATUS_INVALID: of another bake, or damaged.
enum status checkpoint_load(struct checkpoint *checkpoint, bool *found, const char *folder, const char *identity,
                            struct error *error);
enum status checkpoint_load_networks(const struct checkpoint *checkpoint, const char *folder, struct light_field *field,
                                     struct transparency *transparency, struct error *error);
// Flips checkpoint->slot.
enum status checkpoint_save(struct checkpoint *checkpoint, const char *folder, const struct light_field *field,
                            const struct transparency *transparency, struct error *error);
void checkpoint_remove(const char *folder);
