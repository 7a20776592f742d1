// Rays against hulls: glass slabs and prisms by Fresnel and Snell, opaque and translucent parts, and every triangle
// found as by a plain loop over all of them.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "luminaire/hull_tree.h"
#include "math/sampler.h"
#include "math/warp.h"

static const float straight = 0.866f;

// Axis-aligned boxes within [-1, 1]^3, one part each.
static struct hull *make_boxes(size_t count, const float (*boxes)[6], const struct hull_part *parts) {
    static const uint16_t corners[12][3] = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                                            {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
    struct hull *hull;
    struct error error;
    assert_int_equal(hull_allocate(&hull, 8 * count, 12 * count, &error), STATUS_OK);
    for (int a = 0; a < 3; a++) {
        hull->lower[a] = -1;
        hull->step[a] = 2.0f / HULL_MAX_CODE;
    }
    hull->part_count = count;
    for (size_t b = 0; b < count; b++) {
        hull->parts[b] = parts[b];
        hull->parts[b].first = (uint32_t)(12 * b);
        hull->parts[b].count = 12;
        for (int v = 0; v < 8; v++)
            hull_set_vertex(
                hull, 8 * b + (size_t)v,
                (vec3){boxes[b][v & 1 ? 3 : 0], boxes[b][v >> 1 & 1 ? 4 : 1], boxes[b][v >> 2 & 1 ? 5 : 2]});
        for (int t = 0; t < 12; t++)
            for (int k = 0; k < 3; k++) hull->triangles[12 * b + t][k] = (uint16_t)(8 * b + corners[t][k]);
    }
    return hull;
}

static struct hull_crossing cross_boxes(size_t count, const float (*boxes)[6], const struct hull_part *parts,
                                        vec3 origin, vec3 direction) {
    struct hull *hull = make_boxes(count, boxes, parts);
    struct hull_tree *tree;
    struct error error;
    struct hull_crossing crossing;
    assert_int_equal(hull_tree_create(&tree, hull, &error), STATUS_OK);
    hull_destroy(hull);
    hull_tree_cross(tree, origin, vec3_normalize(direction), straight, &crossing);
    hull_tree_destroy(tree);
    return crossing;
}

static const float slab[6] = {-0.8f, -0.8f, -0.1f, 0.8f, 0.8f, 0.1f};

static void glass_follows_fresnel(void **state) {
    (void)state;
    const struct hull_part glass = {.kind = HULL_GLASS, .eta = 1.5f, .sigma_a = {0, 1, 2}};
    struct hull_crossing x = cross_boxes(1, &slab, &glass, (vec3){0.05f, 0.01f, 1}, (vec3){0, 0, -1});
    assert_int_equal(x.answer, HULL_SOLVED);
    for (int c = 0; c < 3; c++) assert_true(fabsf(x.transmittance[c] - 0.96f * 0.96f * expf(-0.2f * c)) < 1e-4f);
    // At Brewster's angle half of the light, polarised in the plane, passes whole; the slab does not turn the ray.
    float sin_in = 1.5f / sqrtf(3.25f), cos_in = 1 / sqrtf(3.25f), r = (1 - 1.5f * 1.5f) / (1 + 1.5f * 1.5f);
    x = cross_boxes(1, &slab, &glass, (vec3){-sin_in, 0.01f, cos_in}, (vec3){sin_in, 0, -cos_in});
    assert_true(fabsf(x.transmittance[0] - (1 - 0.5f * r * r) * (1 - 0.5f * r * r)) < 1e-4f);
    // In through one side and out through the next: total reflection.
    x = cross_boxes(1, &slab, &glass, (vec3){0.65f, 0.01f, 0.3f}, (vec3){0.2f, 0, -0.35f});
    assert_int_equal(x.answer, HULL_SOLVED);
    assert_true(x.transmittance[0] == 0);
    x = cross_boxes(1, &slab, &glass, (vec3){0.95f, 0, 1}, (vec3){0, 0, -1});
    assert_int_equal(x.answer, HULL_MISSED);
    assert_true(x.transmittance[2] == 1);
}

static void parts_answer_by_kind(void **state) {
    (void)state;
    const float boxes[2][6] = {{-0.3f, -0.3f, 0.4f, 0.3f, 0.3f, 0.9f}, {-0.8f, -0.8f, -0.1f, 0.8f, 0.8f, 0.1f}};
    const struct hull_part frosted[2] = {{.kind = HULL_TRANSLUCENT}, {.kind = HULL_TRANSLUCENT}};
    const struct hull_part mixed[2] = {{.kind = HULL_TRANSLUCENT}, {.kind = HULL_OPAQUE}};
    const vec3 from = {0.1f, 0.05f, 1}, down = {0, 0, -1};
    struct hull_crossing x = cross_boxes(2, boxes, frosted, from, down);
    assert_int_equal(x.answer, HULL_DIFFUSED);
    assert_int_equal(x.layers, 4);
    assert_false(x.blocked);
    assert_true(fabsf(x.point[2] - 0.9f) < 1e-4f && x.normal[2] > 0.999f);
    x = cross_boxes(2, boxes, mixed, from, down);
    assert_int_equal(x.answer, HULL_DIFFUSED);
    assert_int_equal(x.layers, 2);
    assert_true(x.blocked);
    x = cross_boxes(2, boxes, mixed, (vec3){0.5f, 0, 1}, down);
    assert_int_equal(x.answer, HULL_SOLVED);
    assert_true(x.transmittance[0] == 0);
}

// Many small opaque boxes: a ray is blocked exactly if it meets one of them.
static void no_triangle_is_lost(void **state) {
    (void)state;
    enum { BOXES = 60, RAYS = 4000 };
    float boxes[BOXES][6];
    struct hull_part parts[BOXES] = {{.kind = HULL_OPAQUE}};
    for (int b = 0; b < BOXES; b++) {
        struct sampler s = sampler_make(5, 0, (uint64_t)b);
        for (int a = 0; a < 3; a++) {
            boxes[b][a] = -0.9f + 1.6f * sampler_1d(&s);
            boxes[b][3 + a] = boxes[b][a] + 0.02f + 0.15f * sampler_1d(&s);
        }
    }
    struct hull *hull = make_boxes(BOXES, (const float(*)[6])boxes, parts);
    struct hull_tree *tree;
    struct error error;
    assert_int_equal(hull_tree_create(&tree, hull, &error), STATUS_OK);
    int blocked = 0, differ = 0;
    for (int i = 0; i < RAYS; i++) {
        struct sampler s = sampler_make(6, 0, (uint64_t)i);
        vec3 origin = vec3_scale(warp_uniform_sphere(sampler_2d(&s)), 2);
        vec3 target = vec3_scale(warp_uniform_sphere(sampler_2d(&s)), sampler_1d(&s));
        vec3 d = vec3_normalize(vec3_sub(target, origin));
        const float o[3] = {origin.x, origin.y, origin.z}, inverse[3] = {1 / d.x, 1 / d.y, 1 / d.z};
        bool expected = false;
        for (int b = 0; b < BOXES; b++) {
            float near = 0, far = INFINITY;
            for (int a = 0; a < 3; a++) {
                float t0 = (boxes[b][a] - o[a]) * inverse[a], t1 = (boxes[b][3 + a] - o[a]) * inverse[a];
                near = fmaxf(near, fminf(t0, t1));
                far = fminf(far, fmaxf(t0, t1));
            }
            expected = expected || near <= far;
        }
        struct hull_crossing x;
        hull_tree_cross(tree, origin, d, straight, &x);
        blocked += expected;
        differ += expected != (x.answer == HULL_SOLVED && x.transmittance[0] == 0);
    }
    assert_true(blocked > RAYS / 10 && blocked < RAYS * 9 / 10);
    assert_true(differ <= 4); // the hull is quantised
    hull_tree_destroy(tree);
    hull_destroy(hull);
}

// A ball of 3 degrees' steps with the ball's own normals lets through what a ball does: Fresnel twice, up to the offset
// from which a line is turned by more than 30 degrees. With the triangles' normals it is 0.009 off.
static void smooth_glass_bends_as_a_ball(void **state) {
    (void)state;
    enum { ROWS = 60, COLUMNS = 120, LINES = 4000 };
    const float eta = 1.5f, radius = 0.7f;
    struct hull *hull;
    struct hull_tree *tree;
    struct error error;
    assert_int_equal(hull_allocate(&hull, (ROWS + 1) * COLUMNS, 2 * ROWS * COLUMNS, &error), STATUS_OK);
    for (int a = 0; a < 3; a++) hull->lower[a] = -1, hull->step[a] = 2.0f / HULL_MAX_CODE;
    hull->part_count = 1;
    hull->parts[0] = (struct hull_part){.kind = HULL_GLASS, .smooth = true, .eta = eta, .count = 2 * ROWS * COLUMNS};
    for (int y = 0; y <= ROWS; y++)
        for (int x = 0; x < COLUMNS; x++) {
            const float theta = PI_F * (float)y / ROWS, phi = 2 * PI_F * (float)x / COLUMNS;
            const vec3 n = {sinf(theta) * cosf(phi), sinf(theta) * sinf(phi), cosf(theta)};
            hull_set_vertex(hull, (size_t)(y * COLUMNS + x), vec3_scale(n, radius));
            hull_set_normal(hull, (size_t)(y * COLUMNS + x), n);
        }
    for (int y = 0, t = 0; y < ROWS; y++)
        for (int x = 0; x < COLUMNS; x++, t += 2) {
            const int right = (x + 1) % COLUMNS, at = y * COLUMNS, below = at + COLUMNS;
            const int two[2][3] = {{at + x, below + x, below + right}, {at + x, below + right, at + right}};
            for (int k = 0; k < 6; k++) hull->triangles[t + k / 3][k % 3] = (uint16_t)two[k / 3][k % 3];
        }
    assert_int_equal(hull_tree_create(&tree, hull, &error), STATUS_OK);
    double off = 0;
    for (int i = 0; i < LINES; i++) {
        struct sampler s = sampler_make(9, 0, (uint64_t)i);
        const vec3 d = warp_uniform_sphere(sampler_2d(&s));
        const struct frame frame = frame_from_normal(d);
        const vec2 disk = warp_concentric_disk(sampler_2d(&s));
        const vec3 origin = vec3_mad(d, -2, vec3_scale(vec3_mad(frame.s, disk.x, vec3_scale(frame.t, disk.y)), radius));
        const double sine = hypot((double)disk.x, (double)disk.y), in = asin(fmin(sine, 1)),
                     out = asin(fmin(sine, 1) / (double)eta);
        const double rs = sin(in - out) / sin(in + out), rp = tan(in - out) / tan(in + out); // Fresnel's equations
        const double through = 1 - 0.5 * (rs * rs + rp * rp);
        struct hull_crossing x;
        hull_tree_cross(tree, origin, d, cosf(PI_F / 6), &x);
        off += fabs((double)x.transmittance[0] - (2 * (in - out) < M_PI / 6 ? through * through : 0)) / LINES;
    }
    printf("glass ball: transmittance off by %.4f\n", off);
    assert_true(off < 0.002);
    hull_tree_destroy(tree);
    hull_destroy(hull);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(glass_follows_fresnel), cmocka_unit_test(parts_answer_by_kind),
                                       cmocka_unit_test(no_triangle_is_lost),
                                       cmocka_unit_test(smooth_glass_bends_as_a_ball)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
