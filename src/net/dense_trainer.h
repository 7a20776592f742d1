// Training of a dense_net with Adam (Kingma and Ba 2015), at the rates of Zhu et al. 2021: 1e-4, moments 0.5 and 0.999.
// The result is the same, bit for bit, for any number of threads: every weight's gradient is one sum over the batch in
// order, made by one thread.
#pragma once

#include "net/dense_packed.h"

// What a batch is made of; called for slices of DENSE_SLICE samples [first, first + count), from several threads.
struct dense_batch {
    size_t n; // <= the trainer's most
    const void *user;
    void (*inputs)(const void *user, size_t first, int count, float *x); // [inputs][DENSE_SLICE], zeroed before
    // d_z [outputs][DENSE_SLICE], zeroed before: the gradient of the first `count` columns. Returns the sum of the
    // losses.
    double (*loss)(const void *user, size_t first, int count, const float *z, float *d_z);
};

struct dense_trainer {
    struct dense_shape shape;
    float *parameters, *moments; // [count], [2][count]
    uint64_t step; // steps done
    struct dense_packed packed; // of the parameters as they are
    struct dense_scratch *scratch;
};

enum status dense_trainer_init(struct dense_trainer *trainer, const struct dense_shape *shape, size_t most,
                               uint64_t seed, struct error *error);
void dense_trainer_fini(struct dense_trainer *trainer);
double dense_trainer_step(struct dense_trainer *trainer, const struct dense_batch *batch, int threads); // sum of losses
