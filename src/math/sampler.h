// Random numbers as a pure function of (seed, stream, sample, dimension), so that an image does not depend on the
// number of threads. `stream` is a pixel index, a light path's block, ...
#pragma once

#include <stdint.h>

#include "math/vec.h"

struct sampler {
    uint64_t key;       // hash of (seed, stream, sample)
    uint32_t dimension; // next dimension
};

static inline uint64_t sampler_mix(uint64_t x) { // splitmix64's finaliser (Steele et al. 2014, OOPSLA)
    x += 0x9E3779B97F4A7C15ull;
    x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9ull;
    x = (x ^ (x >> 27)) * 0x94D049BB133111EBull;
    return x ^ (x >> 31);
}

static inline struct sampler sampler_make(uint64_t seed, uint64_t stream, uint64_t sample) {
    return (struct sampler){sampler_mix(sampler_mix(sampler_mix(seed) ^ stream) ^ (sample * 0xD1342543DE82EF95ull)), 0};
}

static inline uint64_t sampler_bits(struct sampler *s) { return sampler_mix(s->key ^ ((uint64_t)s->dimension++ << 32)); }
static inline float sampler_float_from_bits(uint32_t bits) { return (float)(bits >> 8) * 0x1p-24f; }
static inline float sampler_1d(struct sampler *s) { return sampler_float_from_bits((uint32_t)(sampler_bits(s) >> 32)); } // [0,1)
static inline vec2 sampler_2d(struct sampler *s) {
    uint64_t bits = sampler_bits(s);
    return (vec2){sampler_float_from_bits((uint32_t)(bits >> 32)), sampler_float_from_bits((uint32_t)bits)};
}
