// What a plugin's commit function may use.
#pragma once

#include "base/arena.h"
#include "base/error.h"
#include "base/run.h"
#include "format/description.h"

struct commit_context {
    struct arena *arena; // everything the plugin allocates lives here, as long as the scene
    const struct run *run; // warnings
    const struct object
        *object; // the description, for its place and the folder of relative file names (object->place.file)
    bool skip_missing; // a missing mesh is a warning, the shape is left out
};
