// Fresnel's equations against closed forms, named indices, and delta BSDFs against Snell's law; hostile directions.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <complex.h>
#include <cmocka.h>

#include "math/sampler.h"
#include "scene/bsdf/fresnel.h"
#include "../../bsdf_from_xml.h"

// Fresnel's equations as they are usually written, in complex double precision.
static double fresnel_plain(double cos_i, double complex eta, double complex *cos_t) {
    double sin2 = 1 - cos_i * cos_i;
    *cos_t = csqrt(1 - sin2 / (eta * eta));
    double complex s = (cos_i - eta * *cos_t) / (cos_i + eta * *cos_t),
                   p = (eta * cos_i - *cos_t) / (eta * cos_i + *cos_t);
    return 0.5 * (cabs(s) * cabs(s) + cabs(p) * cabs(p));
}

static void test_dielectric(void **state) {
    (void)state;
    const double etas[] = {1.0003, 1.33, 1.5, 2.4, 1 / 1.5, 1 / 2.4};
    for (int e = 0; e < 6; ++e) {
        for (int i = 0; i <= 200; ++i) {
            double cos_i = i / 200.0;
            double complex cos_t;
            double wanted = fresnel_plain(cos_i, etas[e], &cos_t);
            float cos_far, f = fresnel_dielectric((float)cos_i, (float)etas[e], &cos_far);
            double rounding = 2e-6 / fmax(1e-3, cabs(cos_t)); // large at the critical angle
            assert_true(fabs(f - wanted) < 2e-5 + rounding);
            assert_true(fabs(cos_far - fmax(0, creal(cos_t))) < 2e-5 + rounding);
        }
    }
    float cos_t;
    assert_true(fabsf(fresnel_dielectric(1, 1.5f, &cos_t) - 0.04f) < 1e-6f);
    assert_true(fresnel_dielectric(0.5f, 1 / 1.5f, &cos_t) == 1 &&
                cos_t == 0); // beyond the critical angle of 41.8 degrees
}

static void test_conductor(void **state) {
    (void)state;
    const double metals[][2] = {{0.2, 3.9}, {1.1, 2.1}, {4.4, 5.2}, {0, 1}, {1.66, 9.22}, {1.5, 0}};
    for (int m = 0; m < 6; ++m) {
        for (int i = 1; i <= 200; ++i) {
            double cos_i = i / 200.0;
            double complex cos_t;
            double wanted = fresnel_plain(cos_i, metals[m][0] - metals[m][1] * I, &cos_t);
            assert_true(fabs(fresnel_conductor_channel((float)cos_i, (float)metals[m][0], (float)metals[m][1]) -
                             wanted) < 1e-4);
        }
    }
}

// The fits are within 1.1 % of the integral of 2 cos F.
static void test_diffuse_reflectance(void **state) {
    (void)state;
    const double etas[] = {1.3, 1.5, 1.8, 1 / 1.3, 1 / 1.5, 1 / 1.8};
    for (int e = 0; e < 6; ++e) {
        double sum = 0;
        enum { steps = 20000 };
        for (int i = 0; i < steps; ++i) {
            double complex cos_t;
            double cos_i = (i + 0.5) / steps;
            sum += 2 * cos_i * fresnel_plain(cos_i, etas[e], &cos_t) / steps;
        }
        assert_true(fabs(fresnel_diffuse_reflectance((float)etas[e]) - sum) < 0.011 * sum + 1e-3);
    }
}

