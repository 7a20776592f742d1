// Clusters of emission: one to each bulb, however near to each other for the lamp's size, and few on a long tube.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <cmocka.h>

#include "scene_from_text.h"
#include "trace/emission_cluster.h"

static size_t find(const char *text, struct emission_cluster clusters[EMISSION_CLUSTERS]) {
    struct scene scene;
    struct error error;
    size_t count;
    assert_int_equal(scene_from_text(&scene, text, &error), STATUS_OK);
    assert_int_equal(emission_clusters_find(clusters, &count, &scene, -1, 1, &error), STATUS_OK);
    scene_fini(&scene);
    return count;
}

static void test_bulbs(void **unused) {
    (void)unused;
    enum { SIDE = 6 };
    char text[SIDE * SIDE * 256] = "";
    size_t used = 0;
    for (int i = 0; i < SIDE * SIDE; i++)
        used += (size_t)snprintf(text + used, sizeof text - used,
                                 "<shape type='sphere'><point name='center' x='%g' y='%g' z='0'/><float name='radius' "
                                 "value='0.01'/><emitter type='area'/></shape>",
                                 0.1 * (i % SIDE), 0.1 * (i / SIDE));
    struct emission_cluster clusters[EMISSION_CLUSTERS];
    assert_int_equal(find(text, clusters), SIDE * SIDE);
    for (int i = 0; i < SIDE * SIDE; i++) {
        assert_true(clusters[i].radius < 0.0125f);
        assert_float_equal(clusters[i].share, 1.0 / (SIDE * SIDE), 0.01);
    }
}

static void test_tube(void **unused) {
    (void)unused;
    struct emission_cluster clusters[EMISSION_CLUSTERS];
    size_t count = find("<shape type='cylinder'><point name='p0' x='-1' y='0' z='0'/>"
                        "<point name='p1' x='1' y='0' z='0'/><float name='radius' value='0.01'/>"
                        "<emitter type='area'/></shape>",
                        clusters);
    assert_in_range(count, 5, 16);
    for (size_t i = 0; i < count; i++) assert_true(clusters[i].radius < 0.22f);
}

static float beads_reach(const char *text, size_t count, float (*beads)[3]) {
    struct scene scene;
    struct error error;
    float reach;
    assert_int_equal(scene_from_text(&scene, text, &error), STATUS_OK);
    assert_int_equal(emission_beads_find(beads, count, &reach, &scene, -1, &error), STATUS_OK);
    scene_fini(&scene);
    return reach;
}

static void test_beads(void **unused) {
    (void)unused;
    const char *tube = "<shape type='cylinder'><point name='p0' x='-1' y='0' z='0'/>"
                       "<point name='p1' x='1' y='0' z='0'/><float name='radius' value='0.01'/>"
                       "<emitter type='area'/></shape>";
    const char *ball = "<shape type='sphere'><emitter type='area'/></shape>";
    float beads[EMISSION_BEADS][3];
    const float tube_ratio = beads_reach(tube, 32, beads) / beads_reach(tube, 16, beads);
    assert_true(tube_ratio > 0.4f && tube_ratio < 0.6f);
    const float ball_ratio = beads_reach(ball, 32, beads) / beads_reach(ball, 16, beads);
    assert_true(ball_ratio > 0.62f && ball_ratio < 0.8f);
    beads_reach(tube, 32, beads);
    for (int place = 0; place < 32; place++) { // one to each thirty-second of the tube, nearly
        float nearest = 2;
        for (int i = 0; i < 32; i++) nearest = fminf(nearest, fabsf(beads[i][0] + 1 - ((float)place + 0.5f) / 16));
        assert_true(nearest < 0.05f);
    }
    for (int i = 0; i < 32; i++) assert_true(hypotf(beads[i][1], beads[i][2]) < 0.005f); // on its axis
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_bulbs), cmocka_unit_test(test_tube),
                                       cmocka_unit_test(test_beads)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
