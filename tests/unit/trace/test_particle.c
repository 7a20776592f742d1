// Particles for the baker against the flux they must carry, and splats against the filter they stand for.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>
#include <cmocka.h>

#include "trace/film_sample.h"
#include "trace/particle_exit.h"
#include "trace/splat.h"

static void load_lamp(const char *xml, struct scene *scene) {
    char path[] = "/tmp/sconce_test_particle_XXXXXX.xml";
    struct error error = {0};
    struct run run = {.threads = 1};
    int descriptor = mkstemps(path, 4);
    assert_true(descriptor >= 0);
    FILE *file = fdopen(descriptor, "w");
    fputs(xml, file);
    fclose(file);
    enum status status =
        scene_load(scene, path, &(struct scene_options){.threads = 1, .lamp_only = true}, &run, &error);
    unlink(path);
    if (status != STATUS_OK) fail_msg("%s", error.text);
}

struct tally {
    double mean[3], error[3], min, max; // flux per particle; extremes of the brightness of those that escaped
    size_t escaped;
};

static struct tally trace_lamp(const char *xml, int n, int max_depth) {
    struct scene scene;
    load_lamp(xml, &scene);
    struct tally tally = {.min = INFINITY};
    double sum2[3] = {0};
    for (int i = 0; i < n; i++) {
        struct sampler sampler = sampler_make(3, (uint64_t)i, 0);
        struct particle_exit e;
        trace_particle(&scene, &sampler, max_depth, &e);
        if (e.escaped) {
            double brightness = rgb_max(e.flux);
            tally.escaped++;
            tally.min = fmin(tally.min, brightness);
            tally.max = fmax(tally.max, brightness);
            assert_float_equal(vec3_length(e.direction), 1, 1e-4);
            struct ray ray = {e.point, e.direction, 1e-3f, INFINITY};
            struct surface surface;
            assert_false(scene_intersect(&scene, &ray, -1, &surface)); // left for ever
        } else
            assert_true(rgb_is_black(e.flux));
        const double flux[3] = {e.flux.r, e.flux.g, e.flux.b};
        for (int c = 0; c < 3; c++) {
            tally.mean[c] += flux[c] / n;
            sum2[c] += flux[c] * flux[c] / n;
        }
    }
    for (int c = 0; c < 3; c++) tally.error[c] = sqrt((sum2[c] - tally.mean[c] * tally.mean[c]) / n);
    scene_fini(&scene);
    return tally;
}

#define GLOW(r, g, b) "<emitter type='area'><rgb name='radiance' value='" r " " g " " b "'/></emitter>"
#define BLACK "<bsdf type='diffuse'><rgb name='reflectance' value='0'/></bsdf>"
#define SPHERE(x, radius, body)                                                                                        \
    "<shape type='sphere'><point name='center' x='" x "' y='0' z='0'/><float name='radius' value='" radius "'/>" body  \
    "</shape>"
static const double pi = 3.14159265358979;

static void check_flux(const struct tally *tally, int channel, double expected) {
    if (!(fabs(tally->mean[channel] - expected) <= 4 * tally->error[channel] + 1e-4 * expected))
        fail_msg("channel %d: flux %g, expected %g (standard error %g)", channel, tally->mean[channel], expected,
                 tally->error[channel]);
}

// A diffuse sphere emits pi L over its area.
static void test_flux_of_one(void **unused) {
    (void)unused;
    struct tally tally =
        trace_lamp("<scene version='3.0.0'>" SPHERE("0", "0.5", BLACK GLOW("2", "1", "0.5")) "</scene>", 1000, -1);
    const double radiance[3] = {2, 1, 0.5};
    for (int c = 0; c < 3; c++) assert_true(fabs(tally.mean[c] - radiance[c] * pi * 4 * pi * 0.25) < 1e-3);
    assert_int_equal(tally.escaped, 1000);
}

// Two small spheres far apart, of unlike colour and power.
static void test_flux_by_power(void **unused) {
    (void)unused;
    struct tally tally = trace_lamp("<scene version='3.0.0'>" SPHERE("0", "0.001", BLACK GLOW("2e4", "1e4", "1e4"))
                                        SPHERE("5", "0.003", BLACK GLOW("1e3", "3e4", "1e4")) "</scene>",
                                    40000, -1);
    double a = pi * 4 * pi * 1e-6, b = 9 * a;
    check_flux(&tally, 0, 2e4 * a + 1e3 * b);
    check_flux(&tally, 1, 1e4 * a + 3e4 * b);
    check_flux(&tally, 2, 1e4 * a + 1e4 * b);
}

// Smooth glass loses nothing, whatever the number of inner reflections; weights stay equal.
static void test_glass_keeps_flux(void **unused) {
    (void)unused;
    const char *xml = "<scene version='3.0.0'>" SPHERE(
        "0", "0.2",
        BLACK GLOW(
            "1", "1",
            "1")) "<shape type='sphere'><point name='center' x='0.05' y='0' z='0'/><float name='radius' value='0.4'/>"
                  "<bsdf type='dielectric'><float name='int_ior' value='1.5'/><float name='ext_ior' "
                  "value='1'/></bsdf></shape>"
                  "</scene>";
    struct tally tally = trace_lamp(xml, 20000, -1);
    double emitted = pi * 4 * pi * 0.04;
    assert_true(fabs(tally.min - emitted) < 1e-3 * emitted);
    assert_true(fabs(tally.max - emitted) < 1e-3 * emitted);
    assert_true(tally.mean[0] < emitted && tally.mean[0] > 0.5 * emitted); // light reflected onto the black emitter
}

