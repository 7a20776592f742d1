// The sampler: points of one stream stratified against each other, streams and dimensions independent of each other.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>
#include <cmocka.h>

#include "math/sampler.h"

static uint32_t sobol_second(uint32_t index) { // by its direction numbers
    uint32_t result = 0;
    for (uint32_t v = 1u << 31; index; index >>= 1, v ^= v >> 1)
        if (index & 1) result ^= v;
    return result;
}

static void test_sobol_product(void **unused) {
    (void)unused;
    for (uint32_t i = 0; i < 100000; i++) {
        uint32_t index = i * 2654435761u;
        assert_int_equal(sampler_reverse_bits(sampler_sobol_reversed(index)), sobol_second(index));
    }
}

// Any 64 successive samples from a multiple of 64: one in each elementary interval of area 1/64, of every shape.
static void test_elementary_intervals(void **unused) {
    (void)unused;
    for (uint64_t stream = 0; stream < 50; stream++) {
        for (uint32_t dimension = 0; dimension < SAMPLER_SOBOL_DIMENSIONS; dimension++) {
            for (int split = 0; split <= 6; split++) {
                char counts[64] = {0};
                for (uint64_t i = 0; i < 64; i++) {
                    struct sampler sampler = sampler_make(3, stream, i + 64 * (stream % 5));
                    sampler.dimension = dimension;
                    vec2 u = sampler_2d(&sampler);
                    int x = (int)(u.x * (float)(1 << split)), y = (int)(u.y * (float)(64 >> split));
                    counts[x << (6 - split) | y]++;
                }
                for (int cell = 0; cell < 64; cell++) assert_int_equal(counts[cell], 1);
            }
        }
    }
}

enum { N = 1 << 18, CELLS = 8 };

// Chi-square of three numbers on a grid of 512 cells; 5 standard deviations of chi-square with 511 degrees of freedom.
static void check_uniform(uint64_t stream_step, uint64_t sample_step, uint32_t dimension) {
    static int counts[CELLS][CELLS][CELLS];
    memset(counts, 0, sizeof counts);
    for (uint64_t i = 0; i < N; i++) {
        struct sampler sampler = sampler_make(1, i * stream_step, i * sample_step);
        sampler.dimension = dimension;
        vec2 first = sampler_2d(&sampler), second = sampler_2d(&sampler);
        assert_true(first.x >= 0 && first.x < 1 && first.y >= 0 && first.y < 1);
        counts[(int)(first.x * CELLS)][(int)(first.y * CELLS)][(int)(second.x * CELLS)]++;
    }
    double expected = (double)N / (CELLS * CELLS * CELLS), chi_square = 0;
    for (int i = 0; i < CELLS * CELLS * CELLS; i++) {
        double difference = (&counts[0][0][0])[i] - expected;
        chi_square += difference * difference / expected;
    }
    assert_true(chi_square < 511 + 5 * 32);
}

static void test_independence(void **unused) {
    (void)unused;
    const uint32_t dimensions[] = {0, 5, SAMPLER_SOBOL_DIMENSIONS - 1, SAMPLER_SOBOL_DIMENSIONS, 1000};
    for (int i = 0; i < 5; i++) {
        check_uniform(1, 0, dimensions[i]);
        check_uniform(0, 1, dimensions[i]);
        check_uniform(1, 1, dimensions[i]);
        check_uniform(0, (uint64_t)1 << 32, dimensions[i]);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_sobol_product),
                                       cmocka_unit_test(test_elementary_intervals),
                                       cmocka_unit_test(test_independence)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
