// Single lines against closed forms: radiance of a plate under a glowing sphere with and without aims, Fresnel and
// Beer's law for the transparency.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>
#include <cmocka.h>

#include "trace/line_radiance.h"

static void load(struct scene *scene, const char *shapes) {
    char path[] = "/tmp/sconce_test_line_XXXXXX.xml";
    int descriptor = mkstemps(path, 4);
    assert_true(descriptor >= 0);
    FILE *file = fdopen(descriptor, "w");
    fprintf(file, "<scene version='3.0.0'>%s</scene>", shapes);
    fclose(file);
    struct error error = {0};
    struct run run = {.threads = 1, .seed = 7};
    enum status status =
        scene_load(scene, path, &(struct scene_options){.threads = 1, .lamp_only = true}, &run, &error);
    unlink(path);
    if (status != STATUS_OK) fail_msg("%s", error.text);
}

static const char *const plate_under_sphere =
    "<shape type='rectangle'><bsdf type='diffuse'><rgb name='reflectance' value='0.5'/></bsdf></shape>"
    "<shape type='sphere'><point name='center' x='0' y='0' z='1'/><float name='radius' value='0.3'/>"
    "<bsdf type='diffuse'><rgb name='reflectance' value='0'/></bsdf>"
    "<emitter type='area'><rgb name='radiance' value='2'/></emitter></shape>";

static void check_plate(const struct aim *aims, size_t aim_count, int n) {
    struct scene scene;
    load(&scene, plate_under_sphere);
    vec3 target = {0.5f, 0, 0}, origin = {3, 0, 1};
    struct ray ray = {origin, vec3_normalize(vec3_sub(target, origin)), 0, INFINITY};
    double sum = 0, square = 0;
    for (int i = 0; i < n; i++) {
        struct sampler sampler = sampler_make(5, 1, i);
        struct line_hit hit;
        trace_line_radiance(&scene, &ray, &sampler, aims, aim_count, -1, &hit);
        assert_true(hit.hit);
        assert_float_equal(hit.distance, sqrt(2.5 * 2.5 + 1), 1e-4);
        sum += hit.radiance.g / n;
        square += hit.radiance.g * hit.radiance.g / n;
    }
    double d2 = 0.25 + 1, expected = 0.5 * 2 * 0.09 / d2 / sqrt(d2);
    double error = sqrt((square - sum * sum) / n);
    assert_true(error < 0.02 * expected);
    assert_float_equal(sum, expected, 4 * error);
    scene_fini(&scene);
}

static void test_radiance(void **unused) {
    (void)unused;
    const struct aim aims[3] = {{{0, 0, 1}, 0.3f}, {{0.1f, 0, 1.1f}, 0.4f}, {{2, 0, 0.5f}, 0.2f}};
    check_plate(NULL, 0, 200000);
    check_plate(aims, 1, 20000);
    check_plate(aims, 3, 40000);
}

// Between two concentric spheres, the inner one black and glowing, the outer one white: with F the share of the outer
// one's light that the inner one takes, its area over the outer one's, E = emission * F / (1 - white * (1 - F)).
static void test_white_walls(void **unused) {
    (void)unused;
    struct scene scene;
    load(&scene,
         "<shape type='sphere'><float name='radius' value='2'/>"
         "<bsdf type='twosided'><bsdf type='diffuse'><rgb name='reflectance' value='0.9'/></bsdf></bsdf></shape>"
         "<shape type='sphere'><float name='radius' value='0.2'/>"
         "<bsdf type='diffuse'><rgb name='reflectance' value='0'/></bsdf>"
         "<emitter type='area'><rgb name='radiance' value='2'/></emitter></shape>");
    const struct aim aim = {{0, 0, 0}, 0.21f};
    struct ray ray = {{1, 0, 0}, {0.6f, 0.8f, 0}, 0, INFINITY};
    enum { N = 100000 };
    double sum = 0, square = 0;
    for (int i = 0; i < N; i++) {
        struct sampler sampler = sampler_make(5, 2, i);
        struct line_hit hit;
        trace_line_radiance(&scene, &ray, &sampler, &aim, 1, -1, &hit);
        sum += hit.radiance.g / N;
        square += hit.radiance.g * hit.radiance.g / N;
    }
    double f = 0.01, expected = 0.9 * 2 * f / (1 - 0.9 * (1 - f)), error = sqrt((square - sum * sum) / N);
    assert_float_equal(sum, expected, 4 * error);
    assert_true(square - sum * sum < 3 * sum * sum); // a path's weight stays bounded over many bounces
    scene_fini(&scene);
}