// Nothing gets out of a closed sphere, and no particle is caught for ever.
static void test_closed(void **unused) {
    (void)unused;
    struct tally tally =
        trace_lamp("<scene version='3.0.0'><shape type='sphere'><boolean name='flip_normals' value='true'/>"
                   "<bsdf type='diffuse'><rgb name='reflectance' value='0.6, 0.3, 0.9'/></bsdf>" GLOW(
                       "1", "1", "1") "</shape></scene>",
                   2000, -1);
    assert_int_equal(tally.escaped, 0);
    assert_float_equal(tally.mean[0], 0, 0);
}

// From a point to a disk of radius 1 parallel to it, h = 1 away, r beside its axis (Howell, B-11 and B-12).
static double disk_factor(double r) { return 0.5 * (1 - r * r / sqrt((r * r + 2) * (r * r + 2) - 4 * r * r)); }

// A glowing disk faces a larger diffuse one: max_depth 1 leaves only what misses it, max_depth 2 adds one bounce, of
// which the black lamp catches its share.
static void test_depth(void **unused) {
    (void)unused;
    const char *xml =
        "<scene version='3.0.0'>"
        "<shape type='disk'><transform name='to_world'><translate z='-1'/></transform>" BLACK GLOW(
            "1", "2", "3") "</shape>"
                           "<shape type='disk'><transform name='to_world'><scale x='2' y='2' z='1'/><rotate x='1' "
                           "angle='180'/></transform><bsdf type='diffuse'><rgb name='reflectance' value='0.8, 0.5, "
                           "0.2'/></bsdf></shape></scene>";
    double arrives = 0, leaves = 0; // of a lamp of radiance 1
    enum { rings = 1000 };
    for (int i = 0; i < rings; i++) {
        double r = 2 * (i + 0.5) / rings, e = pi * disk_factor(r) * 2 * pi * r * 2 / rings;
        arrives += e;
        leaves += e * (1 - disk_factor(r));
    }
    const double rho[3] = {0.8, 0.5, 0.2};
    for (int depth = 1; depth <= 2; depth++) {
        struct tally tally = trace_lamp(xml, 100000, depth);
        for (int c = 0; c < 3; c++)
            check_flux(&tally, c, (c + 1) * (pi * pi - arrives + (depth == 2 ? rho[c] * leaves : 0)));
    }
}

static void test_splats_follow_the_filter(void **unused) {
    (void)unused;
    struct sensor sensor = {.width = 9, .height = 9, .crop_x = 1, .crop_y = 1, .crop_width = 7, .crop_height = 7};
    const float radius[] = {0.5f, 1, 2}, stddev = 0.5f;
    for (int filter = FILM_FILTER_BOX; filter <= FILM_FILTER_GAUSSIAN; filter++) {
        sensor.filter = filter;
        sensor.filter_radius = radius[filter];
        sensor.filter_stddev = stddev;
        enum { n = 200000 };
        struct splat_list list = {0};
        float splatted[49] = {0}, pixels[3 * 49] = {0};
        double expected[49] = {0};
        for (int i = 0; i < n; i++) { // the picture x + 2 over the film, sampled evenly
            struct sampler sampler = sampler_make(1, (uint64_t)i, (uint64_t)filter);
            vec2 p = sampler_2d(&sampler);
            splat_add(&list, &sensor, p, rgb_gray((p.x + 2) * 81 / n));
        }
        splat_merge(&list, 1, 1, pixels, 49, 2);
        for (int i = 0; i < 49; i++) splatted[i] = pixels[3 * i];
        for (int i = 0; i < 49; i++) {
            enum { m = 4000 };
            for (int k = 0; k < m; k++) {
                struct sampler sampler = sampler_make(2, (uint64_t)i, (uint64_t)k);
                vec2 p = film_sample_position(&sensor, 1 + i % 7, 1 + i / 7, sampler_2d(&sampler));
                expected[i] += (p.x >= 0 && p.x < 1 && p.y >= 0 && p.y < 1 ? p.x + 2 : 0) / (double)m;
            }
            assert_true(fabs(splatted[i] - expected[i]) < 0.12 * expected[i] + 1e-3);
        }
        splat_list_fini(&list);
    }
}

static void test_splats_reject_what_is_not_finite(void **unused) {
    (void)unused;
    struct sensor sensor = {.width = 4, .height = 4, .crop_width = 4, .crop_height = 4, .filter_radius = 0.5f};
    struct splat_list list = {0};
    splat_add(&list, &sensor, (vec2){0.5f, 0.5f}, (rgb){NAN, 0, 0});
    splat_add(&list, &sensor, (vec2){0.5f, 0.5f}, (rgb){0, INFINITY, 0});
    splat_add(&list, &sensor, (vec2){1.5f, 0.5f}, rgb_gray(1));
    splat_add(&list, &sensor, (vec2){0.99f, 0.01f}, rgb_gray(1));
    assert_int_equal(list.dropped, 2);
    assert_int_equal(list.count, 1);
    assert_int_equal(list.items[0].pixel, 3);
    splat_list_fini(&list);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_flux_of_one),
                                       cmocka_unit_test(test_flux_by_power),
                                       cmocka_unit_test(test_glass_keeps_flux),
                                       cmocka_unit_test(test_closed),
                                       cmocka_unit_test(test_depth),
                                       cmocka_unit_test(test_splats_follow_the_filter),
                                       cmocka_unit_test(test_splats_reject_what_is_not_finite)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
