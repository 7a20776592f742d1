// One step: slices in parallel (inputs, forward, loss, backward), each leaving what the weights' gradients are made of;
// then row groups of all layers in parallel (gradient = d_y x^T over the whole batch, Adam); then the weights are
// packed.
#include "net/dense_trainer.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"
#include "net/kernel.h"

enum { CHUNK_SLICES = 4, CHUNK = CHUNK_SLICES * DENSE_SLICE, GROUP_TILES = 8 }; // samples of one product d_y x^T
static const float rate = 1e-4f, beta1 = 0.5f, beta2 = 0.999f, epsilon = 1e-8f;

struct dense_scratch {
    size_t slices; // of the largest batch, whole chunks
    float *x[DENSE_MAX_LAYERS + 1]; // [slice][feature][DENSE_SLICE]: the layers' inputs, and z
    float *rows[DENSE_MAX_LAYERS]; // [sample][stride]: the layers' inputs again
    float *d_y[DENSE_MAX_LAYERS]; // [chunk], each gemm_pack of [n_out][CHUNK]: gradients before the relu
    float *gradient[DENSE_MAX_LAYERS]; // [n_out][stride]
    float *transposed[DENSE_MAX_LAYERS]; // gemm_pack of w^T
    double *loss; // [slice]
};

// An odd number of cache lines: at a power of two the rows of a product's panel would share a few sets of the cache.
static size_t row_stride(const struct dense_layer *at) {
    return ((at->n_in + NET_LANES - 1) / NET_LANES | 1) * NET_LANES;
}

static void *zeroed(size_t floats, bool *complete) {
    void *memory = NULL;
    if (posix_memalign(&memory, 64, floats * sizeof(float))) {
        *complete = false;
        return NULL;
    }
    return memset(memory, 0, floats * sizeof(float));
}

enum status dense_trainer_init(struct dense_trainer *trainer, const struct dense_shape *shape, size_t most,
                               uint64_t seed, struct error *error) {
    *trainer = (struct dense_trainer){.shape = *shape};
    const int tile = kernel_best()->gemm_tile, layers = dense_layer_count(shape);
    const size_t count = dense_parameters(shape), chunks = (most + CHUNK - 1) / CHUNK;
    bool complete = true;
    struct dense_scratch *s = trainer->scratch = calloc(1, sizeof *s);
    if (!s) return error_set(error, STATUS_MEMORY, "out of memory for the training of a network");
    s->slices = chunks * CHUNK_SLICES;
    trainer->parameters = zeroed(count, &complete);
    trainer->moments = zeroed(2 * count, &complete);
    s->loss = zeroed(2 * s->slices, &complete);
    for (int l = 0; l < layers; l++) {
        struct dense_layer at = dense_layer_at(shape, l);
        size_t stride = row_stride(&at);
        s->x[l] = zeroed(s->slices * at.n_in * DENSE_SLICE, &complete);
        s->rows[l] = zeroed(chunks * CHUNK * stride, &complete);
        s->d_y[l] = zeroed(chunks * gemm_packed_count(tile, at.n_out, CHUNK), &complete);
        s->gradient[l] = zeroed(at.n_out * stride, &complete);
        s->transposed[l] = zeroed(gemm_packed_count(tile, at.n_in, at.n_out), &complete);
    }
    s->x[layers] = zeroed(s->slices * (size_t)shape->outputs * DENSE_SLICE, &complete);
    enum status status = dense_packed_init(&trainer->packed, shape, error);
    if (status == STATUS_OK && !complete)
        status = error_set(error, STATUS_MEMORY, "out of memory for the training of a network");
    if (status != STATUS_OK) {
        dense_trainer_fini(trainer);
        return status;
    }
    dense_init(shape, trainer->parameters, seed);
    dense_packed_set(&trainer->packed, trainer->parameters);
    return STATUS_OK;
}

void dense_trainer_fini(struct dense_trainer *trainer) {
    struct dense_scratch *s = trainer->scratch;
    for (int l = 0; s && l < DENSE_MAX_LAYERS; l++) {
        free(s->x[l]);
        free(s->rows[l]);
        free(s->d_y[l]);
        free(s->gradient[l]);
        free(s->transposed[l]);
    }
    if (s) {
        free(s->x[DENSE_MAX_LAYERS]);
        free(s->loss);
    }
    free(s);
    free(trainer->parameters);
    free(trainer->moments);
    dense_packed_fini(&trainer->packed);
    *trainer = (struct dense_trainer){.step = 0};
}

struct step {
    struct dense_trainer *trainer;
    const struct dense_batch *batch;
    const struct kernel *kernel;
    size_t slices, chunks;
};

static float *slice_x(const struct step *step, int l, size_t slice) {
    const struct dense_shape *shape = &step->trainer->shape;
    const int last = dense_layer_count(shape);
    size_t features = (size_t)(l == 0 ? shape->inputs : l == last ? shape->outputs : shape->width);
    return step->trainer->scratch->x[l] + slice * features * DENSE_SLICE;
}

