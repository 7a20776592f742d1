// The wide networks of Zhu et al. 2021, "Neural Complex Luminaires": an entry layer, `hidden` layers of width x width,
// a linear exit layer. Layer l makes x[l + 1] from x[l], and x[0] is the input:
//   x[l + 1] = relu(w[l] x[l] + b[l] + (skip: x[l - 1])),   without the relu in the exit layer.
// Counted from the last, the hidden layers form residual blocks of two (He et al. 2016), the second of which has the
// skip; an odd one comes first. The publication gives the numbers of parameters, not the place of the skips.
// This file is the scalar reference; dense_packed.h has the fast form, dense_trainer.h the training.
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { DENSE_MAX_HIDDEN = 7, DENSE_MAX_LAYERS = DENSE_MAX_HIDDEN + 2, DENSE_MAX_WIDTH = 512, DENSE_MAX_OUTPUTS = 768 };

struct dense_shape {
    int inputs; // <= DENSE_MAX_WIDTH
    int width; // <= DENSE_MAX_WIDTH
    int hidden; // <= DENSE_MAX_HIDDEN
    int outputs; // <= DENSE_MAX_OUTPUTS
};

// Parameters, layer after layer: w[n_out][n_in] row-major, b[n_out].
struct dense_layer {
    size_t n_in, n_out;
    size_t w, b; // where in the parameters
    bool relu, skip;
};
int dense_layer_count(const struct dense_shape *shape);
struct dense_layer dense_layer_at(const struct dense_shape *shape, int layer);
size_t dense_parameters(const struct dense_shape *shape);
// He et al. 2015; the second layer of a residual block starts at a tenth of it, biases at 0.
void dense_init(const struct dense_shape *shape, float *parameters, uint64_t seed);

// One sample. x: x[0], x[1], ... of all layers one after the other, dense_activations numbers; x[0] is given.
size_t dense_activations(const struct dense_shape *shape);
void dense_forward(const struct dense_shape *shape, const float *parameters, float *x);
// d_x has room for as many; its last `outputs` are given, the rest is written. d_parameters is added to.
void dense_backward(const struct dense_shape *shape, const float *parameters, const float *x, float *d_x,
                    float *d_parameters);
