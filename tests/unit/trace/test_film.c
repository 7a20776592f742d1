// The film against sums computed directly, and the reconstruction filters against their own variance.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>
#include <cmocka.h>

#include "math/sampler.h"
#include "trace/film.h"
#include "trace/film_sample.h"

static void test_mean_and_variance(void **unused) {
    (void)unused;
    enum { WIDTH = 5, HEIGHT = 3, PASSES = 7 };
    struct sensor sensor = {.width = 9, .height = 9, .crop_width = WIDTH, .crop_height = HEIGHT};
    struct film film;
    struct error error;
    assert_int_equal(film_init(&film, &sensor, &error), STATUS_OK);
    static double values[PASSES][WIDTH * HEIGHT * 3];
    for (int pass = 0; pass < PASSES; pass++) {
        struct sampler sampler = sampler_make(1, 2, pass);
        for (int i = 0; i < WIDTH * HEIGHT * 3; i++) {
            assert_true(film.pass[i] == 0);
            film.pass[i] = 1000 + sampler_1d(&sampler);
            values[pass][i] = film.pass[i];
        }
        film_end_pass(&film, 2);
    }
    struct image image;
    assert_int_equal(film_image(&film, &image, &error), STATUS_OK);
    assert_int_equal(image.channels, 6);
    assert_string_equal(image.channel_names[4], "variance.G");
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        for (int c = 0; c < 3; c++) {
            double mean = 0, square = 0;
            for (int pass = 0; pass < PASSES; pass++) mean += values[pass][3 * i + c] / PASSES;
            for (int pass = 0; pass < PASSES; pass++)
                square += (values[pass][3 * i + c] - mean) * (values[pass][3 * i + c] - mean);
            assert_float_equal(image.pixels[6 * i + c], mean, 1e-3);
            assert_float_equal(image.pixels[6 * i + 3 + c], square / (PASSES - 1) / PASSES, 1e-6);
        }
    }
    image_fini(&image);
    film_fini(&film);
}

static void test_one_pass_has_no_variance(void **unused) {
    (void)unused;
    struct sensor sensor = {.width = 1, .height = 1, .crop_width = 1, .crop_height = 1};
    struct film film;
    struct image image;
    assert_int_equal(film_init(&film, &sensor, NULL), STATUS_OK);
    film.pass[1] = 4;
    film_end_pass(&film, 1);
    assert_int_equal(film_image(&film, &image, NULL), STATUS_OK);
    assert_float_equal(image.pixels[1], 4, 0);
    assert_float_equal(image.pixels[4], 0, 0);
    image_fini(&image);
    film_fini(&film);
}

static void test_impossible_sizes(void **unused) {
    (void)unused;
    struct film film;
    struct error error;
    struct sensor empty = {.crop_width = 0, .crop_height = 4},
                  huge = {.crop_width = 2000000000, .crop_height = 2000000000};
    assert_int_equal(film_init(&film, &empty, &error), STATUS_INVALID);
    assert_int_not_equal(film_init(&film, &huge, &error), STATUS_OK);
}

static void test_filters(void **unused) {
    (void)unused;
    enum { N = 20000 };
    struct sensor sensors[3] = {{.filter = FILM_FILTER_BOX, .filter_radius = 0.5f},
                                {.filter = FILM_FILTER_TENT, .filter_radius = 1},
                                {.filter = FILM_FILTER_GAUSSIAN, .filter_radius = 2, .filter_stddev = 0.5f}};
    const double variance[3] = {1.0 / 12, 1.0 / 6, 0.25}, tolerance[3] = {1e-3, 1e-3, 1e-2};
    for (int f = 0; f < 3; f++) {
        double first = 0, second = 0;
        for (int i = 0; i < N; i++) {
            double offset = film_filter_offset(&sensors[f], ((float)i + 0.5f) / N);
            assert_true(fabs(offset) <= sensors[f].filter_radius * 1.0001);
            first += offset / N;
            second += offset * offset / N;
        }
        assert_float_equal(first, 0, 1e-3);
        assert_float_equal(second, variance[f], tolerance[f]);
    }
    sensors[0].width = 10;
    sensors[0].height = 20;
    vec2 p = film_sample_position(&sensors[0], 3, 7, (vec2){0.25f, 0.75f});
    assert_float_equal(p.x, 0.325, 1e-6);
    assert_float_equal(p.y, 7.75 / 20, 1e-6);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_mean_and_variance),
                                       cmocka_unit_test(test_one_pass_has_no_variance),
                                       cmocka_unit_test(test_impossible_sizes), cmocka_unit_test(test_filters)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