static void test_names(void **state) {
    (void)state;
    struct object object = {.place = {"scene.xml", 3, 9}};
    struct commit_context context = {.object = &object};
    struct error error;
    float ratio;
    assert_int_equal(ior_ratio_parse(&ratio, "bk7", "air", &context, &error), STATUS_OK);
    assert_true(fabsf(ratio - 1.5046f / 1.000277f) < 1e-6f);
    assert_int_equal(ior_ratio_parse(&ratio, " 1.5 ", "Water", &context, &error), STATUS_OK);
    assert_true(fabsf(ratio - 1.5f / 1.333f) < 1e-6f);
    const char *wrong[] = {"watr", "", "-1", "0", "1.5x", "nan", "inf"};
    for (int i = 0; i < 7; ++i) {
        assert_int_equal(ior_ratio_parse(&ratio, wrong[i], "air", &context, &error), STATUS_INVALID);
        assert_non_null(strstr(error.text, "scene.xml:3:9"));
    }
    rgb eta = {0, 0, 0}, k = {0, 0, 0};
    assert_int_equal(metal_resolve(&eta, &k, "Ni_palik", "vacuum", &context, &error), STATUS_OK);
    assert_true(k.r > 1);
    assert_int_equal(metal_resolve(&eta, &k, "Au", "vacuum", &context, &error),
                     STATUS_INVALID); // eta and k are set already
    eta = k = (rgb){0, 0, 0};
    assert_int_equal(metal_resolve(&eta, &k, "Gold", "vacuum", &context, &error), STATUS_INVALID);
    assert_non_null(strstr(error.text, "Au"));
}

// Snell's law, and that the way back gives the same light.
static void test_glass(void **state) {
    (void)state;
    struct xml_plugins plugins = {0};
    struct error error;
    const struct bsdf *glass = xml_bsdf(&plugins,
                                        "<bsdf type='dielectric'><float name='intIOR' value='1.5'/>"
                                        "<string name='extIOR' value='vacuum'/></bsdf>",
                                        &error);
    assert_non_null(glass);
    const struct bsdf_point point = {0};
    struct sampler sampler = sampler_make(1, 2, 3);
    for (int i = 0; i < 1000; ++i) {
        vec2 u = sampler_2d(&sampler);
        float z = 2 * u.x - 1, r = sqrtf(1 - z * z);
        vec3 wi = {r * cosf(6.28f * u.y), r * sinf(6.28f * u.y), z};
        struct bsdf_sample there, back;
        if (!bsdf_sample(glass, &point, wi, (vec3){0, 0, 0.99999f}, TRANSPORT_RADIANCE, &there)) continue;
        if (there.wo.z * wi.z > 0 || fabsf(there.wo.z * wi.z) < 0.01f) continue; // total reflection, grazing
        float eta = wi.z > 0 ? 1.5f : 1 / 1.5f;
        assert_true(fabsf(there.eta - eta) < 1e-5f && fabsf(there.wo.x * eta + wi.x) < 1e-5f);
        assert_true(fabsf(vec3_length(there.wo) - 1) < 1e-5f);
        assert_true(bsdf_sample(glass, &point, there.wo, (vec3){0, 0, 0.99999f}, TRANSPORT_RADIANCE, &back));
        assert_true(vec3_length(vec3_sub(back.wo, wi)) < 2e-3f);
        assert_true(fabsf(back.pdf - there.pdf) < 2e-3f);
        assert_true(fabsf(back.weight.g * there.weight.g - 1) < 1e-4f);
    }
    xml_fini(&plugins);
}

