// The small network behind the grids: inputs -> width -> width -> outputs, ReLU between, linear output.
// This file is the scalar reference; net/kernel.h has the batched kernels that are tested against it.
#pragma once

#include <stddef.h>
#include <stdint.h>

enum { MLP_MAX_INPUTS = 128, MLP_MAX_WIDTH = 64, MLP_MAX_OUTPUTS = 4 };

struct mlp_shape {
    int inputs; // a multiple of 4, <= MLP_MAX_INPUTS
    int width; // a multiple of 8, <= MLP_MAX_WIDTH
    int outputs; // <= MLP_MAX_OUTPUTS
};

// Parameters, row-major in this order: w1[width][inputs], b1[width], w2[width][width], b2[width], w3[outputs][width],
// b3[outputs].
struct mlp_offsets {
    size_t w1, b1, w2, b2, w3, b3, count;
};
struct mlp_offsets mlp_layout(const struct mlp_shape *shape);
void mlp_init(const struct mlp_shape *shape, float *parameters, uint64_t seed); // He et al. 2015; biases 0

// The parameters with every matrix by input: w1[inputs][width] and so on, in the same places.
void mlp_transpose(const struct mlp_shape *shape, const float *parameters, float *by_input);

// One sample. x[inputs], h1[width], h2[width] (after ReLU), z[outputs].
void mlp_forward(const struct mlp_shape *shape, const float *parameters, const float *x, float *h1, float *h2,
                 float *z);
// d_x[inputs] is written, d_parameters is added to.
void mlp_backward(const struct mlp_shape *shape, const float *parameters, const float *x, const float *h1,
                  const float *h2, const float *d_z, float *d_x, float *d_parameters);
