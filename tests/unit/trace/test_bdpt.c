// Bidirectional path tracing and light tracing against closed forms, and for any number of threads.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "../../render_image.h"

extern const struct integrator_type bdpt_integrator, particle_integrator;

#define CAMERA(origin, target, fov, size)                                                                              \
    "<sensor type='perspective'><float name='fov' value='" fov "'/><transform name='to_world'><lookat origin='" origin \
    "' target='" target "' up='0,0,1'/></transform><film type='hdrfilm'><integer name='width' value='" size            \
    "'/><integer name='height' value='" size "'/><rfilter type='box'/></film></sensor>"
#define DIFFUSE(value) "<bsdf type='diffuse'><rgb name='reflectance' value='" value "'/></bsdf>"
#define FLOOR(size)                                                                                                    \
    "<shape type='rectangle'><transform name='to_world'><scale x='" size "' y='" size                                  \
    "' z='1'/></transform>" DIFFUSE("0.5") "</shape>"

static void check_mean(const char *xml, const struct integrator_type *type, int passes, double expected,
                       double tolerance) {
    struct rendering r = {0};
    struct error error = {0};
    if (render_text(xml, type, passes, 1, 7, &r, &error) != STATUS_OK) fail_msg("%s", error.text);
    image_fini(&r.image);
    double slack = tolerance * expected + 4 * r.error[1];
    if (!(fabs(r.mean[1] - expected) <= slack))
        fail_msg("%s: mean %g, expected %g (standard error %g)", type->name, r.mean[1], expected, r.error[1]);
    if (!(r.error[1] <= 0.03 * expected + 1e-6))
        fail_msg("%s: too noisy to tell: %g of %g", type->name, r.error[1], expected);
}

// A small sphere above the floor that a narrow camera looks at: E = pi L (r / d)^2 cos, outgoing rho E / pi.
static void test_sphere_irradiance(void **unused) {
    (void)unused;
    const char *xml =
        "<scene version='3.0.0'><integrator type='path'><integer name='max_depth' value='2'/></integrator>" CAMERA(
            "2,0,2", "1,0,0", "12", "4")
            FLOOR(
                "1.6") "<shape type='sphere'><point name='center' x='1' y='0' z='3'/><float name='radius' value='0.5'/>"
                       "<emitter type='area'><rgb name='radiance' value='3'/></emitter></shape></scene>";
    double sum = 0; // over the film, as the camera sees a patch that is not small
    int n = 200;
    for (int j = 0; j < n; j++)
        for (int i = 0; i < n; i++) {
            double t = tan(6 * 3.14159265358979 / 180), a = t * (2 * (i + 0.5) / n - 1),
                   b = t * (2 * (j + 0.5) / n - 1);
            double f[3] = {-1 / sqrt(5), 0, -2 / sqrt(5)},
                   u[3] = {-2 / sqrt(5), 0, 1 / sqrt(5)}; // forward, up; side = y
            double w[3] = {f[0] + b * u[0], a, f[2] + b * u[2]}, k = -2 / w[2];
            double x = 2 + k * w[0] - 1, y = k * w[1], d2 = x * x + y * y + 9;
            sum += 0.5 * 3 * 0.25 / d2 * (3 / sqrt(d2));
        }
    double expected = sum / (n * n);
    check_mean(xml, &bdpt_integrator, 60, expected, 2e-3);
    check_mean(xml, &particle_integrator, 60000, expected, 2e-3);
}

// Inside a glowing, reflecting sphere radiance is L (1 + rho + rho^2 ...): one term for each edge of max_depth.
static void test_furnace(void **unused) {
    (void)unused;
    const char *format = "<scene version='3.0.0'><integrator type='path'><integer name='max_depth' "
                         "value='%d'/><integer name='rr_depth' value='3'/>"
                         "</integrator>" CAMERA("0.1,0.2,0", "1,0,0", "90",
                                                "8") "<shape type='sphere'><float name='radius' value='2'/>"
                                                     "<boolean name='flip_normals' value='true'/>" DIFFUSE(
                                                         "0.6") "<emitter type='area'><rgb name='radiance' value='1'/>"
                                                                "</emitter></shape></scene>";
    const int depths[] = {0, 1, 2, 3, 5, -1};
    for (size_t i = 0; i < sizeof depths / sizeof *depths; i++) {
        char xml[2000];
        snprintf(xml, sizeof xml, format, depths[i]);
        double expected = depths[i] < 0 ? 2.5 : (1 - pow(0.6, depths[i])) / 0.4;
        check_mean(xml, &bdpt_integrator, 40, expected, 1e-3);
        check_mean(xml, &particle_integrator, 400, expected, 1e-3);
    }
}

// What only the camera sees at infinity, and hide_emitters.
static void test_sky(void **unused) {
    (void)unused;
    const char *format =
        "<scene version='3.0.0'><integrator type='path'><boolean name='hide_emitters' value='%s'/></integrator>" CAMERA(
            "4,0,2", "4,1,5", "1",
            "8") "<emitter type='constant'><rgb name='radiance' value='2'/></emitter>" FLOOR("1") "</scene>";
    char xml[2000];
    for (int hidden = 0; hidden < 2; hidden++) {
        snprintf(xml, sizeof xml, format, hidden ? "true" : "false");
        check_mean(xml, &bdpt_integrator, 1, hidden ? 0 : 2, 1e-6);
        check_mean(xml, &particle_integrator, 1, hidden ? 0 : 2, 1e-6);
    }
}

static void test_threads_do_not_matter(void **unused) {
    (void)unused;
    const struct integrator_type *types[] = {&bdpt_integrator, &particle_integrator};
    for (int i = 0; i < 2; i++) {
        struct rendering one = {0}, three = {0};
        struct error error = {0};
        const char *path = SOURCE_DIR "/tests/scenes/rough_lamp.xml";
        if (render_file(path, types[i], 3, 1, 5, &one, &error) != STATUS_OK) fail_msg("%s", error.text);
        assert_int_equal(render_file(path, types[i], 3, 3, 5, &three, &error), STATUS_OK);
        assert_true(one.mean[0] > 0);
        assert_memory_equal(one.image.pixels, three.image.pixels, sizeof(float) * 6 * (size_t)(one.width * one.height));
        image_fini(&one.image);
        image_fini(&three.image);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_sphere_irradiance), cmocka_unit_test(test_furnace),
                                       cmocka_unit_test(test_sky), cmocka_unit_test(test_threads_do_not_matter)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
