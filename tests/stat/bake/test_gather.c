// Camera lines and particles are independent estimates of one light field: their fluxes agree within their noise, on a
// clear lamp, a frosted one and one with a coloured absorber. The emitted flux has a closed form.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bake/lamp_proxy.h"
#include "bake/survey.h"
#include "scene_from_text.h"

#define BULB                                                                                                           \
    "<shape type=\"sphere\"><float name=\"radius\" value=\"0.1\"/>"                                                    \
    "<emitter type=\"area\"><rgb name=\"radiance\" value=\"10, 20, 5\"/></emitter></shape>"
#define SHELL(bsdf) "<shape type=\"sphere\"><float name=\"radius\" value=\"0.5\"/>" bsdf "</shape>"
#define WALL                                                                                                           \
    "<shape type=\"cube\"><transform name=\"to_world\"><scale x=\"0.1\" y=\"0.6\" z=\"0.6\"/><translate "              \
    "x=\"0.8\"/></transform>"                                                                                          \
    "<bsdf type=\"diffuse\"><rgb name=\"reflectance\" value=\"0.8, 0.4, 0.2\"/></bsdf></shape>"

struct flux {
    double mean[3], error[3];
};

static struct flux trace_both(const char *body, struct flux *by_camera, float *clear_share) {
    struct scene scene;
    struct error error = {.text = ""};
    if (scene_from_text(&scene, body, &error) != STATUS_OK) fail_msg("%s", error.text);
    struct lamp lamp = {.scene = &scene, .seed = 3, .threads = 2};
    assert_int_equal(lamp_proxy_fit(&lamp.proxy, &scene, BAKE_PROXY_AUTO, NULL, NULL, &error), STATUS_OK);
    assert_int_equal(proxy_shape_init(&lamp.shape, &lamp.proxy, &error), STATUS_OK);
    struct survey survey = {0};
    assert_int_equal(survey_clusters(&survey, &lamp, &error), STATUS_OK);
    struct aim aims[SURVEY_CLUSTERS];
    for (size_t i = 0; i < survey.cluster_count; i++)
        aims[i] = (struct aim){survey.clusters[i].center, 1.05f * survey.clusters[i].radius};
    lamp.aims = aims;
    lamp.aim_count = survey.cluster_count;
    assert_int_equal(survey_exits(&survey, &lamp, STREAM_SURVEY, 400000, NULL, &error), STATUS_OK);
    const struct proxy *proxy = &lamp.proxy;
    struct line_guide_options guide_options = {{proxy->center[0], proxy->center[1], proxy->center[2]},
                                               proxy->radius,
                                               survey.exits.exits,
                                               survey.exits.count,
                                               0.5f,
                                               survey.clusters,
                                               survey.cluster_count,
                                               0.5f * survey.clear_share};
    struct line_guide *guide;
    assert_int_equal(line_guide_create(&guide, &guide_options, &error), STATUS_OK);
    enum { N = 200000 }; // each traced twice
    struct line_sample *lines = malloc(2 * N * sizeof *lines), *again = lines + N;
    assert_non_null(lines);
    gather_lines(lines, &lamp, guide, STREAM_TRAINING, 0, N, true);
    memcpy(again, lines, N * sizeof *lines);
    gather_again(again, &lamp, STREAM_TRAINING, N);
    struct flux by_particles = {0};
    for (int c = 0; c < 3; c++) {
        double sum = 0, squares = 0;
        for (size_t i = 0; i < N; i++) {
            double y = 0.5 * (double)(lines[i].target[c] + again[i].target[c]);
            sum += y;
            squares += y * y;
        }
        by_camera->mean[c] = sum / N;
        by_camera->error[c] = sqrt((squares / N - sum / N * (sum / N)) / N);
        by_particles.mean[c] = survey.flux[c];
        by_particles.error[c] = survey.flux[c] * survey.flux_noise[c];
    }
    *clear_share = survey.clear_share;
    free(lines);
    line_guide_destroy(guide);
    survey_fini(&survey);
    proxy_shape_fini(&lamp.shape);
    scene_fini(&scene);
    return by_particles;
}

