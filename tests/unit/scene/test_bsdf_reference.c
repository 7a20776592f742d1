// BSDFs against the values that Mitsuba 3 gave (tests/reference/bsdf.py).
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "../../bsdf_from_xml.h"

// Tolerances. Beckmann: Mitsuba fits the masking function (Walter et al. 2007, 0.35 % off for each of two directions),
// ours is exact. roughplastic: both integrate the coat by a quadrature of their own; the two differ by 0.3 %.
static bool values_agree(double ours, double theirs, double tolerance) {
    return fabs(ours - theirs) <= tolerance * fabs(theirs) + 1e-5;
}

struct reference {
    struct xml_plugins plugins;
    const struct bsdf *bsdf;
    char xml[1000];
    double tolerance;
    int bad, count;
};

static void check(struct reference *r, const char *what, const float *directions, const double *ours,
                  const float *theirs, int n) {
    for (int i = 0; i < n; ++i) {
        if (values_agree(ours[i], theirs[i], r->tolerance)) continue;
        if (r->bad++ < 40) {
            printf("%s%s %d, wi %g %g %g, wo %g %g %g: %.6g, Mitsuba %.6g (%+.2g)\n", r->xml, what, i, directions[0],
                   directions[1], directions[2], directions[3], directions[4], directions[5], ours[i], theirs[i],
                   ours[i] / theirs[i] - 1);
        }
    }
    ++r->count;
}

static void check_smooth(struct reference *r, const float *v) {
    struct bsdf_point point = {0};
    vec3 wi = {v[0], v[1], v[2]}, wo = {v[3], v[4], v[5]};
    rgb f = bsdf_eval(r->bsdf, &point, wi, wo, TRANSPORT_RADIANCE);
    double ours[4] = {f.r, f.g, f.b, bsdf_pdf(r->bsdf, &point, wi, wo, TRANSPORT_RADIANCE)};
    check(r, "smooth", v, ours, v + 6, isnan(v[9]) ? 3 : 4);
}

static void check_delta(struct reference *r, const float *v) {
    struct bsdf_point point = {0};
    vec3 wi = {v[0], v[1], v[2]}, wo = {v[3], v[4], v[5]};
    rgb through = bsdf_through(r->bsdf, &point, wi), total = {-1, -1, -1};
    if (vec3_dot(wi, wo) < -0.99999f && (r->bsdf->flags & BSDF_NULL)) total = through;
    for (int i = 0; i < 2; ++i) {
        struct bsdf_sample s;
        if (!bsdf_sample(r->bsdf, &point, wi, (vec3){0.3f, 0.6f, i ? 0.9999f : 0}, TRANSPORT_RADIANCE, &s) || !s.delta)
            continue;
        if (vec3_dot(s.wo, wo) < 0.99999f) continue;
        total = rgb_mul(rgb_scale(s.weight, s.pdf), rgb_sub(rgb_gray(1), through));
    }
    double ours[3] = {total.r, total.g, total.b};
    check(r, "delta", v, ours, v + 6, 3);
}

static void test_values(void **state) {
    (void)state;
    FILE *file = fopen(SOURCE_DIR "/tests/reference/bsdf_values.txt", "r");
    assert_non_null(file);
    struct reference r = {0};
    struct error error;
    char line[1000];
    while (fgets(line, sizeof line, file)) {
        float v[10];
        if (!strncmp(line, "bsdf ", 5)) {
            if (r.bsdf) xml_fini(&r.plugins);
            memset(&r.plugins, 0, sizeof r.plugins);
            snprintf(r.xml, sizeof r.xml, "%s", line + 5);
            r.tolerance = strstr(line, "beckmann") ? 8e-3 : strstr(line, "roughplastic") ? 5e-3 : 1e-3;
            r.bsdf = xml_bsdf(&r.plugins, line + 5, &error);
            if (!r.bsdf) xml_fail(&error);
        } else if (sscanf(line, "smooth %f %f %f %f %f %f %f %f %f %f", v, v + 1, v + 2, v + 3, v + 4, v + 5, v + 6,
                          v + 7, v + 8, v + 9) == 10) {
            check_smooth(&r, v);
        } else if (sscanf(line, "delta %f %f %f %f %f %f %f %f %f", v, v + 1, v + 2, v + 3, v + 4, v + 5, v + 6, v + 7,
                          v + 8) == 9) {
            check_delta(&r, v);
        } else {
            fail_msg("cannot read: %s", line);
        }
    }
    if (r.bsdf) xml_fini(&r.plugins);
    fclose(file);
    printf("%d pairs of directions, %d values differ\n", r.count, r.bad);
    assert_true(r.count > 300);
    assert_int_equal(r.bad, 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_values)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
