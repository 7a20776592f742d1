// The sampling density for blocks of SAMPLING_LANES shading points: one source (sampling_kernel_body.h) compiled for
// AVX2 and for AVX-512, chosen with the network's kernels. The same mixture as sampling_query.c, which answers alone
// for points inside the bounding sphere and is what the tests compare with.
#pragma once

#include "luminaire/sampling.h"

enum { SAMPLING_LANES = 16 };

struct sampling_lanes { // a block, component by component
    _Alignas(64) float s[3][SAMPLING_LANES]; // shading points
    _Alignas(64) float u[3][SAMPLING_LANES]; // random numbers
    _Alignas(64) float direction[3][SAMPLING_LANES];
    _Alignas(64) float pdf_sa[SAMPLING_LANES];
};

struct sampling_kernel {
    void (*sample)(const struct sampling_density *density, struct sampling_lanes *lanes); // s, u -> direction, pdf_sa
    void (*pdf)(const struct sampling_density *density, struct sampling_lanes *lanes); // s, direction -> pdf_sa
};

extern const struct sampling_kernel sampling_kernel_avx2, sampling_kernel_avx512; // sample == NULL: cannot be built
const struct sampling_kernel *sampling_kernel_best(void); // the fastest that this processor runs
