// The path tracer against closed forms: irradiance of a sphere and of a rectangle, the white furnace with every
// max_depth, a constant sky, masks that are no vertices; and against itself for any number of threads.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#include "render_path.h"

static size_t render(const char *xml, enum path_strategy strategy, int passes, int threads, struct rendering *result) {
    size_t dropped;
    render_path(xml, &(struct path_test){strategy, passes, threads, .seed = 7}, result, &dropped);
    return dropped;
}

#define CAMERA(origin, target, fov, size)                                                                              \
    "<sensor type='perspective'><float name='fov' value='" fov "'/><transform name='to_world'><lookat origin='" origin \
    "' target='" target "' up='0,0,1'/></transform><film type='hdrfilm'><integer name='width' value='" size            \
    "'/><integer name='height' value='" size "'/><rfilter type='box'/></film></sensor>"
#define DIFFUSE(value) "<bsdf type='diffuse'><rgb name='reflectance' value='" value "'/></bsdf>"
#define FLOOR                                                                                                          \
    "<shape type='rectangle'><transform name='to_world'><scale x='20' y='20' z='1'/></transform>" DIFFUSE(             \
        "0.5") "</shape>"

static void check_mean(const char *xml, enum path_strategy strategy, int passes, double expected, double tolerance) {
    struct rendering result;
    assert_int_equal(render(xml, strategy, passes, 1, &result), 0);
    image_fini(&result.image);
    double slack = tolerance * expected + 4 * result.error[1];
    if (fabs(result.mean[1] - expected) > slack)
        fail_msg("mean %g, expected %g (standard error %g)", result.mean[1], expected, result.error[1]);
    assert_true(result.error[1] < 0.05 * expected + 1e-6); // else the comparison says nothing
}

// A sphere wholly above the horizon: E = pi L (r / d)^2 cos.
static void test_sphere_irradiance(void **unused) {
    (void)unused;
    const char *xml =
        "<scene version='3.0.0'><integrator type='path'><integer name='max_depth' value='2'/></integrator>" CAMERA(
            "4,0,2", "1,0,0", "0.2", "8") FLOOR
        "<shape type='sphere'><point name='center' x='0' y='0' z='2'/><float name='radius' value='0.5'/>"
        "<emitter type='area'><rgb name='radiance' value='3'/></emitter></shape></scene>";
    double d2 = 1 + 4, expected = 0.5 * 3 * 0.25 / d2 * (2 / sqrt(d2));
    check_mean(xml, PATH_MIS, 20, expected, 2e-3);
    check_mean(xml, PATH_LIGHTS_ONLY, 20, expected, 2e-3);
    check_mean(xml, PATH_BSDF_ONLY, 1000, expected, 2e-3);
}

// A rectangle parallel to the floor: the four corner forms (Howell, catalogue of configuration factors, B-3).
static double corner_factor(double a, double b, double h) {
    double x = a / h, y = b / h, rx = sqrt(1 + x * x), ry = sqrt(1 + y * y);
    return (x / rx * atan(y / rx) + y / ry * atan(x / ry)) / (2 * 3.14159265358979);
}

static void test_rectangle_irradiance(void **unused) {
    (void)unused;
    const char *xml =
        "<scene version='3.0.0'><integrator type='path'><integer name='max_depth' value='2'/></integrator>" CAMERA(
            "6,0,2", "0,0,0", "0.2", "8") FLOOR
        "<shape type='rectangle'><transform name='to_world'><scale x='1' y='0.5' z='1'/><rotate x='1' angle='180'/>"
        "<translate x='0.2' y='0.1' z='1.5'/></transform>" DIFFUSE(
            "0") "<emitter type='area'><rgb name='radiance' value='3'/></emitter></shape></scene>";
    double form = 0;
    for (int i = 0; i < 4; i++) {
        double x = (i & 1 ? 1 : -1) * 1 + 0.2, y = (i & 2 ? 1 : -1) * 0.5 + 0.1;
        form += (i & 1 ? 1 : -1) * (i & 2 ? 1 : -1) * (x < 0 ? -1 : 1) * (y < 0 ? -1 : 1) *
                corner_factor(fabs(x), fabs(y), 1.5);
    }
    check_mean(xml, PATH_MIS, 40, 0.5 * 3 * form, 2e-3);
    check_mean(xml, PATH_LIGHTS_ONLY, 40, 0.5 * 3 * form, 2e-3);
}

