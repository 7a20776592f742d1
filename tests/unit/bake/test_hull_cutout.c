// Cut-outs: of a surface that a checkerboard of opacity cuts, half of the area is left, and only what is there.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <cmocka.h>

#include "bake/hull_cutout.h"
#include "scene_from_text.h"

#define OPACITY(color0, color1)                                                                                        \
    "<bsdf type='mask'><texture name='opacity' type='checkerboard'><rgb name='color0' value='" color0 "'/>"            \
    "<rgb name='color1' value='" color1 "'/><transform name='to_uv'><scale x='6' y='4'/></transform></texture>"        \
    "<bsdf type='diffuse'/></bsdf>"

struct sums {
    double area;
    size_t count;
    vec3 normal;
};

static void add(void *user, const struct cutout_piece *piece) {
    struct sums *sums = user;
    const vec3 *p = piece->p;
    sums->area += 0.5 * (double)vec3_length(vec3_cross(vec3_sub(p[1], p[0]), vec3_sub(p[2], p[0])));
    sums->normal = vec3_add(sums->normal, piece->normal);
    sums->count++;
}

static void load(struct scene *scene, const char *text) {
    struct error error;
    assert_int_equal(scene_from_text(scene, text, &error), STATUS_OK);
}

static void rectangle_is_half_there(void **unused) {
    (void)unused;
    struct scene scene;
    load(&scene, "<shape type='rectangle'>" OPACITY("1", "0") "</shape><emitter type='point'/>");
    const struct shape *shape = scene.shapes[0];
    assert_true(hull_shape_is_cutout(shape));
    struct sums sums = {0};
    hull_cut(shape, 0.01f, add, &sums);
    assert_true(fabs(sums.area - 2) < 0.02); // of 4
    assert_true(sums.count > 100 && sums.count < 40000);
    assert_float_equal(sums.normal.z, (float)sums.count, 0.5f);
    scene_fini(&scene);
}

static void analytic_surface_is_half_there(void **unused) {
    (void)unused;
    struct scene scene;
    load(&scene, "<shape type='cylinder'>" OPACITY("1", "0") "</shape><emitter type='point'/>");
    assert_true(hull_shape_is_cutout(scene.shapes[0]));
    struct sums sums = {0};
    hull_cut(scene.shapes[0], 0.01f, add, &sums);
    assert_true(fabs(sums.area / M_PI - 1) < 0.02); // of 2 pi
    scene_fini(&scene);
}

static void sheer_cloth_is_none(void **unused) {
    (void)unused;
    struct scene scene;
    load(&scene, "<shape type='rectangle'>" OPACITY("0.7", "0.2") "</shape><shape type='sphere'><bsdf "
                                                                  "type='diffuse'/></shape><emitter type='point'/>");
    for (size_t i = 0; i < scene.shape_count; i++) assert_false(hull_shape_is_cutout(scene.shapes[i]));
    scene_fini(&scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(rectangle_is_half_there),
                                       cmocka_unit_test(analytic_surface_is_half_there),
                                       cmocka_unit_test(sheer_cloth_is_none)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
