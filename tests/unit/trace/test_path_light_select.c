// The choice of a light: frequencies against the stated pmf, pmfs that sum to one, excluded and live lists.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <cmocka.h>

#include "trace/light_select.h"

enum { MAX_EMITTERS = 100 };

struct test_light {
    struct emitter emitter;
    vec3 p;
};

static bool sample_light(const struct emitter *emitter, vec3 p, vec2 u, struct light_sample *sample) {
    (void)u;
    vec3 offset = vec3_sub(((const struct test_light *)emitter)->p, p);
    sample->distance = vec3_length(offset);
    sample->direction = vec3_scale(offset, 1 / sample->distance);
    return true;
}

static const struct emitter_type point_type = {
    .name = "test", .sample_light = sample_light, .flags = EMITTER_DELTA_POSITION};

static void scene_make(struct scene *scene, struct test_light *lights, struct emitter **pointers, size_t count) {
    *scene = (struct scene){.emitters = pointers, .emitter_count = count, .bounds = {.radius = 10}};
    for (size_t i = 0; i < count; i++) {
        lights[i] = (struct test_light){{.type = &point_type,
                                         .flags = point_type.flags,
                                         .index = i,
                                         .bounds = scene->bounds,
                                         .power = rgb_gray(1 + i % 7)},
                                        {(float)i - 2, (float)(i % 3), 1}};
        pointers[i] = &lights[i].emitter;
    }
}

static void check_frequencies(size_t count) {
    struct test_light lights[MAX_EMITTERS];
    struct emitter *pointers[MAX_EMITTERS];
    struct scene scene;
    struct light_select *select;
    scene_make(&scene, lights, pointers, count);
    assert_int_equal(light_select_create(&select, &scene, NULL), STATUS_OK);
    struct light_point point = {{0.3f, 0.2f, 0}, -1, -1};
    enum { N = 200000 };
    size_t hits[MAX_EMITTERS] = {0};
    for (size_t i = 0; i < N; i++) {
        struct light_choice choice;
        assert_true(light_select_sample(select, &point, ((float)i + 0.5f) / N, &choice));
        assert_float_equal(choice.pmf, light_select_pmf_emitter(select, &point, choice.emitter), 1e-6);
        hits[choice.emitter->index]++;
    }
    double sum = 0;
    for (size_t i = 0; i < count; i++) {
        double pmf = light_select_pmf_emitter(select, &point, pointers[i]);
        assert_true(pmf > 0);
        assert_float_equal((double)hits[i] / N, pmf, 1e-4);
        sum += pmf;
    }
    assert_float_equal(sum, 1, 1e-4);
    light_select_destroy(select);
}

static void test_short_list(void **unused) {
    (void)unused;
    check_frequencies(1);
    check_frequencies(9);
}
static void test_long_list(void **unused) {
    (void)unused;
    check_frequencies(MAX_EMITTERS);
}

static void test_near_light_is_preferred(void **unused) {
    (void)unused;
    struct test_light lights[2];
    struct emitter *pointers[2];
    struct scene scene;
    struct light_select *select;
    scene_make(&scene, lights, pointers, 2);
    lights[0].p = (vec3){1, 0, 0};
    lights[1].p = (vec3){9, 0, 0};
    lights[1].emitter.power = lights[0].emitter.power;
    assert_int_equal(light_select_create(&select, &scene, NULL), STATUS_OK);
    struct light_point point = {{0, 0, 0}, -1, -1};
    // 0.1 / 2 uniform + 0.9 * 81 / 82 by inverse squares
    assert_float_equal(light_select_pmf_emitter(select, &point, pointers[0]), 0.05 + 0.9 * 81 / 82, 1e-3);
    light_select_destroy(select);
}

static void test_no_light(void **unused) {
    (void)unused;
    struct scene scene = {.bounds = {.radius = 1}};
    struct light_select *select;
    struct light_choice choice;
    assert_int_equal(light_select_create(&select, &scene, NULL), STATUS_OK);
    assert_false(light_select_sample(select, &(struct light_point){{0, 0, 0}, -1, -1}, 0.5f, &choice));
    light_select_destroy(select);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_short_list), cmocka_unit_test(test_long_list),
                                       cmocka_unit_test(test_near_light_is_preferred), cmocka_unit_test(test_no_light)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
