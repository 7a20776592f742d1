// Scalar reference. Shapes: y[o] = b[o] + sum_i w[o][i] x[i], o < n_out, i < n_in.
#include "net/mlp.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "math/sampler.h"

struct mlp_offsets mlp_layout(const struct mlp_shape *shape) {
    size_t n = (size_t)shape->inputs, h = (size_t)shape->width, o = (size_t)shape->outputs;
    struct mlp_offsets at = {.w1 = 0};
    at.b1 = at.w1 + h * n;
    at.w2 = at.b1 + h;
    at.b2 = at.w2 + h * h;
    at.w3 = at.b2 + h;
    at.b3 = at.w3 + o * h;
    at.count = at.b3 + o;
    return at;
}

static void fill_uniform(float *w, size_t count, float bound, struct sampler *sampler) {
    for (size_t i = 0; i < count; i++) w[i] = bound * (2 * sampler_1d(sampler) - 1);
}

void mlp_init(const struct mlp_shape *shape, float *parameters, uint64_t seed) {
    struct mlp_offsets at = mlp_layout(shape);
    struct sampler sampler = sampler_make(seed, 0x6d6c70, 0);
    for (size_t i = 0; i < at.count; i++) parameters[i] = 0;
    fill_uniform(parameters + at.w1, at.b1 - at.w1, sqrtf(6.0f / (float)shape->inputs), &sampler);
    fill_uniform(parameters + at.w2, at.b2 - at.w2, sqrtf(6.0f / (float)shape->width), &sampler);
    fill_uniform(parameters + at.w3, at.b3 - at.w3, sqrtf(1.0f / (float)shape->width), &sampler);
}

static void transpose(int n_in, int n_out, const float *w, float *by_input) {
    for (int o = 0; o < n_out; o++)
        for (int i = 0; i < n_in; i++) by_input[i * n_out + o] = w[o * n_in + i];
}

void mlp_transpose(const struct mlp_shape *shape, const float *parameters, float *by_input) {
    struct mlp_offsets at = mlp_layout(shape);
    memcpy(by_input, parameters, at.count * sizeof(float));
    transpose(shape->inputs, shape->width, parameters + at.w1, by_input + at.w1);
    transpose(shape->width, shape->width, parameters + at.w2, by_input + at.w2);
    transpose(shape->width, shape->outputs, parameters + at.w3, by_input + at.w3);
}

static void dense_forward(int n_in, int n_out, const float *w, const float *b, const float *x, bool relu, float *y) {
    for (int o = 0; o < n_out; o++) {
        float sum = b[o];
        for (int i = 0; i < n_in; i++) sum += w[o * n_in + i] * x[i];
        y[o] = relu && sum < 0 ? 0 : sum;
    }
}

static void dense_backward(int n_in, int n_out, const float *w, const float *x, const float *d_y, float *d_x,
                           float *d_w, float *d_b) {
    for (int i = 0; i < n_in; i++) d_x[i] = 0;
    for (int o = 0; o < n_out; o++) {
        d_b[o] += d_y[o];
        for (int i = 0; i < n_in; i++) {
            d_x[i] += w[o * n_in + i] * d_y[o];
            d_w[o * n_in + i] += x[i] * d_y[o];
        }
    }
}

void mlp_forward(const struct mlp_shape *shape, const float *parameters, const float *x, float *h1, float *h2,
                 float *z) {
    struct mlp_offsets at = mlp_layout(shape);
    dense_forward(shape->inputs, shape->width, parameters + at.w1, parameters + at.b1, x, true, h1);
    dense_forward(shape->width, shape->width, parameters + at.w2, parameters + at.b2, h1, true, h2);
    dense_forward(shape->width, shape->outputs, parameters + at.w3, parameters + at.b3, h2, false, z);
}

void mlp_backward(const struct mlp_shape *shape, const float *parameters, const float *x, const float *h1,
                  const float *h2, const float *d_z, float *d_x, float *d_parameters) {
    struct mlp_offsets at = mlp_layout(shape);
    float d_h2[MLP_MAX_WIDTH], d_h1[MLP_MAX_WIDTH];
    dense_backward(shape->width, shape->outputs, parameters + at.w3, h2, d_z, d_h2, d_parameters + at.w3,
                   d_parameters + at.b3);
    for (int i = 0; i < shape->width; i++) d_h2[i] = h2[i] > 0 ? d_h2[i] : 0;
    dense_backward(shape->width, shape->width, parameters + at.w2, h1, d_h2, d_h1, d_parameters + at.w2,
                   d_parameters + at.b2);
    for (int i = 0; i < shape->width; i++) d_h1[i] = h1[i] > 0 ? d_h1[i] : 0;
    dense_backward(shape->inputs, shape->width, parameters + at.w1, x, d_h1, d_x, d_parameters + at.w1,
                   d_parameters + at.b1);
}
