// Spectra against the RGB variants of Mitsuba 3: the expected values were printed by mitsuba 3.9.1, scalar_rgb, with
// mi.traverse(mi.load_string(...)) of a diffuse BSDF's reflectance and of a constant emitter's radiance.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "format/spectrum.h"

static const struct {
    float nm[4], value[4];
    size_t n;
    enum spectrum_use use;
    rgb expected;
} cases[] = {
    {{400, 700}, {0.5f, 0.5f}, 2, SPECTRUM_REFLECTANCE, {0.497671f, 0.499878f, 0.497455f}},
    {{400, 700}, {0.5f, 0.5f}, 2, SPECTRUM_EMISSION, {0.599847f, 0.47476f, 0.451722f}},
    {{400, 500, 600, 700}, {0, 0.2f, 0.9f, 0.1f}, 4, SPECTRUM_REFLECTANCE, {0.890685f, 0.505134f, 0.049306f}},
    {{400, 500, 600, 700}, {0, 0.2f, 0.9f, 0.1f}, 4, SPECTRUM_EMISSION, {1.01657f, 0.489279f, 0.0351513f}},
    {{360, 830}, {1, 1}, 2, SPECTRUM_REFLECTANCE, {0.998985f, 0.998874f, 0.998802f}},
    {{300, 900}, {1, 1}, 2, SPECTRUM_EMISSION, {1.20488f, 0.948228f, 0.909267f}},
    {{500, 510}, {1, 1}, 2, SPECTRUM_REFLECTANCE, {0, 0.0781108f, 0.0146232f}},
    {{550, 555, 560}, {0, 1, 0}, 3, SPECTRUM_EMISSION, {0.00578569f, 0.064314f, 0}},
    {{400, 700}, {0.1f, 0.9f}, 2, SPECTRUM_REFLECTANCE, {0.742853f, 0.48114f, 0.208325f}},
    {{600, 610}, {2, 3}, 2, SPECTRUM_EMISSION, {0.57948f, 0.0112446f, 0}},
};

static void assert_near(rgb a, rgb b, float tolerance) {
    assert_float_equal(a.r, b.r, tolerance);
    assert_float_equal(a.g, b.g, tolerance);
    assert_float_equal(a.b, b.b, tolerance);
}

static void test_pairs_agree_with_mitsuba(void **state) {
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        rgb c = spectrum_rgb(cases[i].nm, cases[i].value, cases[i].n, cases[i].use);
        // A step edge inside a table interval moves by half a sampling step: 0.5 nm of a 10 nm band.
        float width = cases[i].nm[cases[i].n - 1] - cases[i].nm[0];
        assert_near(c, cases[i].expected, rgb_max(cases[i].expected) * (width < 50 ? 0.04f : 0.002f));
    }
}

static void test_uniform_is_gray_or_illuminant_e(void **state) {
    (void)state;
    assert_near(spectrum_uniform_rgb(0.5f, SPECTRUM_REFLECTANCE), rgb_gray(0.5f), 0);
    assert_near(spectrum_uniform_rgb(5, SPECTRUM_EMISSION), (rgb){6.02397f, 4.74146f, 4.54458f}, 1e-4f);
}

// The luminance of a black body relates to its luminous exitance: L_v = 683 * integral(L ybar); at 2042.15 K the old
// candela was defined by platinum's freezing point: 6.0e5 cd/m^2 (CGPM 1948). Our Y is integral(L ybar) /
// integral(ybar).
static void test_blackbody_at_the_freezing_point_of_platinum(void **state) {
    (void)state;
    rgb c = spectrum_blackbody_rgb(2042.15);
    float luminance = 683.002f * 106.857f * rgb_luminance(c);
    assert_true(fabsf(luminance - 6e5f) < 0.02f * 6e5f);
}

// Chromaticity on the Planckian locus: x, y of CIE 15 table at 6500 K: (0.3135, 0.3237), at 2856 K (illuminant A):
// (0.4476, 0.4074).
static void test_blackbody_chromaticity(void **state) {
    (void)state;
    const struct {
        double kelvin;
        float x, y;
    } locus[] = {{6500, 0.3135f, 0.3237f}, {2856, 0.4476f, 0.4074f}};
    for (int i = 0; i < 2; i++) {
        rgb c = spectrum_blackbody_rgb(locus[i].kelvin);
        float x = 0.412453f * c.r + 0.357580f * c.g + 0.180423f * c.b;
        float y = 0.212671f * c.r + 0.715160f * c.g + 0.072169f * c.b;
        float z = 0.019334f * c.r + 0.119193f * c.g + 0.950227f * c.b;
        assert_float_equal(x / (x + y + z), locus[i].x, 0.001f);
        assert_float_equal(y / (x + y + z), locus[i].y, 0.001f);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_pairs_agree_with_mitsuba),
        cmocka_unit_test(test_uniform_is_gray_or_illuminant_e),
        cmocka_unit_test(test_blackbody_at_the_freezing_point_of_platinum),
        cmocka_unit_test(test_blackbody_chromaticity),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
