// Error measures: closed forms on small images, and FLIP against values of the authors' program (flip_evaluator 1.7),
// recorded by tests/reference/flip.py from the images made below.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <math.h>
#include <string.h>
#include <cmocka.h>

#include "image/metric.h"

enum { WIDTH = 61, HEIGHT = 47 };

static void pair(int flip_case, int x, int y, int c, double *reference, double *image) {
    double phase = 0.13 * x + 0.21 * y + c;
    double noise = ((x * x + 3 * y * y + c * 37) % 101) / 100.0;
    double wave = 2 * sin(0.2 * x * (c + 1));
    switch (flip_case) {
    case 0:
        *reference = 0.5 + 0.5 * sin(phase), *image = 0.5 + 0.5 * sin(phase + 0.3);
        break;
    case 1:
        *reference = 0.8 * ((x / 5 + y / 7) % 2) + 0.1 * c, *image = 0.8 * (((x + 1) / 5 + y / 7) % 2) + 0.1 * c;
        break;
    case 2:
        *reference = noise, *image = 0.9 * noise + 0.05;
        break;
    case 3:
        *reference = c == 1, *image = c == 2;
        break;
    default:
        *reference = wave, *image = wave + 0.3 * cos(0.3 * y);
        break;
    }
}

static const struct { // case, exposure, {mean, map at (0, 0), (30, 20), (60, 46)}
    int flip_case;
    float exposure, values[4];
} flip_recorded[] = {
    {0, 1.0f, {0.460279f, 0.391000f, 0.409903f, 0.502597f}}, {1, 1.0f, {0.349518f, 0.028674f, 0.291355f, 0.625270f}},
    {2, 1.0f, {0.059449f, 0.161232f, 0.031746f, 0.142407f}}, {3, 1.0f, {1.000000f, 1.000000f, 1.000000f, 1.000000f}},
    {4, 0.7f, {0.204860f, 0.581090f, 0.257003f, 0.065923f}},
};

static void test_flip(void **state) {
    (void)state;
    struct image image, reference, map;
    assert_int_equal(image_init(&image, WIDTH, HEIGHT, 3, NULL), STATUS_OK);
    assert_int_equal(image_init(&reference, WIDTH, HEIGHT, 4, NULL), STATUS_OK); // a further channel changes nothing
    for (size_t k = 0; k < sizeof flip_recorded / sizeof *flip_recorded; ++k) {
        for (int i = 0; i < WIDTH * HEIGHT * 3; ++i) {
            double r, a;
            pair(flip_recorded[k].flip_case, i / 3 % WIDTH, i / 3 / WIDTH, i % 3, &r, &a);
            reference.pixels[i / 3 * 4 + i % 3] = (float)r;
            image.pixels[i] = (float)a;
        }
        assert_int_equal(flip_map(&map, &image, &reference, flip_recorded[k].exposure, NULL), STATUS_OK);
        double sum = 0;
        for (int i = 0; i < WIDTH * HEIGHT; ++i) sum += map.pixels[i];
        const float *values = flip_recorded[k].values;
        assert_float_equal(sum / (WIDTH * HEIGHT), values[0], 1e-4);
        assert_float_equal(map.pixels[0], values[1], 1e-4);
        assert_float_equal(map.pixels[20 * WIDTH + 30], values[2], 1e-4);
        assert_float_equal(map.pixels[46 * WIDTH + 60], values[3], 1e-4);
        image_fini(&map);
        assert_int_equal(flip_map(&map, &image, &image, 1, NULL), STATUS_OK);
        for (int i = 0; i < WIDTH * HEIGHT; ++i) assert_float_equal(map.pixels[i], 0, 0);
        image_fini(&map);
    }
    image_fini(&image);
    image_fini(&reference);
}

static void fill(struct image *image, float r, float g, float b) {
    for (int i = 0; i < image->width * image->height; ++i) {
        image->pixels[3 * i] = r, image->pixels[3 * i + 1] = g, image->pixels[3 * i + 2] = b;
    }
}

