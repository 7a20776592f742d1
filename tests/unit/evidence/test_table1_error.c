// The separation of bias from noise, on pictures whose bias and noise are known because they are made here.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <math.h>
#include <cmocka.h>

#include "evidence/table1_error.h"
#include "math/sampler.h"

enum { SIZE = 64, VALUES = 3 * SIZE * SIZE };

static double normal(uint64_t seed, uint64_t value) { // Box and Muller
    struct sampler sampler = sampler_make(seed, value, 0);
    vec2 u = sampler_2d(&sampler);
    return sqrt(-2 * log(1 - (double)u.x)) * cos(6.283185307179586 * (double)u.y);
}

static double truth(size_t value) { return 0.2 + 0.15 * sin(0.01 * (double)value); }

// truth * (1 + bias) with normal noise of a standard deviation relative to the truth.
static struct image picture(double bias, double deviation, uint64_t seed) {
    struct image image;
    assert_int_equal(image_init(&image, SIZE, SIZE, 3, NULL), STATUS_OK);
    for (size_t i = 0; i < VALUES; i++)
        image.pixels[i] = (float)(truth(i) * (1 + bias * (i % 2 ? 1 : -1) + deviation * normal(seed, i)));
    return image;
}

static struct error_parts split(double bias, double deviation, double reference_deviation, uint64_t seed,
                                const struct image *mask) {
    struct image pictures[2], references[2];
    for (uint64_t half = 0; half < 2; half++) {
        pictures[half] = picture(bias, deviation, 4 * seed + half);
        references[half] = picture(0, reference_deviation, 4 * seed + 2 + half);
    }
    struct error_parts parts = error_split((const struct image *[]){&pictures[0], &pictures[1]},
                                           (const struct image *[]){&references[0], &references[1]}, mask);
    for (int half = 0; half < 2; half++) {
        image_fini(&pictures[half]);
        image_fini(&references[half]);
    }
    return parts;
}

static double weight_mean(void) { // of t^2 / (t^2 + 1e-3): what a relative error of 1 scores
    double sum = 0;
    for (size_t i = 0; i < VALUES; i++) sum += truth(i) * truth(i) / (truth(i) * truth(i) + 1e-3);
    return sum / VALUES;
}

static void test_parts_are_found(void **state) {
    (void)state;
    const double unit = weight_mean();
    static const struct {
        double bias, deviation, reference;
    } cases[] = {{0.03, 0.05, 0.02}, {0.05, 0.2, 0.05}, {0.02, 0.02, 0}, {0.1, 0, 0}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        const double bias = cases[i].bias, deviation = cases[i].deviation, reference = cases[i].reference;
        struct error_parts parts = split(bias, deviation, reference, i + 1, NULL);
        assert_true(fabs(parts.bias - bias * bias * unit) < 4 * parts.bias_error + 0.01 * bias * bias);
        // Two renderings of this deviation: their mean has half the variance.
        assert_true(fabs(parts.noise - 0.5 * deviation * deviation * unit) <= 0.05 * deviation * deviation);
        assert_true(fabs(parts.reference_noise - 0.5 * reference * reference * unit) <= 0.05 * reference * reference);
    }
}

// Its standard error is as large as it says, with and without bias: z over many pairs has a variance near 1.
static void test_the_standard_error_of_the_bias(void **state) {
    (void)state;
    enum { TRIALS = 60 };
    for (int with_bias = 0; with_bias < 2; with_bias++) {
        const double bias = 0.03 * with_bias, expected = bias * bias * weight_mean();
        double sum = 0, squares = 0;
        for (uint64_t trial = 0; trial < TRIALS; trial++) {
            struct error_parts parts = split(bias, 0.1, 0.05, 100 + trial, NULL);
            double z = (parts.bias - expected) / parts.bias_error;
            sum += z, squares += z * z;
        }
        assert_true(fabs(sum / TRIALS) < 4 / sqrt(TRIALS));
        assert_true(squares / TRIALS > 0.4 && squares / TRIALS < 2);
    }
}

static void test_masked_pixels_do_not_count(void **state) {
    (void)state;
    struct image mask;
    assert_int_equal(image_init(&mask, SIZE, SIZE, 1, NULL), STATUS_OK);
    struct error_parts none = split(0.1, 0.1, 0.1, 7, &mask);
    assert_true(none.bias == 0 && none.noise == 0 && none.reference_noise == 0);
    for (size_t i = 0; i < SIZE * SIZE; i++) mask.pixels[i] = 1;
    struct error_parts all = split(0.1, 0.1, 0.1, 7, &mask), plain = split(0.1, 0.1, 0.1, 7, NULL);
    assert_true(all.bias == plain.bias && all.noise == plain.noise);
    image_fini(&mask);
}

static void test_share_of_the_worst_pixels(void **state) {
    (void)state;
    struct image reference = picture(0, 0, 1), plain = picture(0.1, 0, 2);
    const double even = error_share_of_worst(&plain, &reference, NULL, false);
    assert_true(even > 0.001 && even < 0.002); // 5 of 4096 pixels, all alike
    plain.pixels[3000] += 100;
    assert_true(error_share_of_worst(&plain, &reference, NULL, false) > 0.99);
    assert_true(isnan(error_share_of_worst(&reference, &reference, NULL, false)));
    struct image mask;
    assert_int_equal(image_init(&mask, SIZE, SIZE, 1, NULL), STATUS_OK);
    for (size_t i = 0; i < SIZE * SIZE; i++) mask.pixels[i] = 1;
    assert_true(error_share_of_worst(&plain, &reference, &mask, true) > 0.99);
    size_t count = 0;
    for (size_t i = 0; i < SIZE * SIZE; i++) count += mask.pixels[i] > 0;
    assert_true(count >= SIZE * SIZE - 5 && count < SIZE * SIZE && mask.pixels[1000] == 0); // the firefly among them
    assert_true(error_share_of_worst(&plain, &reference, &mask, false) < 0.01);
    image_fini(&mask);
    image_fini(&reference);
    image_fini(&plain);
}

static void test_samples_to_an_error(void **state) {
    (void)state;
    assert_true(fabs(error_samples(0.5, 0, 0.05) - 10) < 1e-12);
    assert_true(fabs(error_samples(0.5, 0.03, 0.05) - 25) < 1e-9);
    assert_true(isinf(error_samples(0.5, 0.05, 0.05)));
    assert_true(isinf(error_samples(0.5, 0.06, 0.05)));
    // Measured from the pictures: renderings of one sample, the error of 4 of them asked for.
    const double bias = 0.03, deviation = 0.2, unit = weight_mean();
    struct error_parts parts = split(bias, deviation, 0.02, 9, NULL);
    double samples = error_samples(2 * parts.noise, parts.bias, (bias * bias + deviation * deviation / 4) * unit);
    assert_true(samples > 3.5 && samples < 4.5);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_parts_are_found), cmocka_unit_test(test_the_standard_error_of_the_bias),
        cmocka_unit_test(test_masked_pixels_do_not_count), cmocka_unit_test(test_samples_to_an_error),
        cmocka_unit_test(test_share_of_the_worst_pixels)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
