// The bins against light fields whose irradiance and errors are known.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "bake/line_bins.h"
#include "math/sampler.h"
#include "math/warp.h"

static const vec3 center = {1, 2, 3};

// Particles of an isotropic point lamp at the centre, each of flux `y`; those of direction z < 0 get `below` times
// that.
static void fill(struct line_bins *bins, uint64_t seed, size_t n, float y, float below) {
    struct error error;
    assert_int_equal(line_bins_init(bins, center, 2, &error), STATUS_OK);
    for (size_t i = 0; i < n; i++) {
        struct sampler sampler = sampler_make(seed, i, 0); // independent, not stratified
        vec3 w = warp_uniform_sphere(sampler_2d(&sampler));
        line_bins_add(bins, vec3_mad(w, 2, center), w, w.z < 0 ? y * below : y);
        if ((i + 1) % (n / 10) == 0) line_bins_close_batch(bins, n / 10);
    }
}

static void equal_fields_differ_by_noise(void **state) {
    (void)state;
    struct line_bins a, b;
    fill(&a, 1, 200000, 5, 1);
    fill(&b, 2, 400000, 5, 1);
    for (int k = 0; k < EVALUATION_DISTANCES; k++) {
        float error, noise;
        line_bins_irradiance_error(&a, &b, k, &error, &noise);
        assert_true(noise > 0.01f && noise < 0.05f); // sqrt((1/1000 + 1/2000) 2/pi) = 0.031 by 1000 and 2000 a patch
        assert_true(error > 0.8f * noise && error < 1.2f * noise); // +-5 % over 200 patches
    }
    assert_true(fabsf(line_bins_radiance_error(&a, &b)) < 0.02f);
    line_bins_fini(&a);
    line_bins_fini(&b);
}

static void a_wrong_half_is_seen(void **state) {
    (void)state;
    struct line_bins a, b;
    fill(&a, 1, 400000, 5, 1.5f);
    fill(&b, 2, 400000, 5, 1);
    float error, noise;
    line_bins_irradiance_error(&a, &b, 0, &error, &noise);
    assert_true(fabsf(error - 0.25f - 0.4f * noise) < 0.02f); // half of the patches are 50 % off
    float squared = line_bins_radiance_error(&a, &b); // mean of 0.5^2 over half
    assert_true(fabsf(squared - 0.125f) < 0.02f);
    line_bins_fini(&a);
    line_bins_fini(&b);
}

static void a_black_field_scores_one(void **state) {
    (void)state;
    struct line_bins black, b;
    fill(&black, 1, 1000, 0, 1);
    fill(&b, 2, 400000, 5, 1);
    float error, noise;
    line_bins_irradiance_error(&black, &b, 2, &error, &noise);
    assert_true(fabsf(error - 1) < 1e-6f);
    assert_true(fabsf(line_bins_radiance_error(&black, &b) - 1) < 0.01f);
    line_bins_fini(&black);
    line_bins_fini(&b);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(equal_fields_differ_by_noise),
                                       cmocka_unit_test(a_wrong_half_is_seen),
                                       cmocka_unit_test(a_black_field_scores_one)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
