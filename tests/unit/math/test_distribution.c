// Discrete distributions and one-dimensional warps against their definitions.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <cmocka.h>

#include "math/distribution.h"
#include "math/warp.h"

static void test_discrete(void **state) {
    (void)state;
    const float weights[] = {0, 1, 0, 3, 4, 0, 0};
    struct distribution d;
    assert_int_equal(distribution_init(&d, weights, 7, NULL), STATUS_OK);
    assert_float_equal(d.total, 8, 0);
    size_t counts[7] = {0};
    for (int i = 0; i < 8000; ++i) {
        float remapped;
        size_t index = distribution_sample(&d, ((float)i + 0.5f) / 8000, &remapped);
        assert_true(index < 7 && weights[index] > 0 && remapped >= 0 && remapped < 1);
        ++counts[index];
    }
    for (int i = 0; i < 7; ++i) {
        assert_int_equal(counts[i], (int)weights[i] * 1000);
        assert_float_equal(distribution_pmf(&d, (size_t)i), weights[i] / 8, 1e-7f);
    }
    float remapped;
    assert_int_equal(distribution_sample(&d, 1, &remapped), 4); // 1 itself must not reach the trailing zeros
    assert_int_equal(distribution_sample(&d, 0, &remapped), 1);
    assert_int_equal(distribution_sample(&d, 0.3125f, &remapped), 3);
    assert_float_equal(remapped, 0.5f, 1e-6f);
    distribution_fini(&d);
}

static void test_discrete_edges(void **state) {
    (void)state;
    struct distribution d;
    struct error error;
    assert_int_equal(distribution_init(&d, (const float[]){0, 0, 0, 0}, 4, NULL), STATUS_OK);
    for (size_t i = 0; i < 4; ++i) assert_float_equal(distribution_pmf(&d, i), 0.25f, 0);
    distribution_fini(&d);
    assert_int_equal(distribution_init(&d, (const float[]){1, -1}, 2, &error), STATUS_INVALID);
    assert_int_equal(distribution_init(&d, (const float[]){1, NAN}, 2, &error), STATUS_INVALID);
    assert_int_equal(distribution_init(&d, (const float[]){1}, 0, &error), STATUS_INVALID);
    assert_int_equal(distribution_init(&d, (const float[]){1}, SIZE_MAX, &error), STATUS_MEMORY);
    // Tiny shares survive or vanish, but what is sampled always has a probability.
    size_t n = 200000;
    float *weights = malloc(n * sizeof *weights);
    assert_non_null(weights);
    for (size_t i = 0; i < n; ++i) weights[i] = i % 3 ? 1 : 1e-6f;
    assert_int_equal(distribution_init(&d, weights, n, NULL), STATUS_OK);
    double total = 0;
    for (size_t i = 0; i < n; ++i) total += (double)distribution_pmf(&d, i);
    assert_float_equal(total, 1, 1e-9);
    for (int i = 0; i <= 10000; ++i)
        assert_true(distribution_pmf(&d, distribution_sample(&d, (float)i / 10000, NULL)) > 0);
    free(weights);
    distribution_fini(&d);
}

static void test_square(void **state) {
    (void)state;
    struct distribution2d d;
    const float huge[] = {3e38f, 3e38f, 3e38f, 0}; // a row's sum exceeds FLT_MAX
    assert_int_equal(distribution2d_init(&d, huge, 2, 2, NULL), STATUS_OK);
    assert_float_equal(distribution2d_pdf(&d, (vec2){0.1f, 0.1f}), 4.0f / 3, 1e-5f);
    assert_float_equal(distribution2d_pdf(&d, (vec2){0.9f, 1}), 0, 0);
    assert_float_equal(distribution2d_pdf(&d, (vec2){0, 1}), 4.0f / 3, 1e-5f);
    float pdf;
    vec2 p = distribution2d_sample(&d, (vec2){0.75f, 1.0f / 3}, &pdf);
    assert_float_equal(p.x, 0.75f, 1e-5f);
    assert_float_equal(p.y, 0.25f, 1e-5f);
    assert_float_equal(pdf, distribution2d_pdf(&d, p), 1e-6f);
    distribution2d_fini(&d);
    struct error error;
    assert_int_equal(distribution2d_init(&d, (const float[]){1, 2, 3, -4}, 2, 2, &error), STATUS_INVALID);
    assert_int_equal(distribution2d_init(&d, huge, 0, 2, &error), STATUS_INVALID);
}

static void test_lines(void **state) {
    (void)state;
    for (int i = 0; i <= 1000; ++i) {
        float u = (float)i / 1000, x = warp_tent(u), y = warp_gaussian(u, 0.5f, 2);
        float tent_cdf = x < 0 ? 0.5f * sqrf(1 + x) : 1 - 0.5f * sqrf(1 - x);
        assert_float_equal(tent_cdf, u, 1e-6f);
        double edge = erf(2 / (0.5 * sqrt(2)));
        assert_float_equal((float)(0.5 * erf((double)y / (0.5 * sqrt(2))) / edge + 0.5), u, 2e-6f);
        assert_true(fabsf(y) <= 2);
    }
}

static void test_octahedral(void **state) {
    (void)state;
    for (int i = 0; i < 4000; ++i) {
        vec3 w = warp_uniform_sphere((vec2){(float)(i % 97) / 97, (float)i / 3999});
        vec2 p = octahedral_from_direction(w);
        assert_true(p.x >= 0 && p.x <= 1 && p.y >= 0 && p.y <= 1);
        assert_true(vec3_length(vec3_sub(direction_from_octahedral(p), w)) < 2e-6f);
        assert_float_equal(vec3_length(w), 1, 1e-6f);
    }
    assert_float_equal(direction_from_octahedral((vec2){0.5f, 0.5f}).z, 1, 0);
    assert_float_equal(direction_from_octahedral((vec2){0, 0}).z, -1, 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_discrete), cmocka_unit_test(test_discrete_edges), cmocka_unit_test(test_square),
        cmocka_unit_test(test_lines),    cmocka_unit_test(test_octahedral),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
