// FLIP of noisy pictures, extrapolated, against that of the pictures without their noise.
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "bake/evaluate_private.h"
#include "image/metric.h"
#include "math/sampler.h"

enum { SIDE = EVALUATION_PIXELS };

static float normal(struct sampler *s) { // Box and Muller 1958
    vec2 u = sampler_2d(s);
    return sqrtf(-2 * logf(1 - u.x)) * cosf(2 * PI_F * u.y);
}

// A pattern, and one that is a little off in its first columns.
static void fill(struct image *reference, struct image *model, float error, int columns) {
    for (int y = 0; y < SIDE; y++)
        for (int x = 0; x < SIDE; x++)
            for (int c = 0; c < 3; c++) {
                float wave = sinf(0.09f * (float)x + (float)c) * cosf(0.07f * (float)y);
                float value = 0.6f + 0.3f * wave + 0.2f * sinf(0.4f * (float)(x + y));
                size_t i = 3 * (size_t)(y * SIDE + x) + (size_t)c;
                reference->pixels[i] = value;
                float off = x < columns ? error * sinf(0.05f * (float)x * (1 + 0.3f * (float)c)) : 0;
                model->pixels[i] = value * (1 + off);
            }
}

static void add_noise(struct image_pair *pair, const struct image *clean, float sigma, uint64_t seed) {
    for (int half = 0; half < 2; half++)
        for (size_t i = 0; i < 3 * SIDE * SIDE; i++) {
            struct sampler s = sampler_make(seed, (uint64_t)half, i);
            pair->half[half].pixels[i] = fmaxf(0, clean->pixels[i] * (1 + sigma * normal(&s)));
        }
}

static void test_flip_is_that_without_noise(void **state) {
    (void)state;
    static const struct {
        float error;
        int columns;
    } cases[] = {{0, 0}, {0.03f, SIDE}, {0.1f, SIDE}, {0.15f, SIDE / 4}};
    struct image reference, model;
    struct image_pair a, r;
    assert_int_equal(image_init(&reference, SIDE, SIDE, 3, NULL), STATUS_OK);
    assert_int_equal(image_init(&model, SIDE, SIDE, 3, NULL), STATUS_OK);
    assert_int_equal(image_pair_init(&a, NULL), STATUS_OK);
    assert_int_equal(image_pair_init(&r, NULL), STATUS_OK);
    for (int k = 0; k < 4; k++) {
        fill(&reference, &model, cases[k].error, cases[k].columns);
        struct metrics clean, noisy;
        struct image a_mean, r_mean;
        const float exposure = image_auto_exposure(&reference);
        assert_int_equal(metrics_compute(&clean, &model, &reference, NULL, exposure, NULL), STATUS_OK);
        add_noise(&a, &model, 0.05f, 1);
        add_noise(&r, &reference, 0.2f, 2);
        double flip, noise, black;
        assert_int_equal(image_pair_flip(&a, &r, &flip, &noise, &black, NULL), STATUS_OK);
        assert_int_equal(image_pair_mean(&a, &a_mean, NULL), STATUS_OK);
        assert_int_equal(image_pair_mean(&r, &r_mean, NULL), STATUS_OK);
        assert_int_equal(metrics_compute(&noisy, &a_mean, &r_mean, NULL, exposure, NULL), STATUS_OK);
        print_message("error %.2f in %d columns: FLIP %.4f, with noise %.4f, found %.4f, of noise alone %.4f\n",
                      cases[k].error, cases[k].columns, clean.flip, noisy.flip, flip, noise);
        assert_true(noisy.flip > clean.flip + 0.01);
        // Close where errors are everywhere; where they are few the noise elsewhere is not all taken off.
        const double share = cases[k].columns < SIDE && cases[k].columns > 0 ? 0.6 : 0.15;
        assert_true(flip > clean.flip - 0.15 * (noisy.flip - clean.flip));
        assert_true(flip < clean.flip + share * (noisy.flip - clean.flip));
        assert_true(fabs(noise / noisy.flip - 1) < 0.1 || cases[k].error > 0);
        image_fini(&a_mean);
        image_fini(&r_mean);
    }
    image_fini(&reference);
    image_fini(&model);
    image_pair_fini(&a);
    image_pair_fini(&r);
}

// Sums of a few samples that are mostly dark, as of a lamp's glints.
static float glints(struct sampler *s, int count, float probability) {
    float sum = 0;
    for (int i = 0; i < count; i++) sum += sampler_1d(s) < probability ? 1 / probability : 0;
    return sum / (float)count;
}

static void test_logarithm_of_noisy_values(void **state) {
    (void)state;
    enum { TRIALS = 20000, SAMPLES = 64 };
    double plain = 0, corrected = 0;
    for (uint64_t k = 0; k < TRIALS; k++) {
        struct sampler s = sampler_make(5, 0, k);
        float x0 = glints(&s, SAMPLES, 0.1f), x1 = glints(&s, SAMPLES, 0.1f);
        plain += log1p(0.5 * (x0 + x1)) / TRIALS;
        corrected += log_of_mean(x0, x1) / TRIALS;
    }
    assert_true(log(2) - plain > 5e-3);
    assert_true(fabs(corrected - log(2)) < 0.25 * (log(2) - plain));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_logarithm_of_noisy_values),
        cmocka_unit_test(test_flip_is_that_without_noise),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
