// A dense_net with its weights in the order in which the processor's kernel reads them, and its batched forward.
// Activations of a slice of samples are [feature][DENSE_SLICE], 64-byte aligned: weights of a layer are read once for
// all samples of the slice, and the slice's activations stay in the second-level cache.
#pragma once

#include "base/error.h"
#include "net/dense_net.h"

enum { DENSE_SLICE = 64 };

struct dense_packed {
    struct dense_shape shape;
    float *weights[DENSE_MAX_LAYERS]; // gemm_pack of w
    float *biases; // of all layers, one after the other
};

enum status dense_packed_init(struct dense_packed *packed, const struct dense_shape *shape, struct error *error);
void dense_packed_fini(struct dense_packed *packed);
void dense_packed_set(struct dense_packed *packed, const float *parameters); // copies
// z [outputs][DENSE_SLICE] of the first `count` <= DENSE_SLICE columns of x [inputs][DENSE_SLICE]; what is in the other
// columns, and comes out of them, is of no account.
void dense_packed_forward(const struct dense_packed *packed, int count, const float *x, float *z);
