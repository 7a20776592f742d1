// Random numbers as a pure function of (seed, stream, sample, dimension), so that an image does not depend on the
// number of threads. `stream` is a pixel index, a light path's block, ...
// The first dimensions are Owen-scrambled Sobol points over `sample`, two coordinates to a dimension, each dimension's
// points shuffled independently of the others' (Burley 2020, "Practical Hash-based Owen Scrambling", JCGT 9(4), with
// Vegdahl's 2021 constants for the hash); the others are plain hashes. Every value alone is uniform and independent
// between streams; the samples of one stream are stratified against each other.
#pragma once

#include <stdint.h>

#include "math/vec.h"

enum { SAMPLER_SOBOL_DIMENSIONS = 24 };

struct sampler {
    uint64_t key; // hash of (seed, stream)
    uint32_t index; // sample, its bits reversed
    uint32_t dimension; // next dimension
};

static inline uint64_t sampler_mix(uint64_t x) { // splitmix64's finaliser (Steele et al. 2014, OOPSLA)
    x += 0x9E3779B97F4A7C15ull;
    x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9ull;
    x = (x ^ (x >> 27)) * 0x94D049BB133111EBull;
    return x ^ (x >> 31);
}

static inline uint32_t sampler_reverse_bits(uint32_t x) {
    x = __builtin_bswap32(x);
    x = (x & 0x0F0F0F0Fu) << 4 | (x >> 4 & 0x0F0F0F0Fu);
    x = (x & 0x33333333u) << 2 | (x >> 2 & 0x33333333u);
    return (x & 0x55555555u) << 1 | (x >> 1 & 0x55555555u);
}

// A nested uniform scramble of the number whose bits, reversed, are x: no bit depends on higher ones.
static inline uint32_t sampler_scramble_reversed(uint32_t x, uint32_t seed) {
    x ^= x * 0x3D20ADEAu;
    x += seed;
    x *= (seed >> 16) | 1;
    x ^= x * 0x05526C56u;
    return x ^ x * 0x53A22864u;
}

// The second Sobol coordinate of `index`, bits reversed: the product with Pascal's triangle modulo 2, which is a
// Kronecker power and so takes one step for each bit of the bit's number.
static inline uint32_t sampler_sobol_reversed(uint32_t index) {
    index ^= index >> 16;
    index ^= (index & 0xFF00FF00u) >> 8;
    index ^= (index & 0xF0F0F0F0u) >> 4;
    index ^= (index & 0xCCCCCCCCu) >> 2;
    return index ^ (index & 0xAAAAAAAAu) >> 1;
}

static inline struct sampler sampler_make(uint64_t seed, uint64_t stream, uint64_t sample) {
    uint64_t key = sampler_mix(sampler_mix(sampler_mix(seed) ^ stream) ^ (sample >> 32) * 0xD1342543DE82EF95ull);
    return (struct sampler){key, sampler_reverse_bits((uint32_t)sample), 0};
}

// Two numbers of 32 bits: the next dimension.
static inline uint64_t sampler_bits(struct sampler *s) {
    uint32_t dimension = s->dimension++;
    uint64_t hash = sampler_mix(s->key ^ (uint64_t)dimension * 0x9FB21C651E98DF25ull);
    if (dimension >= SAMPLER_SOBOL_DIMENSIONS) return sampler_mix(hash ^ s->index);
    uint32_t seed_y =
        (uint32_t)(hash * 0xD1342543DE82EF95ull >> 32); // the top bits of the product depend on all of the hash
    uint32_t index = sampler_reverse_bits(sampler_scramble_reversed(s->index, (uint32_t)hash));
    uint32_t x = sampler_reverse_bits(sampler_scramble_reversed(index, (uint32_t)(hash >> 32)));
    uint32_t y = sampler_reverse_bits(sampler_scramble_reversed(sampler_sobol_reversed(index), seed_y));
    return (uint64_t)x << 32 | y;
}
static inline float sampler_float_from_bits(uint32_t bits) { return (float)(bits >> 8) * 0x1p-24f; }
static inline float sampler_1d(struct sampler *s) {
    return sampler_float_from_bits((uint32_t)(sampler_bits(s) >> 32));
} // [0,1)
static inline vec2 sampler_2d(struct sampler *s) {
    uint64_t bits = sampler_bits(s);
    return (vec2){sampler_float_from_bits((uint32_t)(bits >> 32)), sampler_float_from_bits((uint32_t)bits)};
}