static void transpose_slice(const float *x, size_t features, size_t stride, float *rows) {
    for (size_t first = 0; first < features; first += NET_LANES) {
        size_t end = first + NET_LANES < features ? first + NET_LANES : features;
        for (size_t s = 0; s < DENSE_SLICE; s++)
            for (size_t i = first; i < end; i++) rows[s * stride + i] = x[i * DENSE_SLICE + s];
    }
}

static void slice_forward(const struct step *step, size_t slice) {
    const struct dense_packed *packed = &step->trainer->packed;
    const float *bias = packed->biases;
    for (int l = 0; l < dense_layer_count(&packed->shape); l++) {
        struct dense_layer at = dense_layer_at(&packed->shape, l);
        const float *x = slice_x(step, l, slice);
        step->kernel->gemm(&(struct gemm){.rows = at.n_out,
                                          .depth = at.n_in,
                                          .columns = DENSE_SLICE,
                                          .a = packed->weights[l],
                                          .b = x,
                                          .b_stride = DENSE_SLICE,
                                          .bias = bias,
                                          .add = at.skip ? slice_x(step, l - 1, slice) : NULL,
                                          .relu = at.relu,
                                          .c = slice_x(step, l + 1, slice),
                                          .c_stride = DENSE_SLICE});
        size_t stride = row_stride(&at);
        transpose_slice(x, at.n_in, stride, step->trainer->scratch->rows[l] + slice * DENSE_SLICE * stride);
        bias += at.n_out;
    }
}

// Into the slice's part of the chunk's packed gradient.
static void keep_gradient(const struct step *step, int l, size_t n_out, size_t slice, const float *d) {
    const size_t tile = (size_t)step->kernel->gemm_tile, chunk = slice / CHUNK_SLICES;
    float *to = step->trainer->scratch->d_y[l] + chunk * gemm_packed_count((int)tile, n_out, CHUNK) +
                slice % CHUNK_SLICES * DENSE_SLICE * tile;
    for (size_t row = 0; row < n_out; row += tile, to += tile * CHUNK)
        gemm_pack((int)tile, n_out - row < tile ? n_out - row : tile, DENSE_SLICE, d + row * DENSE_SLICE, DENSE_SLICE,
                  1, to);
}

// d: gradient of the output of the last layer.
static void slice_backward(const struct step *step, size_t slice, const float *d_z) {
    enum { SIZE = DENSE_MAX_WIDTH * DENSE_SLICE };
    _Alignas(64) float buffer[3][SIZE]; // gradients of x[l + 1], x[l], and of x[l - 1] by way of the skip
    const struct dense_shape *shape = &step->trainer->shape;
    const float *skipped = NULL;
    for (int l = dense_layer_count(shape) - 1; l >= 0; l--) {
        struct dense_layer at = dense_layer_at(shape, l);
        float *d_y = buffer[(l + 1) % 3], *d_x = buffer[l % 3];
        if (at.relu) {
            const float *y = slice_x(step, l + 1, slice);
            for (size_t i = 0; i < at.n_out * DENSE_SLICE; i++) d_y[i] = y[i] > 0 ? d_y[i] : 0;
        }
        const float *d = at.relu ? d_y : d_z;
        keep_gradient(step, l, at.n_out, slice, d);
        if (l == 0) break;
        step->kernel->gemm(&(struct gemm){.rows = at.n_in,
                                          .depth = at.n_out,
                                          .columns = DENSE_SLICE,
                                          .a = step->trainer->scratch->transposed[l],
                                          .b = d,
                                          .b_stride = DENSE_SLICE,
                                          .add = skipped,
                                          .c = d_x,
                                          .c_stride = DENSE_SLICE});
        skipped = at.skip ? d_y : NULL;
    }
}

static void work_slice(void *user, size_t slice, int worker) {
    (void)worker;
    const struct step *step = user;
    const struct dense_shape *shape = &step->trainer->shape;
    _Alignas(64) float d_z[DENSE_MAX_OUTPUTS * DENSE_SLICE];
    size_t outputs = (size_t)shape->outputs * DENSE_SLICE, first = slice * DENSE_SLICE;
    size_t left = first < step->batch->n ? step->batch->n - first : 0;
    int count = (int)(left < DENSE_SLICE ? left : DENSE_SLICE);
    float *x = slice_x(step, 0, slice);
    memset(x, 0, (size_t)shape->inputs * DENSE_SLICE * sizeof(float));
    memset(d_z, 0, outputs * sizeof(float));
    if (count) step->batch->inputs(step->batch->user, first, count, x);
    slice_forward(step, slice);
    const float *z = slice_x(step, dense_layer_count(shape), slice);
    step->trainer->scratch->loss[slice] = count ? step->batch->loss(step->batch->user, first, count, z, d_z) : 0;
    slice_backward(step, slice, d_z);
}