static void assert_agree(const struct flux *a, const struct flux *b) {
    for (int c = 0; c < 3; c++) {
        double noise = hypot(a->error[c], b->error[c]);
        if (fabs(a->mean[c] - b->mean[c]) > 4.5 * noise)
            fail_msg("channel %d: particles %g +- %g, camera lines %g +- %g", c, a->mean[c], a->error[c], b->mean[c],
                     b->error[c]);
        assert_true(noise < 0.03 * a->mean[c]);
    }
}

static void bare_bulb(void **state) {
    (void)state;
    struct flux camera, particles;
    float clear;
    particles = trace_both(BULB, &camera, &clear);
    const double radiance[3] = {10, 20, 5};
    for (int c = 0; c < 3; c++) {
        double exact = 4 * M_PI * M_PI * 0.01 * radiance[c];
        assert_true(fabs(particles.mean[c] / exact - 1) < 1e-3);
        assert_true(fabs(camera.mean[c] - exact) < 4.5 * camera.error[c]);
    }
    assert_true(clear > 0.99f);
}

static void clear_glass(void **state) {
    (void)state;
    struct flux camera, particles;
    float clear;
    particles = trace_both(BULB SHELL("<bsdf type=\"dielectric\"/>") WALL, &camera, &clear);
    assert_agree(&particles, &camera);
    assert_true(clear > 0.3f);
}

static void frosted_glass(void **state) {
    (void)state;
    struct flux camera, particles;
    float clear;
    particles =
        trace_both(BULB SHELL("<bsdf type=\"roughdielectric\"><float name=\"alpha\" value=\"0.5\"/></bsdf>") WALL,
                   &camera, &clear);
    assert_agree(&particles, &camera);
    assert_true(clear < 0.7f);
}

// A diffuse ball of reflectance 1/2: half of the light that meets it leaves; how much of that onward follows from the
// phase function of a Lambertian sphere, sin a + (pi - a) cos a at the angle a between the two directions (Schoenberg
// 1925).
static void light_leaves_a_ball(void **state) {
    (void)state;
    struct scene scene;
    struct error error = {0};
    assert_int_equal(scene_from_text(&scene, SHELL("<bsdf type=\"diffuse\"/>"), &error), STATUS_OK);
    struct lamp lamp = {.scene = &scene, .seed = 3, .threads = 2};
    assert_int_equal(lamp_proxy_fit(&lamp.proxy, &scene, BAKE_PROXY_AUTO, NULL, NULL, &error), STATUS_OK);
    assert_int_equal(proxy_shape_init(&lamp.shape, &lamp.proxy, &error), STATUS_OK);
    enum { N = 100000 };
    struct line_sample *lines = calloc(N, sizeof *lines);
    assert_non_null(lines);
    double mean[3] = {0}; // through, all, onward
    for (int kind = 0; kind < 3; kind++) {
        if (kind == 0)
            gather_transmittance(lines, &lamp, STREAM_SCATTERING, 0, N, 1, 0, NULL);
        else
            gather_escapes(lines, &lamp, STREAM_SCATTERING, N, kind == 2);
        for (size_t i = 0; i < N; i++) mean[kind] += (double)lines[i].target[1] / N;
    }
    double side[2] = {0, 0}; // back, onward
    for (int i = 0; i < 10000; i++) {
        const double a = M_PI * (i + 0.5) / 10000;
        side[a > M_PI / 2] += (sin(a) + (M_PI - a) * cos(a)) * sin(a);
    }
    const double stopped = 1 - mean[0], noise = 1 / sqrt(N);
    assert_true(stopped > 0.9);
    assert_true(fabs(mean[1] - mean[0] - 0.5 * stopped) < 1e-4);
    assert_true(fabs(mean[2] - mean[0] - 0.5 * stopped * side[1] / (side[0] + side[1])) < noise);
    assert_true(mean[2] - mean[0] > 10 * noise);
    free(lines);
    proxy_shape_fini(&lamp.shape);
    scene_fini(&scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(bare_bulb), cmocka_unit_test(clear_glass),
                                       cmocka_unit_test(frosted_glass), cmocka_unit_test(light_leaves_a_ball)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
