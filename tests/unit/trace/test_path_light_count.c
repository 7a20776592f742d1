// How many light samples a path draws where the camera looks: many where they are all that is noisy, one where they are
// not; and the mean and the noise of the film with them, before pixels share anything, against paths that draw one.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <cmocka.h>

#include "render_image.h"
#include "room_text.h"
#include "trace/path.h"
#include "trace/path_state.h"

struct counts {
    int least, most; // of the tiles
};

static void render(const char *xml, int passes, int threads, bool share, struct rendering *result,
                   struct counts *counts) {
    struct scene scene;
    struct error error = {0};
    struct film film;
    void *state;
    const struct run run = {.threads = threads, .seed = 9};
    if (scene_from_document(&scene, xml, &error)) fail_msg("%s", error.text);
    scene.share_light = share;
    assert_int_equal(film_init(&film, scene.sensor, &error), STATUS_OK);
    assert_int_equal(path_create(&scene, &run, PATH_MIS, &state, &error), STATUS_OK);
    for (int pass = 0; pass < passes; pass++) {
        assert_int_equal(path_integrator.render_pass(state, &film, (uint64_t)pass, &run, &error), STATUS_OK);
        film_end_pass(&film, threads);
    }
    const struct path_tracer *tracer = state;
    *counts = (struct counts){PATH_MOST_LIGHTS, 1};
    for (int tile = 0; tile < tracer->tile_count; tile++) {
        const int count = tracer->tile_lights[tile].count;
        *counts = (struct counts){mini(counts->least, count), maxi(counts->most, count)};
    }
    struct integrator_type alone = path_integrator;
    alone.finish = NULL;
    assert_int_equal(rendering_from_film(result, &alone, state, &film, &run, &error), STATUS_OK);
    path_integrator.destroy(state);
    film_fini(&film);
    scene_fini(&scene);
}

// Gloss, diffuse floor and half shadows under a panel, which scattering meets too.
#define HALF_SHADOWS(depth)                                                                                            \
    HEAD(depth, "64", "0,-1.9,0", "0,0.4,-1.1")                                                                        \
    SLAB("x='3' y='3' z='0.1'", "x='0' y='0' z='-1.1'",                                                                \
         "<bsdf type='roughplastic'><float name='alpha' value='0.2'/><rgb name='diffuse_reflectance' value='0.4 0.5 "  \
         "0.3'/></bsdf>")                                                                                              \
    SLAB("x='0.2' y='0.2' z='0.02'", "x='0.1' y='0.6' z='-0.3'", DIFFUSE("0.5"))                                       \
    PANEL("x='0.5' y='0.5'", "180", "x='0.2' y='0.6' z='1'", "9") "</scene>"

static void test_direct_light(void **unused) {
    (void)unused;
    enum { passes = 132 };
    struct rendering one, many;
    struct counts counts;
    render(HALF_SHADOWS("2"), passes, 2, false, &one, &counts);
    assert_int_equal(counts.most, 1);
    render(HALF_SHADOWS("2"), passes, 2, true, &many, &counts);
    assert_int_equal(counts.most, PATH_MOST_LIGHTS);
    for (int c = 0; c < 3; c++) {
        assert_true(one.error[c] < 0.01 * one.mean[c]); // else the comparison says nothing
        if (fabs(many.mean[c] - one.mean[c]) > 4 * hypot(many.error[c], one.error[c]))
            fail_msg("mean %g with many light samples, %g with one (errors %g, %g)", many.mean[c], one.mean[c],
                     many.error[c], one.error[c]);
        if (!(many.error[c] < 0.7 * one.error[c]))
            fail_msg("noise %g with many light samples, %g with one", many.error[c], one.error[c]);
    }
    image_fini(&one.image);
    image_fini(&many.image);
}

static void test_threads(void **unused) {
    (void)unused;
    struct rendering one, two;
    struct counts counts;
    render(HALF_SHADOWS("-1"), 20, 1, true, &one, &counts);
    render(HALF_SHADOWS("-1"), 20, 2, true, &two, &counts);
    for (int i = 0; i < 6 * one.width * one.height; i++) assert_true(one.image.pixels[i] == two.image.pixels[i]);
    image_fini(&one.image);
    image_fini(&two.image);
}

// No surface that the camera sees is lit but by others.
static void test_indirect_light(void **unused) {
    (void)unused;
    struct rendering room;
    struct counts counts;
    render(furnished_room, 20, 2, true, &room, &counts);
    if (counts.least != 1) fail_msg("%d to %d light samples", counts.least, counts.most);
    image_fini(&room.image);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_direct_light), cmocka_unit_test(test_threads),
                                       cmocka_unit_test(test_indirect_light)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
