// A lamp beside its baked file, as figures that look at single lamps need it.
#pragma once

#include "bake/gather.h"
#include "evidence/figure.h"
#include "trace/emission_cluster.h"

struct studied_lamp {
    struct scene scene, hull; // the geometry; the file's hull, where has_hull
    bool has_hull;
    struct luminaire *luminaire;
    struct lamp lamp;
    struct aim aims[EMISSION_CLUSTERS];
};

// The struct must not move: lamp.aims points into it.
enum status studied_lamp_open(struct studied_lamp *studied, const struct figure_kit *kit, const char *name,
                              struct error *error);
void studied_lamp_close(struct studied_lamp *studied);
