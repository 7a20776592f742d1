// Training of grids + MLP with Adam (Kingma and Ba 2015). Table entries are updated only in the steps that touch them.
// The result is the same, bit for bit, for any number of threads: the batch is cut into fixed slices, the MLP's
// gradients are added in slice order, and each level's gradients are scattered by one owner in sample order.
#pragma once

#include "base/error.h"
#include "net/grid.h"
#include "net/mlp.h"

struct trainer_rates {
    float table, mlp; // learning rates; constant for the first half of `steps`, then falling exponentially
    float end; // to this factor at `steps` and after
    size_t steps;
};

// What a batch is made of; called for blocks of NET_LANES samples [first, first + count), from several threads.
struct trainer_batch {
    size_t n;
    const void *user;
    void (*encode)(const void *user, size_t first, int count,
                   struct grid_input *input); // lanes >= count: anything finite
    // z, d_z [outputs][NET_LANES]; lanes >= count of d_z must be 0. Returns the sum of the losses.
    double (*loss)(const void *user, size_t first, int count, const float *z, float *d_z);
};

struct trainer {
    struct grid_layout layout;
    struct mlp_shape shape;
    struct trainer_rates rates;
    uint64_t step; // steps done
    size_t mlp_count; // parameters of the MLP
    float *table; // [entry_count][2]
    float *moments; // [entry_count][4]: first moments of the two features, then the second
    float *mlp, *mlp_moments; // [mlp_count], [2][mlp_count]
    struct trainer_scratch *scratch;
};

enum status trainer_init(struct trainer *trainer, const struct grid_layout *layout, int width, int outputs,
                         const struct trainer_rates *rates, uint64_t seed, struct error *error);
void trainer_fini(struct trainer *trainer);
double trainer_step(struct trainer *trainer, const struct trainer_batch *batch, int threads); // sum of the losses
