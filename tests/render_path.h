// For tests of the path tracer alone: its strategies, and what it makes of earlier passes. Include cmocka.h first.
#pragma once

#include "render_image.h"
#include "trace/path.h"

struct path_test {
    enum path_strategy strategy;
    int passes, threads;
    uint64_t seed;
    bool forgetful; // every pass is rendered as if it were the first
    bool share; // paths may end in the cache of radiance, and pixels share light
};

static inline void render_path(const char *xml, const struct path_test *test, struct rendering *result,
                               size_t *dropped) {
    struct scene scene;
    struct error error = {0};
    const struct run run = {.threads = test->threads, .seed = test->seed};
    if (scene_from_document(&scene, xml, &error) != STATUS_OK) fail_msg("%s", error.text);
    scene.share_light = test->share;
    void *state;
    struct film film;
    assert_int_equal(film_init(&film, scene.sensor, &error), STATUS_OK);
    assert_int_equal(path_create(&scene, &run, test->strategy, &state, &error), STATUS_OK);
    for (int pass = 0; pass < test->passes; pass++) {
        struct film first = film;
        first.pass_count = 0;
        assert_int_equal(
            path_integrator.render_pass(state, test->forgetful ? &first : &film, (uint64_t)pass, &run, &error),
            STATUS_OK);
        film_end_pass(&film, 1);
    }
    *dropped = path_dropped(state);
    assert_int_equal(rendering_from_film(result, &path_integrator, state, &film, &run, &error), STATUS_OK);
    path_integrator.destroy(state);
    film_fini(&film);
    scene_fini(&scene);
}
