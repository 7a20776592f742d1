// Transforms against closed forms, and against their own inverses.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "math/transform.h"

static void assert_vec3(vec3 a, float x, float y, float z, float tolerance) {
    assert_float_equal(a.x, x, tolerance);
    assert_float_equal(a.y, y, tolerance);
    assert_float_equal(a.z, z, tolerance);
}

static void test_elements(void **state) {
    (void)state;
    struct transform t = transform_translate(vec3_make(1, 2, 3));
    assert_vec3(transform_point(&t, vec3_make(1, 1, 1)), 2, 3, 4, 0);
    assert_vec3(transform_vector(&t, vec3_make(1, 1, 1)), 1, 1, 1, 0);
    t = transform_rotate(vec3_make(0, 0, 2), 90); // counter-clockwise seen from +z; the axis need not be unit
    assert_vec3(transform_point(&t, vec3_make(1, 0, 5)), 0, 1, 5, 1e-6f);
    t = transform_rotate(vec3_make(1, 1, 1), 120); // permutes the axes
    assert_vec3(transform_point(&t, vec3_make(1, 2, 3)), 3, 1, 2, 1e-6f);
    t = transform_scale(vec3_make(2, 4, 8));
    assert_vec3(transform_normal(&t, vec3_make(1, 1, 1)), 0.5f, 0.25f, 0.125f, 0);
}

static void test_look_at(void **state) {
    (void)state;
    struct transform t = transform_look_at(vec3_make(0, 0, 5), vec3_make(0, 0, 0), vec3_make(0, 1, 0));
    assert_vec3(transform_point(&t, vec3_make(0, 0, 0)), 0, 0, 5, 1e-6f);
    assert_vec3(transform_vector(&t, vec3_make(0, 0, 1)), 0, 0, -1, 1e-6f);
    assert_vec3(transform_vector(&t, vec3_make(1, 0, 0)), -1, 0, 0, 1e-6f); // local x is to the left in Mitsuba
    assert_vec3(transform_vector(&t, vec3_make(0, 1, 0)), 0, 1, 0, 1e-6f);
    t = transform_look_at(vec3_make(0, 0, 0), vec3_make(0, 3, 0), vec3_make(0, 1, 0)); // up along the view
    assert_float_equal(transform_uniform_scale(&t), 1, 1e-5f);
}

static void test_order_and_inverse(void **state) {
    (void)state;
    struct transform a = transform_rotate(vec3_make(1, 2, 3), 40), b = transform_translate(vec3_make(5, -1, 2));
    struct transform c = transform_scale(vec3_make(1, 2, -3)), ab = transform_multiply(&a, &b),
                     abc = transform_multiply(&ab, &c);
    vec3 p = {0.3f, -0.7f, 1.9f}, q = transform_point(&c, p);
    q = transform_point(&b, q);
    q = transform_point(&a, q);
    vec3 direct = transform_point(&abc, p);
    assert_vec3(direct, q.x, q.y, q.z, 1e-5f);
    struct transform inverse = transform_inverse(&abc);
    assert_vec3(transform_point(&inverse, direct), p.x, p.y, p.z, 1e-5f);
    bool invertible;
    struct transform again = transform_from_matrix((const float(*)[4])abc.m, &invertible);
    assert_true(invertible);
    for (int i = 0; i < 16; ++i) assert_float_equal(again.inverse[i / 4][i % 4], abc.inverse[i / 4][i % 4], 1e-5f);
    // A normal stays perpendicular to the transformed surface.
    vec3 tangent = {1, 2, -1}, normal = {1, 0, 1};
    assert_float_equal(vec3_dot(transform_vector(&abc, tangent), transform_normal(&abc, normal)), 0, 1e-5f);
}

static void test_classes(void **state) {
    (void)state;
    struct transform r = transform_rotate(vec3_make(1, 2, 3), 77), s = transform_scale(vec3_make(2.5f, 2.5f, 2.5f));
    struct transform rs = transform_multiply(&r, &s), mirror = transform_scale(vec3_make(-1, 1, 1));
    assert_float_equal(transform_uniform_scale(&rs), 2.5f, 1e-5f);
    assert_false(transform_flips_handedness(&rs));
    assert_true(transform_flips_handedness(&mirror));
    assert_float_equal(transform_uniform_scale(&mirror), 0, 0);
    struct transform stretched = transform_scale(vec3_make(1, 1, 1.01f));
    assert_float_equal(transform_uniform_scale(&stretched), 0, 0);
    const float shear[4][4] = {{1, 0.5f, 0, 0}, {0, 0.8660254f, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}}; // unit columns
    bool invertible;
    struct transform sheared = transform_from_matrix(shear, &invertible);
    assert_true(invertible);
    assert_float_equal(transform_uniform_scale(&sheared), 0, 0);
    const float flat[4][4] = {{1, 2, 3, 0}, {2, 4, 6, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}};
    transform_from_matrix(flat, &invertible);
    assert_false(invertible);
    const float perspective[4][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 0, 1}, {0, 0, 1, 0}};
    struct transform projected = transform_from_matrix(perspective, &invertible);
    assert_true(invertible);
    assert_vec3(transform_point(&projected, vec3_make(2, 4, 2)), 1, 2, 0.5f, 1e-6f);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_elements),
        cmocka_unit_test(test_look_at),
        cmocka_unit_test(test_order_and_inverse),
        cmocka_unit_test(test_classes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
