// Scalar reference. Shapes: x[l] has n_in of layer l, x[l + 1] its n_out.
#include "net/dense_net.h"

#include <math.h>
#include <string.h>

#include "math/sampler.h"

int dense_layer_count(const struct dense_shape *shape) { return shape->hidden + 2; }

struct dense_layer dense_layer_at(const struct dense_shape *shape, int layer) {
    const size_t inputs = (size_t)shape->inputs, width = (size_t)shape->width, last = (size_t)shape->hidden + 1;
    const size_t l = (size_t)layer, entry = (inputs + 1) * width, hidden = (width + 1) * width;
    struct dense_layer at = {.n_in = l == 0 ? inputs : width,
                             .n_out = l == last ? (size_t)shape->outputs : width,
                             .w = l == 0 ? 0 : entry + (l - 1) * hidden,
                             .relu = l != last,
                             .skip = l >= 2 && l < last && (last - l) % 2 == 1};
    at.b = at.w + at.n_in * at.n_out;
    return at;
}

size_t dense_parameters(const struct dense_shape *shape) {
    struct dense_layer exit = dense_layer_at(shape, shape->hidden + 1);
    return exit.b + exit.n_out;
}

void dense_init(const struct dense_shape *shape, float *parameters, uint64_t seed) {
    struct sampler sampler = sampler_make(seed, 0x64656e73, 0);
    memset(parameters, 0, dense_parameters(shape) * sizeof(float));
    for (int l = 0; l < dense_layer_count(shape); l++) {
        struct dense_layer at = dense_layer_at(shape, l);
        float bound = sqrtf((at.relu ? 6.0f : 1.0f) / (float)at.n_in) * (at.skip ? 0.1f : 1.0f);
        for (size_t i = at.w; i < at.b; i++) parameters[i] = bound * (2 * sampler_1d(&sampler) - 1);
    }
}

size_t dense_activations(const struct dense_shape *shape) {
    return (size_t)shape->inputs + (size_t)shape->width * (size_t)(shape->hidden + 1) + (size_t)shape->outputs;
}

// Where x[l] begins.
static size_t activation_at(const struct dense_shape *shape, int l) {
    return l == 0 ? 0 : (size_t)shape->inputs + (size_t)shape->width * (size_t)(l - 1);
}

void dense_forward(const struct dense_shape *shape, const float *parameters, float *x) {
    for (int l = 0; l < dense_layer_count(shape); l++) {
        struct dense_layer at = dense_layer_at(shape, l);
        const float *in = x + activation_at(shape, l), *w = parameters + at.w;
        float *out = x + activation_at(shape, l + 1);
        for (size_t o = 0; o < at.n_out; o++, w += at.n_in) {
            float sum = parameters[at.b + o];
            for (size_t i = 0; i < at.n_in; i++) sum += w[i] * in[i];
            if (at.skip) sum += x[activation_at(shape, l - 1) + o];
            out[o] = at.relu && sum < 0 ? 0 : sum;
        }
    }
}

void dense_backward(const struct dense_shape *shape, const float *parameters, const float *x, float *d_x,
                    float *d_parameters) {
    memset(d_x, 0, (dense_activations(shape) - (size_t)shape->outputs) * sizeof(float));
    for (int l = dense_layer_count(shape) - 1; l >= 0; l--) {
        struct dense_layer at = dense_layer_at(shape, l);
        const size_t in = activation_at(shape, l), out = activation_at(shape, l + 1);
        for (size_t o = 0; o < at.n_out; o++) {
            if (at.relu && !(x[out + o] > 0)) d_x[out + o] = 0;
            const float d = d_x[out + o];
            d_parameters[at.b + o] += d;
            if (at.skip) d_x[activation_at(shape, l - 1) + o] += d;
            for (size_t i = 0; i < at.n_in; i++) {
                d_x[in + i] += parameters[at.w + o * at.n_in + i] * d;
                d_parameters[at.w + o * at.n_in + i] += d * x[in + i];
            }
        }
    }
}