// Grazing and degenerate directions, and the borders of the unit cube, give finite numbers.
static void test_hostile_directions(void **state) {
    (void)state;
    const char *const materials[] = {
        "<bsdf type='roughdielectric'><string name='distribution' value='ggx'/><float name='alpha' value='0'/></bsdf>",
        "<bsdf type='roughdielectric'><string name='distribution' value='ggx'/><float name='alpha' "
        "value='0.001'/></bsdf>",
        "<bsdf type='roughdielectric'><string name='distribution' value='ggx'/><float name='alpha' value='1'/></bsdf>",
        "<bsdf type='roughdielectric'><float name='alpha' value='0.0005'/></bsdf>",
        "<bsdf type='roughdielectric'><float name='alpha' value='1'/></bsdf>",
        "<bsdf type='roughdielectric'><float name='alpha' value='0.3'/><float name='int_ior' value='1.001'/></bsdf>",
        "<bsdf type='roughconductor'><float name='alpha' value='0.001'/></bsdf>",
        "<bsdf type='roughplastic'><float name='alpha' value='0.001'/></bsdf>",
        "<bsdf type='plastic'/>",
        "<bsdf type='dielectric'/>",
        "<bsdf type='thindielectric'/>",
        "<bsdf type='twosided'><bsdf type='diffuse'/></bsdf>",
    };
    const float heights[] = {0, 1e-30f, 1e-8f, 1e-4f, 0.5f, 0.9999999f, 1};
    const float us[] = {0, 1e-7f, 0.5f, 0x1.fffffep-1f};
    const struct bsdf_point point = {0};
    for (size_t m = 0; m < sizeof materials / sizeof *materials; ++m) {
        struct xml_plugins plugins = {0};
        struct error error;
        const struct bsdf *b = xml_bsdf(&plugins, materials[m], &error);
        if (!b) xml_fail(&error);
        for (int i = 0; i < 7 * 2 * 64; ++i) {
            float z = heights[i % 7] * (i / 7 % 2 ? -1 : 1);
            int grid = i / 14;
            vec3 wi = {sqrtf(1 - z * z), 0, z}, u = {us[grid % 4], us[grid / 4 % 4], us[grid / 16]};
            struct bsdf_sample s;
            if (!bsdf_sample(b, &point, wi, u, TRANSPORT_RADIANCE, &s)) continue;
            assert_true(vec3_is_finite(s.wo) && fabsf(vec3_length(s.wo) - 1) < 1e-3f);
            assert_true(isfinite(s.pdf) && s.pdf > 0 && isfinite(rgb_mean(s.weight)) && rgb_max(s.weight) < 1e3f);
            assert_true(isfinite(bsdf_pdf(b, &point, wi, s.wo, TRANSPORT_RADIANCE)));
            assert_true(isfinite(rgb_mean(bsdf_eval(b, &point, wi, s.wo, TRANSPORT_RADIANCE))));
            assert_true(isfinite(rgb_mean(bsdf_eval(b, &point, wi, vec3_neg(wi), TRANSPORT_RADIANCE))));
            assert_true(isfinite(bsdf_pdf(b, &point, wi, vec3_neg(wi), TRANSPORT_RADIANCE)));
        }
        xml_fini(&plugins);
    }
}

static void test_errors(void **state) {
    (void)state;
    const char *const wrong[][2] = {
        {"<bsdf type='roughdielectric'><string name='int_ior' value='air'/></bsdf>", "null"},
        {"<bsdf type='twosided'><bsdf type='dielectric'/></bsdf>", "twosided"},
        {"<bsdf type='mixturebsdf'><string name='weights' value='0.5'/><bsdf type='null'/><bsdf type='null'/></bsdf>",
         "weights"},
        {"<bsdf type='mixturebsdf'><string name='weights' value='0.5, x'/><bsdf type='null'/><bsdf "
         "type='null'/></bsdf>",
         "list"},
        {"<bsdf type='conductor'><string name='material' value='Cuu'/></bsdf>", "Cu"},
        {"<bsdf type='dielectric'><string name='int_ior' value='diamnd'/></bsdf>", "diamond"},
    };
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; ++i) {
        struct xml_plugins plugins = {0};
        struct error error = {0};
        assert_null(xml_bsdf(&plugins, wrong[i][0], &error));
        assert_int_equal(error.status, STATUS_INVALID);
        assert_non_null(strstr(error.text, wrong[i][1]));
        assert_non_null(strstr(error.text, "memory.xml:1:"));
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_dielectric), cmocka_unit_test(test_conductor), cmocka_unit_test(test_diffuse_reflectance),
        cmocka_unit_test(test_names),      cmocka_unit_test(test_glass),     cmocka_unit_test(test_hostile_directions),
        cmocka_unit_test(test_errors),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