// Inside a glowing, reflecting sphere radiance is L (1 + rho + rho^2 ...): one term for each edge that max_depth
// allows.
static void test_furnace(void **unused) {
    (void)unused;
    const char *format =
        "<scene version='3.0.0'><integrator type='path'><integer name='max_depth' value='%d'/><integer name='rr_depth' "
        "value='3'/>"
        "</integrator>" CAMERA("0.1,0.2,0", "1,0,0", "60",
                               "8") "<shape type='sphere'><float name='radius' value='2'/><boolean name='flip_normals' "
                                    "value='true'/>" DIFFUSE("0.6") "<emitter type='area'><rgb name='radiance' "
                                                                    "value='1'/></emitter></shape></scene>";
    const int depths[] = {0, 1, 2, 3, 5, -1};
    for (size_t i = 0; i < sizeof depths / sizeof *depths; i++) {
        char xml[2000];
        snprintf(xml, sizeof xml, format, depths[i]);
        double expected = depths[i] < 0 ? 2.5 : (1 - pow(0.6, depths[i])) / 0.4;
        check_mean(xml, PATH_MIS, 40, expected, 1e-3);
        check_mean(xml, PATH_BSDF_ONLY, 40, expected, 1e-3);
    }
}

static void test_sky(void **unused) {
    (void)unused;
    const char *format =
        "<scene version='3.0.0'><integrator type='path'><boolean name='hide_emitters' value='%s'/></integrator>"
        "%s<emitter type='constant'><rgb name='radiance' value='2'/></emitter>" FLOOR "</scene>";
    char xml[2000];
    const char *down = CAMERA("4,0,2", "0,0,0", "1", "8"), *up = CAMERA("4,0,2", "4,1,5", "1", "8");
    snprintf(xml, sizeof xml, format, "false", down);
    check_mean(xml, PATH_MIS, 40, 1, 2e-3);
    snprintf(xml, sizeof xml, format, "false", up);
    check_mean(xml, PATH_MIS, 1, 2, 1e-6);
    snprintf(xml, sizeof xml, format, "true", up);
    check_mean(xml, PATH_MIS, 1, 0, 0);
    snprintf(xml, sizeof xml, format, "true", down);
    check_mean(xml, PATH_MIS, 40, 1, 2e-3);
}

// A point light through a mask of opacity 0.3 that both the camera ray and the shadow ray cross: no vertex, so
// max_depth 2 is enough; the mask itself is black.
static void test_mask(void **unused) {
    (void)unused;
    const char *xml =
        "<scene version='3.0.0'><integrator type='path'><integer name='max_depth' value='2'/></integrator>" CAMERA(
            "3,0,4", "1,0,0", "0.2", "8") FLOOR
        "<shape type='rectangle'><transform name='to_world'><scale x='9' y='9' z='1'/><translate z='1'/></transform>"
        "<bsdf type='mask'><float name='opacity' value='0.3'/>" DIFFUSE(
            "0") "</bsdf></shape>"
                 "<emitter type='point'><point name='position' x='0' y='0' z='2'/><rgb name='intensity' "
                 "value='10'/></emitter></scene>";
    double d2 = 5, expected = 0.5 / 3.14159265358979 * 10 / d2 * (2 / sqrt(d2)) * 0.7 * 0.7;
    check_mean(xml, PATH_MIS, 400, expected, 1e-3);
    check_mean(xml, PATH_BSDF_ONLY, 400, expected, 1e-3);
}

