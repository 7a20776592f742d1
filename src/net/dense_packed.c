#include "net/dense_packed.h"

#include <stdlib.h>
#include <string.h>

#include "net/kernel.h"

enum status dense_packed_init(struct dense_packed *packed, const struct dense_shape *shape, struct error *error) {
    *packed = (struct dense_packed){.shape = *shape};
    const int tile = kernel_best()->gemm_tile;
    size_t biases = 0;
    bool complete = true;
    for (int l = 0; l < dense_layer_count(shape); l++) {
        struct dense_layer at = dense_layer_at(shape, l);
        biases += at.n_out;
        packed->weights[l] = malloc(gemm_packed_count(tile, at.n_out, at.n_in) * sizeof(float));
        complete = complete && packed->weights[l];
    }
    packed->biases = malloc(biases * sizeof(float));
    if (complete && packed->biases) return STATUS_OK;
    dense_packed_fini(packed);
    return error_set(error, STATUS_MEMORY, "out of memory for a network");
}

void dense_packed_fini(struct dense_packed *packed) {
    for (int l = 0; l < DENSE_MAX_LAYERS; l++) free(packed->weights[l]);
    free(packed->biases);
    *packed = (struct dense_packed){.biases = NULL};
}

void dense_packed_set(struct dense_packed *packed, const float *parameters) {
    const int tile = kernel_best()->gemm_tile;
    float *biases = packed->biases;
    for (int l = 0; l < dense_layer_count(&packed->shape); l++) {
        struct dense_layer at = dense_layer_at(&packed->shape, l);
        gemm_pack(tile, at.n_out, at.n_in, parameters + at.w, at.n_in, 1, packed->weights[l]);
        memcpy(biases, parameters + at.b, at.n_out * sizeof(float));
        biases += at.n_out;
    }
}

void dense_packed_forward(const struct dense_packed *packed, int count, const float *x, float *z) {
    _Alignas(64) float hidden[2][DENSE_MAX_WIDTH * DENSE_SLICE]; // x[l + 1] takes the place of x[l - 1]
    const struct kernel *kernel = kernel_best();
    const float *bias = packed->biases, *in = x;
    const size_t columns = ((size_t)count + NET_LANES - 1) / NET_LANES * NET_LANES;
    for (int l = 0; l < dense_layer_count(&packed->shape); l++) {
        struct dense_layer at = dense_layer_at(&packed->shape, l);
        float *out = at.relu ? hidden[l & 1] : z;
        kernel->gemm(&(struct gemm){.rows = at.n_out,
                                    .depth = at.n_in,
                                    .columns = columns,
                                    .a = packed->weights[l],
                                    .b = in,
                                    .b_stride = DENSE_SLICE,
                                    .bias = bias,
                                    .add = at.skip ? out : NULL,
                                    .relu = at.relu,
                                    .c = out,
                                    .c_stride = DENSE_SLICE});
        bias += at.n_out;
        in = out;
    }
}
