#include "net/gemm.h"

size_t gemm_packed_count(int tile, size_t rows, size_t depth) {
    size_t n = (size_t)tile;
    return (rows + n - 1) / n * n * depth;
}

void gemm_pack(int tile, size_t rows, size_t depth, const float *from, size_t row_step, size_t depth_step, float *to) {
    const size_t n = (size_t)tile;
    for (size_t first = 0; first < rows; first += n) {
        size_t count = rows - first < n ? rows - first : n;
        const float *corner = from + first * row_step;
        for (size_t k = 0; k < depth; k++, to += n) {
            for (size_t r = 0; r < count; r++) to[r] = corner[r * row_step + k * depth_step];
            for (size_t r = count; r < n; r++) to[r] = 0;
        }
    }
}
