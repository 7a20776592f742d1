// The hull of a lamp and the view field on it.
#pragma once

#include "bake/hull_build.h"
#include "bake/training.h"
#include "luminaire/view_field.h"

struct view_plan {
    enum data_source data; // as the light field's
    size_t chunks; // optimiser steps / VIEW_STEPS
    double seconds; // > 0: as many chunks as fit in this wall time, at least one
    int log2_entries;
};

struct view_result { // both NULL where the lamp cannot have a hull
    struct hull *hull;
    struct view_field *field;
};

// Trains result->field on result->hull, which hull_build made together with `map`; drops the hull where nothing can be
// learned on it. Cancelled: STATUS_CANCELLED; nothing is kept, the stage begins anew when resumed.
enum status view_bake(struct view_result *result, const struct hull_map *map, const struct lamp *lamp,
                      const struct view_plan *plan, const struct run *run, struct error *error);
