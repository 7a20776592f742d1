// Batches of the sampling density: blocks for the fastest kernel.
#include <string.h>

#include "luminaire/sampling_kernel.h"
#include "net/kernel.h"

const struct sampling_kernel *sampling_kernel_best(void) {
    bool wide = kernel_best() == &kernel_avx512 && sampling_kernel_avx512.sample;
    return wide ? &sampling_kernel_avx512 : &sampling_kernel_avx2;
}

// vectors[first ...) to lanes; the last one fills those left over.
static size_t load_lanes(float lanes[3][SAMPLING_LANES], size_t first, size_t n, const float (*vectors)[3]) {
    size_t count = n - first < SAMPLING_LANES ? n - first : SAMPLING_LANES;
    for (size_t i = 0; i < SAMPLING_LANES; i++) {
        const float *v = vectors[first + (i < count ? i : count - 1)];
        for (int c = 0; c < 3; c++) lanes[c][i] = v[c];
    }
    return count;
}

void sampling_sample_batch(const struct sampling_density *density, size_t n, const float (*s)[3], const float (*u)[3],
                           float (*direction)[3], float *pdf_sa) {
    const struct sampling_kernel *kernel = sampling_kernel_best();
    struct sampling_lanes lanes;
    for (size_t first = 0; first < n; first += SAMPLING_LANES) {
        size_t count = load_lanes(lanes.s, first, n, s);
        load_lanes(lanes.u, first, n, u);
        kernel->sample(density, &lanes);
        for (size_t i = 0; i < count; i++)
            for (int c = 0; c < 3; c++) direction[first + i][c] = lanes.direction[c][i];
        memcpy(pdf_sa + first, lanes.pdf_sa, count * sizeof *pdf_sa);
    }
}

void sampling_pdf_batch(const struct sampling_density *density, size_t n, const float (*s)[3],
                        const float (*direction)[3], float *pdf_sa) {
    const struct sampling_kernel *kernel = sampling_kernel_best();
    struct sampling_lanes lanes;
    for (size_t first = 0; first < n; first += SAMPLING_LANES) {
        size_t count = load_lanes(lanes.s, first, n, s);
        load_lanes(lanes.direction, first, n, direction);
        kernel->pdf(density, &lanes);
        memcpy(pdf_sa + first, lanes.pdf_sa, count * sizeof *pdf_sa);
    }
}
