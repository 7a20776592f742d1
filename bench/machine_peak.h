// What one core of this machine can do at most, for bench/roofline.c: fused multiply-adds on its widest vectors,
// reading memory in order, fetching entries from random places of a table.
#pragma once

#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <time.h>
#ifdef __x86_64__
#include <immintrin.h>
#endif

enum { PEAK_TRIES = 7 }; // the best counts: other work on the machine only slows down

static volatile float peak_sink;

static double clock_thread_s(void) { // CPU seconds of this thread
    struct timespec now;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

// `lanes` floats a vector, `chains` sums that do not wait for each other.
#define MULTIPLY_ADDS(name, target_attribute, lanes, chains)                                                           \
    static target_attribute float name(size_t rounds, float factor, float term) {                                      \
        typedef float vector __attribute__((vector_size(4 * lanes)));                                                  \
        vector sum[chains], factors = factor - (vector){0}, terms = term - (vector){0};                                \
        for (int k = 0; k < chains; k++) sum[k] = terms * (float)k;                                                    \
        for (size_t i = 0; i < rounds; i++) {                                                                          \
            _Pragma("GCC unroll 16") for (int k = 0; k < chains; k++) sum[k] = sum[k] * factors + terms;               \
        }                                                                                                              \
        for (int k = 1; k < chains; k++) sum[0] += sum[k];                                                             \
        return sum[0][0];                                                                                              \
    }
#ifdef __x86_64__
#define WIDE __attribute__((noinline, target("avx512f,avx512dq,avx512bw,avx512vl")))
MULTIPLY_ADDS(multiply_adds_wide, WIDE, 16, 16)

static WIDE int32_t fetch_gather_wide(const int8_t *table, uint32_t mask, size_t rounds) {
    const __m512i lane = _mm512_setr_epi32(1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16);
    __m512i sum = _mm512_setzero_si512(), state = _mm512_mullo_epi32(lane, _mm512_set1_epi32(0x2545f491));
    for (size_t i = 0; i < rounds; i++) {
        state = _mm512_add_epi32(_mm512_mullo_epi32(state, _mm512_set1_epi32(1664525)), _mm512_set1_epi32(1013904223));
        __m512i at = _mm512_and_si512(_mm512_srli_epi32(state, 4), _mm512_set1_epi32((int)mask));
        sum = _mm512_add_epi32(sum, _mm512_i32gather_epi32(at, table, 2));
    }
    return _mm512_reduce_add_epi32(sum);
}
#endif
MULTIPLY_ADDS(multiply_adds, __attribute__((noinline)), 8, 12)

static __attribute__((noinline)) int32_t fetch_singly(const int8_t *table, uint32_t mask, size_t rounds) {
    uint32_t state[16], sum = 0;
    for (uint32_t l = 0; l < 16; l++) state[l] = (l + 1) * 0x2545f491u;
    for (size_t i = 0; i < rounds; i++) {
        for (int l = 0; l < 16; l++) state[l] = state[l] * 1664525u + 1013904223u;
        for (int l = 0; l < 16; l++) {
            int32_t entry;
            memcpy(&entry, table + 2 * (size_t)(state[l] >> 4 & mask), sizeof entry);
            sum += (uint32_t)entry;
        }
    }
    return (int32_t)sum;
}

static double least_time(double best, double start) {
    double time = clock_thread_s() - start;
    return best == 0 || time < best ? time : best;
}

static double peak_flops(bool wide) { // a second; a multiply-add is two
    const size_t rounds = 1000000;
    double best = 0;
    for (int k = 0; k < PEAK_TRIES; k++) {
        double start = clock_thread_s();
#ifdef __x86_64__
        peak_sink = wide ? multiply_adds_wide(rounds, 0.999f, 0.001f) : multiply_adds(rounds, 0.999f, 0.001f);
#else
        peak_sink = multiply_adds(rounds, 0.999f, 0.001f);
#endif
        best = least_time(best, start);
    }
    return (wide ? 16 * 16 : 8 * 12) * 2 * (double)rounds / best;
}

static double peak_stream(const int8_t *memory, size_t bytes) { // bytes a second
    typedef uint64_t vector __attribute__((vector_size(32)));
    double best = 0;
    for (int k = 0; k < PEAK_TRIES; k++) {
        vector sum[4] = {{0}};
        double start = clock_thread_s();
        for (size_t i = 0; i + 128 <= bytes; i += 128)
            for (size_t j = 0; j < 4; j++) sum[j] += *(const vector *)(const void *)(memory + i + 32 * j);
        best = least_time(best, start);
        peak_sink = (float)(sum[0] + sum[1] + sum[2] + sum[3])[0];
    }
    return (double)bytes / best;
}

// Fetches a second of 4 bytes from random entries of the largest power of two that the table's bytes hold, by gather
// instructions or one by one, whichever is faster.
static double peak_fetch(const int8_t *table, size_t bytes, bool wide, size_t rounds) {
    uint32_t mask = 1;
    while (2 * ((size_t)mask + 1) * 2 + 2 <= bytes) mask = 2 * mask + 1;
    double best = 0;
    for (int k = 0; k < PEAK_TRIES; k++) {
        double start = clock_thread_s();
        peak_sink = (float)fetch_singly(table, mask, rounds);
        best = least_time(best, start);
#ifdef __x86_64__
        start = clock_thread_s();
        if (wide) peak_sink = (float)fetch_gather_wide(table, mask, rounds);
        if (wide) best = least_time(best, start);
#endif
    }
    return 16 * (double)rounds / best;
}
