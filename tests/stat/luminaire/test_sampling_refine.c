// The sampling density made anew from the light field of a baked lamp: samples and densities still agree, the light
// that they estimate is the same with less noise, and threads do not matter.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>
#include <cmocka.h>

#include "luminaire/luminaire_private.h"
#include "luminaire/sampling.h"
#include "math/sampler.h"
#include "math/warp.h"

enum { POINTS = 96, SAMPLES = 4096 };

struct estimate {
    double mean, variance, mass; // of L cos / p; relative; integral of the density by uniform directions
};

static struct estimate estimate_at(const struct luminaire *lamp, size_t index) {
    static float s[SAMPLES][3], u[SAMPLES][3], direction[SAMPLES][3], w[SAMPLES][3], radiance[SAMPLES][3], pdf[SAMPLES];
    struct sampler sampler = sampler_make(5, 1, index);
    float center[3], radius;
    luminaire_bounds(lamp, center, &radius);
    const vec3 out = warp_uniform_sphere(sampler_2d(&sampler));
    const float distance = 1.2f * powf(10, sampler_1d(&sampler));
    const vec3 p = vec3_mad(out, distance * radius, (vec3){center[0], center[1], center[2]});
    for (size_t i = 0; i < SAMPLES; i++) {
        vec3_store(s[i], p);
        for (int c = 0; c < 3; c++) u[i][c] = sampler_1d(&sampler);
    }
    luminaire_sample(lamp, SAMPLES, (const float(*)[3])s, (const float(*)[3])u, direction, pdf);
    for (size_t i = 0; i < SAMPLES; i++)
        for (int c = 0; c < 3; c++) w[i][c] = -direction[i][c];
    luminaire_eval(lamp, SAMPLES, (const float(*)[3])s, (const float(*)[3])w, radiance);
    struct estimate estimate = {0};
    double square = 0;
    for (size_t i = 0; i < SAMPLES; i++) {
        const float cosine = fmaxf(-vec3_dot((vec3){direction[i][0], direction[i][1], direction[i][2]}, out), 0);
        const double x = (double)((radiance[i][0] + radiance[i][1] + radiance[i][2]) * cosine / pdf[i]);
        estimate.mean += x / SAMPLES;
        square += x * x / SAMPLES;
    }
    estimate.variance = square / (estimate.mean * estimate.mean) - 1;
    const struct frame frame = frame_from_normal(vec3_neg(out));
    const float cos_max = sqrtf(1 - 1 / sqrf(distance));
    for (size_t i = 0; i < SAMPLES; i++)
        vec3_store(direction[i], frame_world_from_local(&frame, warp_uniform_cone((vec2){u[i][0], u[i][1]}, cos_max)));
    luminaire_pdf(lamp, SAMPLES, (const float(*)[3])s, (const float(*)[3])direction, pdf);
    for (size_t i = 0; i < SAMPLES; i++) estimate.mass += (double)(pdf[i] / warp_uniform_cone_pdf(cos_max)) / SAMPLES;
    return estimate;
}

static struct luminaire *load(void) {
    struct luminaire *lamp;
    struct error error;
    assert_int_equal(luminaire_load(&lamp, SOURCE_DIR "/lamps/baked/blossom_lamp.safetensors", &error), STATUS_OK);
    return lamp;
}

static void refine(struct luminaire *lamp, size_t lines, int threads) {
    struct error error;
    const struct sampling_refinement plan = {.lines = lines, .seed = 3, .threads = threads};
    assert_int_equal(
        sampling_density_refine(&lamp->emissions[0].density, lamp->emissions[0].light, &lamp->shape, &plan, &error),
        STATUS_OK);
}

static void test_less_noise(void **unused) {
    (void)unused;
    struct luminaire *lamp = load();
    // In place of what the file has: built from nothing, so it knows no direction from another.
    struct error error;
    sampling_density_destroy(lamp->emissions[0].density);
    assert_int_equal(
        sampling_density_build(&lamp->emissions[0].density, &lamp->shape.proxy, NULL, 0, NULL, 0, 1, 1, &error),
        STATUS_OK);
    static struct estimate before[POINTS], after[POINTS];
    for (size_t i = 0; i < POINTS; i++) before[i] = estimate_at(lamp, i);
    refine(lamp, 2000000, 2);
    double variance_before = 0, variance_after = 0, worst = 0;
    for (size_t i = 0; i < POINTS; i++) {
        after[i] = estimate_at(lamp, i);
        variance_before += before[i].variance / POINTS;
        variance_after += after[i].variance / POINTS;
        const double noise = sqrt((before[i].variance + after[i].variance) / SAMPLES) * before[i].mean;
        worst = fmax(worst, fabs(after[i].mean - before[i].mean) / noise);
        assert_true(fabs(after[i].mass - 1) < 0.25); // sharp cones are met by few uniform directions
    }
    print_message("variance %.2f -> %.2f, means differ by %.1f standard deviations at most\n", variance_before,
                  variance_after, worst);
    assert_true(variance_after < 0.1 * variance_before);
    assert_true(variance_after < 3);
    assert_true(worst < 6);
    luminaire_destroy(lamp);
}

static void test_threads_do_not_matter(void **unused) {
    (void)unused;
    struct luminaire *one = load(), *many = load();
    refine(one, 600000, 1);
    refine(many, 600000, 3);
    const struct sampling_density *a = one->emissions[0].density, *b = many->emissions[0].density;
    assert_memory_equal(a->codes, b->codes, sampling_cell_count(a) * MAP_BYTES);
    assert_memory_equal(a->residual_share, b->residual_share, sampling_cell_count(a));
    assert_memory_equal(a->intensity, b->intensity, (size_t)a->anchor_count * INTENSITY_CELLS * sizeof(float));
    luminaire_destroy(one);
    luminaire_destroy(many);
}

static void test_no_lines(void **unused) {
    (void)unused;
    struct luminaire *lamp = load();
    const struct sampling_density *before = lamp->emissions[0].density;
    refine(lamp, 0, 2);
    assert_ptr_equal(before, lamp->emissions[0].density);
    luminaire_destroy(lamp);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_less_noise), cmocka_unit_test(test_threads_do_not_matter),
                                       cmocka_unit_test(test_no_lines)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
