// One row of the table: what stands in it, and how it is measured.
#pragma once

#include <stddef.h>

#include "base/run.h"
#include "evidence/evidence_data.h"

struct table1_entry { // what the row is about
    const char *name; // as --only takes it
    const char *luminaire, *scene; // as the table says
    const char *lamp, *room; // names of the files
    int width; // at scale 1, where the height is 400
    double paper_speedup;
};

enum { TABLE1_ROWS = 5 };
extern const struct table1_entry table1_entries[TABLE1_ROWS];

// Errors are relMSE outside the lamp, freed of the reference's noise; `whole`: of all pixels. NAN: there is no figure.
struct table1_row {
    const struct table1_entry *entry;
    double width, height;
    double speedup; // CPU seconds of bdpt over ours at bdpt's error; NAN: that error was not reached in fewer seconds
    double target, paper_speedup;
    double bdpt_spp, bdpt_cpu_s, bdpt_relmse, bdpt_relmse_whole, bdpt_flip;
    // With the samples that reach bdpt's error, or, where it is not reached, with those that leave as much noise as
    // bias.
    double ours_spp, ours_cpu_s, ours_relmse, ours_relmse_whole, ours_flip;
    // What bdpt takes to the error that ours has, by error ~ 1 / samples, and the speed-up at that error.
    double common_bdpt_spp, common_bdpt_cpu_s, common_speedup;
    double fixed_spp, fixed_cpu_s, fixed_relmse, fixed_flip, fixed_speedup; // ours with the paper's 128 samples
    double bias_spp, bias_cpu_s; // of ours, both renderings together, for these:
    double bias, bias_error; // what remains of ours without noise, and its standard error
    double bias_share; // of bdpt's error
    double unbiased_speedup; // the speed-up at equal error if there were no bias
    double noise_ratio; // of bdpt's noise to ours at equal samples
    double sample_cost_ratio; // of the CPU seconds of a sample
    double bdpt_relmse_fireflies; // with the worst thousandth of its pixels, which count nowhere else
    double bdpt_worst_share,
        ours_worst_share; // of the error that is in a thousandth of the pixels (ours: as the paper)
    double mean_error[3]; // of the picture's mean outside the lamp, relative and signed
    double flux_error[3]; // of the baked lamp, as its bake measured it
    double reference_spp, reference_cpu_s, reference_noise;
    double geometry_bytes, apl_bytes, file_bytes;
};

// What a row works with. The work of all rows together is `total` for the progress.
struct table1_kit {
    const struct run *run;
    struct evidence_data data;
    const char *folder;
    double scale, reference; // as table1_options
    double total, done, unmeasured; // of work; unmeasured: done by earlier calls
    double start_s;
};

double table1_work(const struct table1_kit *kit, const struct table1_entry *entry);
enum status table1_measure(struct table1_kit *kit, const struct table1_entry *entry, struct table1_row *row,
                           struct error *error);
// What keeps the row from its target, in words and figures. At most `size` bytes.
void table1_limits(const struct table1_row *row, char *text, size_t size);
enum { TABLE1_NAME = 40 };
void table1_equal_name(char name[TABLE1_NAME], double samples); // of the rendering of ours with ours_spp samples
// FOLDER/NAME/WHAT: where a row's renderings are.
void table1_path(char *path, const struct table1_kit *kit, const struct table1_entry *entry, const char *what);
