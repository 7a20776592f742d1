// One figure of the evidence: a name, what it shows, and the function that makes it. The table is in figures.c; a
// figure is one file (or one function) and one line there.
#pragma once

#include "base/run.h"
#include "evidence/evidence_data.h"
#include "evidence/sheet.h"

struct figure_kit;

struct figure {
    const char *name; // as --only takes it: "4", "ablation_size"
    const char *title, *caption;
    double cost; // CPU seconds at scale 1, roughly: for the progress
    // Puts pictures and tables on the sheet. What takes long goes through the kit, which keeps it.
    enum status (*make)(struct figure_kit *kit, const struct figure *figure, struct sheet *sheet, struct error *error);
    const void *data; // for `make`, where several figures share one
};

// What a figure works with.
struct figure_kit {
    struct run run; // for long calls: their progress becomes part of the whole's
    double scale; // 1: as in the documentation; times go with it, sides of pictures with its root
    const char *folder; // of the results
    struct evidence_data data;
    const char *paper; // a luminaire of preset paper of the demonstration lamp, or NULL
    struct figure_progress *progress;
};

// How many steps of about the same length the figure takes, and the beginning of the next one.
void figure_steps(struct figure_kit *kit, int steps);
void figure_step(struct figure_kit *kit, const char *what);

int figure_side(const struct figure_kit *kit, int pixels); // a picture's side at the kit's scale, at least 16
int figure_count(const struct figure_kit *kit, int count); // of samples and the like, at least 1

// The names of all lamps that have a baked file beside their geometry, by the alphabet; how many.
enum { FIGURE_LAMPS = 16, FIGURE_NAME = 64 };
int figure_lamps(const struct figure_kit *kit, char names[FIGURE_LAMPS][FIGURE_NAME]);
