// One pass of an integrator whose paths splat: a sample for every pixel of the crop, in blocks of pixels.
#pragma once

#include "base/error.h"
#include "base/run.h"
#include "trace/film.h"
#include "trace/splat.h"

enum { SPLAT_BLOCK = 1024, SPLAT_WAVE = 256 }; // pixels in a block, blocks traced before their splats are added

struct splat_pass {
    struct splat_list lists[SPLAT_WAVE];
    const struct sensor *sensor;
    int workers; // at most this many threads
    // Pixel (x, y) of the full film: returns what its own sample gives, and splats the rest.
    rgb (*trace)(void *user, int x, int y, uint64_t pass, const struct run *run, int worker, struct splat_list *splats);
    void *user;
    bool dropped_told;
};

enum status splat_pass_run(struct splat_pass *splat_pass, struct film *film, uint64_t pass, const struct run *run,
                           struct error *error);
void splat_pass_fini(struct splat_pass *splat_pass);
