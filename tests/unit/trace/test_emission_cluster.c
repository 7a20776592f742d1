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

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_bulbs), cmocka_unit_test(test_tube)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