// A glowing plate behind a slab of glass: (1 - F) / (1 + F) of it over all reflections within. With both ways of the
// first surfaces followed the mean is the same, and what is left to chance is small.
static void test_split_glass(void **unused) {
    (void)unused;
    struct scene scene;
    load(&scene,
         "<shape type='cube'><transform name='to_world'><scale x='50' y='50' z='0.1'/></transform>"
         "<bsdf type='dielectric'><float name='int_ior' value='1.5'/><float name='ext_ior' value='1'/></bsdf></shape>"
         "<shape type='rectangle'><transform name='to_world'><scale value='60'/><translate z='-2'/></transform>"
         "<bsdf type='diffuse'><rgb name='reflectance' value='0'/></bsdf>"
         "<emitter type='area'><rgb name='radiance' value='2'/></emitter></shape>");
    const double in = 1.2, out = asin(sin(in) / 1.5), rs = sin(in - out) / sin(in + out),
                 rp = tan(in - out) / tan(in + out), f = 0.5 * (rs * rs + rp * rp);
    const double expected = 2 * (1 - f) / (1 + f);
    struct ray ray = {{0, 0, 1}, {(float)sin(in), 0, (float)-cos(in)}, 0, INFINITY};
    enum { N = 20000 };
    double variance[2];
    for (int split = 0; split < 2; split++) {
        double sum = 0, square = 0;
        for (int i = 0; i < N; i++) {
            struct sampler sampler = sampler_make(5, 3, i);
            struct line_hit hit;
            trace_line_radiance_split(&scene, &ray, &sampler, NULL, 0, -1, split ? 4 : 0, &hit);
            sum += hit.radiance.g / N;
            square += hit.radiance.g * hit.radiance.g / N;
        }
        variance[split] = square - sum * sum;
        assert_float_equal(sum, expected, 4 * sqrt(variance[split] / N) + 1e-4);
    }
    assert_true(variance[1] < 0.01 * variance[0]);
    scene_fini(&scene);
}

static void test_emitter_and_miss(void **unused) {
    (void)unused;
    struct scene scene;
    load(&scene, plate_under_sphere);
    struct sampler sampler = sampler_make(1, 1, 1);
    struct line_hit hit;
    struct ray to_sphere = {{0, 0, 4}, {0, 0, -1}, 0, INFINITY}, past = {{0, 0, 4}, {0, 0, 1}, 0, INFINITY};
    trace_line_radiance(&scene, &to_sphere, &sampler, NULL, 0, 1, &hit);
    assert_float_equal(hit.radiance.r, 2, 1e-5);
    assert_float_equal(hit.distance, 2.7, 1e-4);
    trace_line_radiance(&scene, &past, &sampler, NULL, 0, -1, &hit);
    assert_false(hit.hit);
    assert_true(rgb_is_black(hit.radiance));
    assert_float_equal(trace_line_transmittance(&scene, &past, &sampler, -1, 0.9f).g, 1, 0);
    assert_float_equal(trace_line_transmittance(&scene, &to_sphere, &sampler, -1, 0.9f).g, 0, 0);
    scene_fini(&scene);
}

static double transmittance(const char *shapes, vec3 origin, vec3 direction, float cos_limit) {
    struct scene scene;
    load(&scene, shapes);
    struct ray ray = {origin, direction, 0, INFINITY};
    enum { N = 50000 };
    double sum = 0;
    for (int i = 0; i < N; i++) {
        struct sampler sampler = sampler_make(5, 1, i);
        sum += trace_line_transmittance(&scene, &ray, &sampler, 20, cos_limit).g / N;
    }
    scene_fini(&scene);
    return sum;
}

#define GLOW                                                                                                           \
    "<shape type='sphere'><point name='center' x='50' y='0' z='0'/><float name='radius' value='0.1'/>"                 \
    "<emitter type='area'><rgb name='radiance' value='1'/></emitter></shape>"

static void test_transmittance(void **unused) {
    (void)unused;
    const char *ball = "<shape type='sphere'><bsdf type='dielectric'><float name='int_ior' value='1.5'/>"
                       "<float name='ext_ior' value='1'/></bsdf></shape>" GLOW;
    assert_float_equal(transmittance(ball, (vec3){0, 0, 3}, (vec3){0, 0, -1}, 0.9f), 0.96 * 0.96, 0.006);
    assert_float_equal(transmittance(ball, (vec3){0.9f, 0, 3}, (vec3){0, 0, -1}, 0.9f), 0, 0); // turned by 54 degrees
    assert_true(transmittance(ball, (vec3){0.9f, 0, 3}, (vec3){0, 0, -1}, 0) > 0.5);
    const char *mask =
        "<shape type='rectangle'><bsdf type='mask'><float name='opacity' value='0.3'/><bsdf type='diffuse'/>"
        "</bsdf></shape>" GLOW;
    assert_float_equal(transmittance(mask, (vec3){0, 0, 3}, (vec3){0, 0, -1}, 0.9f), 0.7, 0.01);
    const char *mirror = "<shape type='rectangle'><bsdf type='conductor'/></shape>" GLOW;
    assert_float_equal(transmittance(mirror, (vec3){0, 0, 3}, (vec3){0, 0, -1}, 0.01f), 0, 0);
    assert_float_equal(transmittance(mirror, (vec3){0, 0, 3}, (vec3){0, 0, -1}, 0), 0, 0); // back, not onward
    assert_float_equal(transmittance(mirror, (vec3){0, 0, 3}, (vec3){0, 0, -1}, -1), 1, 0); // all that leaves
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_radiance), cmocka_unit_test(test_white_walls),
                                       cmocka_unit_test(test_split_glass), cmocka_unit_test(test_emitter_and_miss),
                                       cmocka_unit_test(test_transmittance)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
