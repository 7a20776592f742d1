// The tile of a matrix product in registers: GEMM_TILE rows by up to GEMM_VECTORS vectors of columns, over the whole
// depth. Included by kernel_body.h, which defines the vectors.
#include "net/gemm.h"

enum { GEMM_TILE = VECTOR_LANES == 16 ? 12 : 6, GEMM_VECTORS = 2 };

static inline __attribute__((always_inline)) void gemm_tile(int vectors, size_t rows, const struct gemm *g,
                                                            const float *a, size_t row, size_t column) {
    vfloat sum[GEMM_TILE][GEMM_VECTORS];
    const float *b = g->b + column;
    for (int r = 0; r < GEMM_TILE; r++)
        for (int v = 0; v < vectors; v++) sum[r][v] = splat(0);
    for (size_t k = 0; k < g->depth; k++, a += GEMM_TILE, b += g->b_stride) {
        __builtin_prefetch(a + GEMM_TILE * g->depth); // the next tile's row: 1.5 times faster at 64 columns
        vfloat bk[GEMM_VECTORS];
        for (int v = 0; v < vectors; v++) bk[v] = *(const vfloat *)(b + v * VECTOR_LANES);
#pragma GCC unroll 16
        for (int r = 0; r < GEMM_TILE; r++)
            for (int v = 0; v < vectors; v++) sum[r][v] += a[r] * bk[v];
    }
    size_t at = row * g->c_stride + column;
    for (size_t r = 0; r < GEMM_TILE; r++) {
        if (r >= rows) break;
        float bias = g->bias ? g->bias[row + r] : 0;
        for (int v = 0; v < vectors; v++) {
            size_t place = at + r * g->c_stride + (size_t)(v * VECTOR_LANES);
            vfloat value = sum[r][v] + splat(bias);
            if (g->add) value += *(const vfloat *)(g->add + place);
            if (g->relu) value = (vfloat)((vint)value & (vint)(value > splat(0)));
            *(vfloat *)(g->c + place) = value;
        }
    }
}

// Tiles outside, so that a tile of `a` is fetched once for all columns.
static void kernel_gemm(const struct gemm *g) {
    const size_t wide = GEMM_VECTORS * VECTOR_LANES;
    for (size_t row = 0; row < g->rows; row += GEMM_TILE) {
        const float *a = g->a + row * g->depth;
        size_t rows = g->rows - row < GEMM_TILE ? g->rows - row : GEMM_TILE, column = 0;
        for (; column + wide <= g->columns; column += wide) gemm_tile(GEMM_VECTORS, rows, g, a, row, column);
        if (column < g->columns) gemm_tile(1, rows, g, a, row, column);
    }
}