static const char *const mixed_scene =
    "<scene version='3.0.0'><integrator type='path'><integer name='max_depth' value='6'/></integrator>" CAMERA(
        "3,-4,3", "0,0,0.5", "40", "40") FLOOR
    "<emitter type='constant'><rgb name='radiance' value='0.2 0.3 0.4'/></emitter>"
    "<shape type='sphere'><point name='center' x='0' y='0' z='0.8'/><float name='radius' value='0.8'/>"
    "<bsdf type='roughconductor'><float name='alpha' value='0.3'/></bsdf></shape>"
    "<shape type='sphere'><point name='center' x='1' y='1' z='2'/><float name='radius' value='0.6'/>" DIFFUSE(
        "0") "<emitter type='area'><rgb name='radiance' value='4 3 2'/></emitter></shape></scene>";

static void test_strategies_agree(void **unused) {
    (void)unused;
    struct rendering mis, lights, bsdf;
    render(mixed_scene, PATH_MIS, 24, 1, &mis);
    render(mixed_scene, PATH_LIGHTS_ONLY, 48, 1, &lights);
    render(mixed_scene, PATH_BSDF_ONLY, 96, 1, &bsdf);
    assert_float_equal(lights.mean[1], mis.mean[1], 4 * hypot(lights.error[1], mis.error[1]));
    assert_float_equal(bsdf.mean[1], mis.mean[1], 4 * hypot(bsdf.error[1], mis.error[1]));
    assert_true(mis.error[1] < 0.01 * mis.mean[1] && bsdf.error[1] < 0.01 * mis.mean[1]);
    image_fini(&mis.image);
    image_fini(&lights.image);
    image_fini(&bsdf.image);
}

static void test_threads_do_not_matter(void **unused) {
    (void)unused;
    struct rendering one, three;
    render(mixed_scene, PATH_MIS, 6, 1, &one); // so many that roulette knows the picture
    render(mixed_scene, PATH_MIS, 6, 3, &three);
    assert_memory_equal(one.image.pixels, three.image.pixels, sizeof(float) * 6 * one.image.width * one.image.height);
    image_fini(&one.image);
    image_fini(&three.image);
}

// Roulette goes by what earlier passes found, and gives the same mean in less or other ways, pixel by pixel.
static void test_roulette_keeps_the_mean(void **unused) {
    (void)unused;
    struct rendering with, without;
    render(mixed_scene, PATH_MIS, 256, 1, &with);
    size_t dropped;
    render_path(mixed_scene, &(struct path_test){PATH_MIS, 256, 1, .seed = 7, .forgetful = true}, &without, &dropped);
    size_t count = with.image.width * with.image.height;
    double chi2 = 0, differing = 0;
    for (size_t i = 0; i < count; i++) {
        const float *a = with.image.pixels + 6 * i, *b = without.image.pixels + 6 * i;
        double variance = (double)a[4] + (double)b[4], difference = (double)a[1] - (double)b[1];
        if (variance > 0) chi2 += difference * difference / variance / (double)count;
        differing += difference != 0;
    }
    assert_true(differing > 0.5 * (double)count); // else there was no roulette
    assert_true(chi2 < 1.3);
    if (fabs(with.mean[1] - without.mean[1]) > 4 * hypot(with.error[1], without.error[1]))
        fail_msg("mean %g with roulette, %g without (standard errors %g, %g)", with.mean[1], without.mean[1],
                 with.error[1], without.error[1]);
    assert_true(with.error[1] < 0.005 * with.mean[1]);
    image_fini(&with.image);
    image_fini(&without.image);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_sphere_irradiance),
                                       cmocka_unit_test(test_rectangle_irradiance),
                                       cmocka_unit_test(test_furnace),
                                       cmocka_unit_test(test_sky),
                                       cmocka_unit_test(test_mask),
                                       cmocka_unit_test(test_strategies_agree),
                                       cmocka_unit_test(test_threads_do_not_matter),
                                       cmocka_unit_test(test_roulette_keeps_the_mean)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
