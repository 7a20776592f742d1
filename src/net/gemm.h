// Products of dense matrices, the arithmetic of wide layers: c = [relu] (a b + bias + add).
//   b [depth][columns], c and add [rows][columns]: row-major, rows of b_stride and c_stride floats, 64-byte aligned
//   a [rows][depth]: packed, see gemm_pack
// `columns` is a multiple of NET_LANES. The order of additions depends on the processor alone, so that results do not
// depend on how the columns are cut into calls. kernel->gemm (net/kernel.h) does the work.
#pragma once

#include <stdbool.h>
#include <stddef.h>

struct gemm {
    size_t rows, depth, columns;
    const float *a, *b;
    size_t b_stride;
    const float *bias; // [rows], or NULL: 0
    const float *add; // laid out as c, may be c itself; or NULL: 0
    bool relu;
    float *c;
    size_t c_stride;
};

// [rows / tile][depth][tile], the last tile filled up with zeros. The element of row r at depth k is
// from[r * row_step + k * depth_step].
size_t gemm_packed_count(int tile, size_t rows, size_t depth);
void gemm_pack(int tile, size_t rows, size_t depth, const float *from, size_t row_step, size_t depth_step, float *to);
