// A bake whose file and measures are kept on disk.
#pragma once

#include "bake/bake_job.h"
#include "evidence/figure.h"

struct bake_request {
    const char *name; // of the kept files: FOLDER/kept/NAME.safetensors, NAME.json
    const char *lamp;
    enum bake_size size;
    // Changes the work of a draft of this size; NULL: nothing.
    void (*change)(struct bake_plan *plan, double amount);
    double amount; // for `change`
};

enum bake_measure {
    BAKE_MEGABYTES,
    BAKE_STEPS, // thousands
    BAKE_TRACED, // millions of lines and particles
    BAKE_SECONDS, // of CPU time, measuring included
    BAKE_FLUX_KEPT, // mean over channels, before the final scale, of the lamp's
    BAKE_IRRADIANCE_NEAR, // error at 1.2 radii
    BAKE_IRRADIANCE_FAR, // at 10 radii
    BAKE_IRRADIANCE_NOISE, // of the measurement, at 1.2 radii
    BAKE_LIGHT_FIELD,
    BAKE_TRANSPARENCY,
    BAKE_VARIANCE, // of one light sample
    BAKE_MEASURES
};
extern const struct sheet_column bake_columns[BAKE_MEASURES + 1];

enum status kept_bake(struct figure_kit *kit, const struct bake_request *request, double values[BAKE_MEASURES],
                      struct error *error);
