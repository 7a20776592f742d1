// The verb `figures`: the paper's figures and the ablations, each kept as PNG and JSON files, and the page of them all.
#pragma once

#include "base/error.h"
#include "base/run.h"

struct figures_options {
    const char *folder; // of the results; made where it is not there
    double scale; // of times and pixels, > 0
    const char *only; // names with commas between them; NULL: all but the ablations
    const char *paper; // see figure_kit
    const char *data; // see evidence_data_find
};

// *json (malloc'ed): what the figures' own JSON files hold, and the page's path. Figures that are kept and made from
// the same files and options are not made again. STATUS_CANCELLED: the page holds what is finished.
enum status figures_make(const struct figures_options *options, const struct run *run, char **json,
                         struct error *error);