static void adam(struct dense_trainer *trainer, size_t first, size_t count, const float *gradient) {
    const float correct1 = 1 / (1 - powf(beta1, (float)trainer->step)),
                correct2 = 1 / (1 - powf(beta2, (float)trainer->step));
    float *p = trainer->parameters + first, *m = trainer->moments + first;
    float *v = m + dense_parameters(&trainer->shape);
    for (size_t i = 0; i < count; i++) {
        m[i] = beta1 * m[i] + (1 - beta1) * gradient[i];
        v[i] = beta2 * v[i] + (1 - beta2) * gradient[i] * gradient[i];
        p[i] -= rate * (m[i] * correct1) / (sqrtf(v[i] * correct2) + epsilon);
    }
}

static size_t group_count(const struct step *step, int l) {
    size_t rows = (size_t)step->kernel->gemm_tile * GROUP_TILES;
    return (dense_layer_at(&step->trainer->shape, l).n_out + rows - 1) / rows;
}

// `index` counts the row groups of all layers.
static void update_group(void *user, size_t index, int worker) {
    (void)worker;
    const struct step *step = user;
    struct dense_trainer *trainer = step->trainer;
    const struct dense_scratch *scratch = trainer->scratch;
    int l = 0;
    for (; index >= group_count(step, l); l++) index -= group_count(step, l);
    struct dense_layer at = dense_layer_at(&trainer->shape, l);
    const size_t tile = (size_t)step->kernel->gemm_tile, first = index * tile * GROUP_TILES, stride = row_stride(&at);
    const size_t rows = at.n_out - first < tile * GROUP_TILES ? at.n_out - first : tile * GROUP_TILES;
    const size_t chunk_size = gemm_packed_count((int)tile, at.n_out, CHUNK);
    float *gradient = scratch->gradient[l] + first * stride, d_b[16 * GROUP_TILES] = {0};
    for (size_t chunk = 0; chunk < step->chunks; chunk++) {
        const float *d_y = scratch->d_y[l] + chunk * chunk_size + first * CHUNK;
        step->kernel->gemm(&(struct gemm){.rows = rows,
                                          .depth = CHUNK,
                                          .columns = stride,
                                          .a = d_y,
                                          .b = scratch->rows[l] + chunk * CHUNK * stride,
                                          .b_stride = stride,
                                          .add = chunk ? gradient : NULL,
                                          .c = gradient,
                                          .c_stride = stride});
        for (size_t row = 0; row < rows; row++) // [tile][sample][row of the tile]
            for (size_t s = 0; s < CHUNK; s++) d_b[row] += d_y[(row / tile * CHUNK + s) * tile + row % tile];
    }
    for (size_t row = 0; row < rows; row++)
        adam(trainer, at.w + (first + row) * at.n_in, at.n_in, gradient + row * stride);
    adam(trainer, at.b + first, rows, d_b);
}

static void pack_layer(void *user, size_t layer, int worker) {
    (void)worker;
    const struct step *step = user;
    const struct dense_trainer *trainer = step->trainer;
    const int l = (int)(layer / 2), tile = step->kernel->gemm_tile;
    struct dense_layer at = dense_layer_at(&trainer->shape, l);
    const float *w = trainer->parameters + at.w;
    if (layer % 2)
        gemm_pack(tile, at.n_in, at.n_out, w, 1, at.n_in, trainer->scratch->transposed[l]);
    else
        gemm_pack(tile, at.n_out, at.n_in, w, at.n_in, 1, trainer->packed.weights[l]);
}

static void pack_parameters(const struct step *step, int threads) {
    struct dense_trainer *trainer = step->trainer;
    const size_t layers = (size_t)dense_layer_count(&trainer->shape);
    parallel_for(threads, 2 * layers, pack_layer, (void *)(uintptr_t)step);
    float *bias = trainer->packed.biases;
    for (size_t l = 0; l < layers; l++) {
        struct dense_layer at = dense_layer_at(&trainer->shape, (int)l);
        memcpy(bias, trainer->parameters + at.b, at.n_out * sizeof(float));
        bias += at.n_out;
    }
}

double dense_trainer_step(struct dense_trainer *trainer, const struct dense_batch *batch, int threads) {
    struct step step = {trainer, batch, kernel_best(), 0, (batch->n + CHUNK - 1) / CHUNK};
    step.slices = step.chunks * CHUNK_SLICES;
    if (trainer->step == 0) pack_parameters(&step, threads);
    parallel_for(threads, step.slices, work_slice, &step);
    trainer->step++;
    size_t groups = 0;
    for (int l = 0; l < dense_layer_count(&trainer->shape); l++) groups += group_count(&step, l);
    parallel_for(threads, groups, update_group, &step);
    pack_parameters(&step, threads);
    double loss = 0;
    for (size_t slice = 0; slice < step.slices; slice++) loss += trainer->scratch->loss[slice];
    return loss;
}