static void test_closed_forms(void **state) {
    (void)state;
    struct image image, reference;
    struct metrics m;
    assert_int_equal(image_init(&image, 8, 8, 3, NULL), STATUS_OK);
    assert_int_equal(image_init(&reference, 8, 8, 3, NULL), STATUS_OK);
    fill(&reference, 1, 2, 4);
    fill(&image, 1.5f, 2, 3);
    assert_int_equal(metrics_compute(&m, &image, &reference, NULL, 0.2f, NULL), STATUS_OK);
    assert_int_equal(m.pixel_count, 64);
    assert_float_equal(m.mse, 1.25 / 3, 1e-6);
    assert_float_equal(m.psnr_db, (float)(10 * log10(16 / (1.25 / 3))), 1e-5);
    assert_float_equal(m.rel_mse, (0.25 / 1.001 + 1 / 16.001) / 3, 1e-6);
    double log_mse = (pow(log(2.5) - log(2), 2) + pow(log(4) - log(5), 2)) / 3;
    assert_float_equal(m.psnr_log_db, (float)(10 * log10(log(5) * log(5) / log_mse)), 1e-5);
    assert_float_equal(m.mean_ratio[0], 1.5, 1e-6);
    assert_float_equal(m.mean_ratio[1], 1, 1e-6);
    assert_float_equal(m.mean_ratio[2], 0.75, 1e-6);
    assert_float_equal(m.block_error_max, 0.5 / 7, 1e-6);
    assert_float_equal(m.block_error_mean, 0.5 / 7, 1e-6);
    fill(&image, 1, 2, 4); // one block of 2 x 2 pixels twice as bright
    for (int y = 2; y < 4; ++y) {
        for (int x = 6; x < 8; ++x) {
            for (int c = 0; c < 3; ++c) image.pixels[(y * 8 + x) * 3 + c] *= 2;
        }
    }
    assert_int_equal(metrics_compute(&m, &image, &reference, NULL, 0.2f, NULL), STATUS_OK);
    assert_float_equal(m.block_error_max, 1, 1e-6);
    assert_float_equal(m.block_error_mean, 1.0 / 16, 1e-6);
    assert_true(m.flip > 0);
    assert_int_equal(metrics_compute(&m, &reference, &reference, NULL, 0.2f, NULL), STATUS_OK);
    assert_true(isinf(m.psnr_db) && m.mse == 0 && m.flip == 0);
    image_fini(&image);
    image_fini(&reference);
}

// The mask leaves only the left half; what the right half holds must not matter to any measure but FLIP, whose filters
// reach 10 pixels: there only the pixels that are averaged are the mask's.
static void test_mask(void **state) {
    (void)state;
    struct image image, reference, mask, map;
    struct metrics m;
    struct error error;
    assert_int_equal(image_init(&image, 40, 8, 3, NULL), STATUS_OK);
    assert_int_equal(image_init(&reference, 40, 8, 3, NULL), STATUS_OK);
    assert_int_equal(image_init(&mask, 40, 8, 1, NULL), STATUS_OK);
    fill(&reference, 0.5f, 0.5f, 0.5f);
    fill(&image, 0.5f, 0.5f, 0.5f);
    double flip = 0;
    for (int i = 0; i < 320; ++i) {
        bool left = i % 40 < 20;
        mask.pixels[i] = left ? 0.51f : 0.5f;
        image.pixels[3 * i] = left ? 0.6f : 9;
    }
    assert_int_equal(flip_map(&map, &image, &reference, 1, NULL), STATUS_OK);
    for (int i = 0; i < 320; ++i) flip += i % 40 < 20 ? (double)map.pixels[i] / 160 : 0;
    assert_int_equal(metrics_compute(&m, &image, &reference, &mask, 1, NULL), STATUS_OK);
    assert_int_equal(m.pixel_count, 160);
    assert_float_equal(m.mse, 0.01 / 3, 1e-6);
    assert_float_equal(m.mean_ratio[0], 1.2, 1e-5);
    assert_float_equal(m.block_error_mean, 0.2 / 3, 1e-5);
    assert_float_equal(m.flip, flip, 1e-6);
    for (int i = 0; i < 320; ++i) mask.pixels[i] = 0;
    assert_int_equal(metrics_compute(&m, &image, &reference, &mask, 1, &error), STATUS_INVALID);
    image.pixels[3 * (2 * 40 + 7) + 1] = NAN;
    assert_int_equal(metrics_compute(&m, &image, &reference, NULL, 1, &error), STATUS_INVALID);
    assert_non_null(strstr(error.text, "(7, 2)"));
    image_fini(&mask);
    assert_int_equal(image_init(&mask, 8, 40, 1, NULL), STATUS_OK);
    assert_int_equal(metrics_compute(&m, &image, &reference, &mask, 1, &error), STATUS_INVALID);
    image_fini(&map);
    image_fini(&mask);
    image_fini(&image);
    image_fini(&reference);
}

static void test_auto_exposure(void **state) {
    (void)state;
    struct image image;
    assert_int_equal(image_init(&image, 101, 1, 3, NULL), STATUS_OK);
    assert_float_equal(image_auto_exposure(&image), 1, 0); // black
    for (int i = 0; i < 101; ++i)
        image.pixels[3 * i] = image.pixels[3 * i + 1] = image.pixels[3 * i + 2] = (float)(100 - i + 10);
    assert_float_equal(image_auto_exposure(&image), 0.8f / 100, 1e-6f);
    image_fini(&image);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_flip),
        cmocka_unit_test(test_closed_forms),
        cmocka_unit_test(test_mask),
        cmocka_unit_test(test_auto_exposure),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
