// Eight numbers at a time, in the compiler's vectors. Comparisons give all ones or zeros in each lane.
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

enum { LANE_COUNT = 8 };
typedef float lanes __attribute__((vector_size(4 * LANE_COUNT)));
typedef int32_t lanes_mask __attribute__((vector_size(4 * LANE_COUNT)));

static inline lanes lanes_load(const float *from) { // at any address, as the following
    lanes result;
    memcpy(&result, from, sizeof result);
    return result;
}
static inline lanes_mask lanes_load_bits(const uint32_t *from) {
    lanes_mask result;
    memcpy(&result, from, sizeof result);
    return result;
}
static inline void lanes_store(float *to, lanes x) { memcpy(to, &x, sizeof x); }
static inline lanes lanes_splat(float x) { return x - (lanes){0}; }
static inline lanes lanes_keep(lanes x, lanes_mask where) { return (lanes)((lanes_mask)x & where); } // else 0
static inline lanes lanes_min(lanes a, lanes b) {
    const lanes_mask less = a < b;
    return (lanes)(((lanes_mask)a & less) | ((lanes_mask)b & ~less));
}
static inline bool lanes_any(lanes_mask mask) {
    uint64_t words[sizeof mask / sizeof(uint64_t)], any = 0;
    memcpy(words, &mask, sizeof mask);
    for (size_t i = 0; i < sizeof words / sizeof *words; i++) any |= words[i];
    return any;
}
