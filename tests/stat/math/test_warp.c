// Chi-square of every warp in warp_table against its density, and of the planar warps against their areas.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>
#include <cmocka.h>

#include "chi_square.h"
#include "math/distribution.h"
#include "math/sampler.h"
#include "math/warp.h"

enum { SAMPLES = 400000, TESTS = 12 };

static bool warp_sample_index(void *user, uint64_t index, vec3 *w) {
    struct sampler sampler = sampler_make(11, 0, index);
    *w = ((const struct warp *)user)->sample(sampler_2d(&sampler));
    return true;
}

static double warp_pdf(void *user, vec3 w) { return (double)((const struct warp *)user)->pdf_sa(w); }

static struct chi_square warp_test(const struct warp *warp) {
    // 20 rows: the table's cone of cos 0.8 ends on a row's edge.
    struct chi_square_direction test = {.sample = warp_sample_index,
                                        .pdf_sa = warp_pdf,
                                        .user = (void *)warp,
                                        .samples = SAMPLES,
                                        .rows = 20,
                                        .columns = 32};
    return chi_square_test_directions(&test);
}

static void test_table(void **state) {
    (void)state;
    for (const struct warp *w = warp_table; w->name; ++w) {
        assert_true(chi_square_passes(w->name, warp_test(w), chi_square_sidak(0.01, TESTS)));
    }
}

static float wrong_pdf(vec3 w) { return w.z > 0 ? 0.5f * INV_PI_F * (0.94f + 0.12f * w.z) : 0; }

// The test itself must see a density that is off by up to 6 %.
static void test_detects_wrong_density(void **state) {
    (void)state;
    const struct warp wrong = {"wrong", warp_uniform_hemisphere, wrong_pdf};
    assert_true(warp_test(&wrong).p < 1e-6);
}

static void test_cones(void **state) {
    (void)state;
    const float cosines[] = {-0.5f, 0.5f, 0.99f, 0.999999f};
    for (int k = 0; k < 4; ++k) { // uniform in a cone: the height is uniform in [cos_max, 1]
        struct chi_square_cell cells[64] = {{0, 0}};
        for (uint64_t i = 0; i < SAMPLES; ++i) {
            struct sampler sampler = sampler_make(12, (uint64_t)k, i);
            vec3 w = warp_uniform_cone(sampler_2d(&sampler), cosines[k]);
            double sine2 = (double)w.x * w.x + (double)w.y * w.y;
            double depth =
                w.z > 0 ? sine2 / (1 + sqrt(fmax(0, 1 - sine2))) : 1 - (double)w.z; // 1 - cos without cancellation
            int row = (int)(depth / (1 - (double)cosines[k]) * 8),
                column = (int)((atan2f(w.y, w.x) / (2 * M_PI) + 0.5) * 8);
            assert_true(depth <= (1 - (double)cosines[k]) * 1.0001);
            ++cells[(row > 7 ? 7 : row) * 8 + (column > 7 ? 7 : column)].observed;
        }
        for (int i = 0; i < 64; ++i) cells[i].expected = SAMPLES / 64.0;
        assert_true(chi_square_passes("cone", chi_square_counts(cells, 64), chi_square_sidak(0.01, TESTS)));
    }
}

static void test_planar(void **state) {
    (void)state;
    struct chi_square_cell disk[64] = {{0, 0}}, triangle[64] = {{0, 0}};
    for (uint64_t i = 0; i < SAMPLES; ++i) {
        struct sampler sampler = sampler_make(13, 0, i);
        vec2 d = warp_concentric_disk(sampler_2d(&sampler));
        float r2 = d.x * d.x + d.y * d.y; // uniform: r^2 and the angle are uniform
        assert_true(r2 <= 1.00001f);
        int row = (int)fminf(7, r2 * 8), column = (int)fminf(7, (atan2f(d.y, d.x) * (0.5f * INV_PI_F) + 0.5f) * 8);
        ++disk[row * 8 + column].observed;
        vec2 b = warp_triangle(sampler_2d(&sampler));
        assert_true(b.x >= 0 && b.y >= 0 && b.x + b.y <= 1.00001f);
        // Folding the unit square's upper half over the diagonal maps uniform squares to the uniform triangle, so
        // counts of (b1, b2) in an 8 x 8 grid are 2/64 below the diagonal and half of it on the diagonal.
        ++triangle[(int)fminf(7, b.x * 8) * 8 + (int)fminf(7, b.y * 8)].observed;
    }
    for (int i = 0; i < 64; ++i) {
        int sum = i / 8 + i % 8;
        disk[i].expected = SAMPLES / 64.0;
        triangle[i].expected = sum < 7 ? SAMPLES / 32.0 : sum == 7 ? SAMPLES / 64.0 : 0;
    }
    assert_true(chi_square_passes("disk", chi_square_counts(disk, 64), chi_square_sidak(0.01, TESTS)));
    assert_true(chi_square_passes("triangle", chi_square_counts(triangle, 64), chi_square_sidak(0.01, TESTS)));
}

static void test_distribution2d(void **state) {
    (void)state;
    float weights[6 * 5];
    double total = 0;
    for (int i = 0; i < 30; ++i) total += weights[i] = i % 7 == 3 ? 0 : (float)(1 + i * i % 11);
    struct distribution2d d;
    assert_int_equal(distribution2d_init(&d, weights, 6, 5, NULL), STATUS_OK);
    struct chi_square_cell cells[30] = {{0, 0}};
    for (uint64_t i = 0; i < SAMPLES; ++i) {
        struct sampler sampler = sampler_make(14, 0, i);
        float pdf;
        vec2 p = distribution2d_sample(&d, sampler_2d(&sampler), &pdf);
        int cell = (int)(p.y * 5) * 6 + (int)(p.x * 6);
        assert_true(fabs((double)pdf - 30 * (double)weights[cell] / total) < 1e-4 * (double)pdf);
        ++cells[cell].observed;
    }
    for (int i = 0; i < 30; ++i) cells[i].expected = SAMPLES * (double)weights[i] / total;
    assert_true(chi_square_passes("distribution2d", chi_square_counts(cells, 30), chi_square_sidak(0.01, TESTS)));
    distribution2d_fini(&d);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_table),  cmocka_unit_test(test_detects_wrong_density), cmocka_unit_test(test_cones),
        cmocka_unit_test(test_planar), cmocka_unit_test(test_distribution2d),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
