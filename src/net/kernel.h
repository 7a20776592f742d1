// Batched kernels over blocks of NET_LANES samples, one source (net/kernel_body.h) compiled for AVX2 and for AVX-512.
// Every block array is [feature][NET_LANES], 64-byte aligned. Hot calls: no checks.
#pragma once

#include "net/gemm.h"
#include "net/grid.h"
#include "net/mlp.h"

struct kernel {
    const char *name;
    // Corners of all lookups: index, weight [corner_count][NET_LANES].
    void (*index)(const struct grid_layout *layout, const struct grid_input *input, int32_t *index, float *weight);
    // x [grid_input_count][NET_LANES] from float tables [entry][2].
    void (*gather_float)(const struct grid_layout *layout, const float *table, const struct grid_input *input,
                         const int32_t *index, const float *weight, float *x);
    // The same, corners and all, from 8-bit tables with a scale per level.
    void (*lookup)(const struct grid_layout *layout, const int8_t *codes, const float *scale,
                   const struct grid_input *input, float *x);
    // x [grid_input_count] of one lane of the input alone, bit for bit.
    void (*lookup_lane)(const struct grid_by_lookup *grid, const int8_t *codes, const struct grid_input *input,
                        int lane, float *x);
    // One block: x -> h1, h2 [width][NET_LANES], z [outputs][NET_LANES].
    void (*forward)(const struct mlp_shape *shape, const float *parameters, const float *x, float *h1, float *h2,
                    float *z);
    // x [inputs] -> z [outputs] of one sample, bit for bit; weights of mlp_transpose.
    void (*forward_lane)(const struct mlp_shape *shape, const float *by_input, const float *x, float *z);
    // `blocks` consecutive blocks. d_x [block][d_inputs][NET_LANES] for the first d_inputs inputs only; d_parameters is
    // added to; d_h: scratch of 2 * blocks * width * NET_LANES floats.
    void (*backward)(const struct mlp_shape *shape, const float *parameters, size_t blocks, const float *x,
                     const float *h1, const float *h2, const float *d_z, int d_inputs, float *d_x, float *d_h,
                     float *d_parameters);
    void (*exponential)(float *values, size_t count); // in place; count a multiple of NET_LANES; |value| < 80
    int gemm_tile; // of gemm_pack
    void (*gemm)(const struct gemm *gemm);
};

extern const struct kernel kernel_avx2; // or whatever the build's own target is
extern const struct kernel kernel_avx512; // name == NULL where the compiler cannot build it
const struct kernel *kernel_best(void); // the fastest that this processor runs
