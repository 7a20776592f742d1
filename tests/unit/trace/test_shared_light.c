// Light that pixels share: made-up samples of a textured plane whose light is known, with a step in it, beside another
// surface or another side of the same and on a film that was begun earlier, with single bright paths, and lit by
// splats; what paths tell against what the film holds; and a furnished room with and without sharing,
// against a long rendering.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#include "image/metric.h"
#include "math/sampler.h"
#include "render_path.h"
#include "room_text.h"
#include "trace/path_state.h"

enum { WIDTH = 70, HEIGHT = 50, PIXELS = WIDTH * HEIGHT, PART = 2 };

struct plane {
    int passes;
    bool steps; // the light, in the middle
    bool two; // surfaces, each half of the plane; the pixels between see both
    bool bent; // the two are sides of one
    bool spot; // in the middle the light is ten times as much
    float flash; // what a single path brings more, there
    float noise; // relative
};

struct picture { // one channel
    double before[PIXELS], after[PIXELS], truth[PIXELS]; // truth: of the samples with the light that is there
};

static bool is_right(const struct plane *plane, int x, float u) {
    return x > WIDTH / 2 || (x == WIDTH / 2 && (!plane->two || u < 0.3f));
}

static bool is_middle(size_t pixel) { return pixel == PIXELS / 2 + WIDTH / 2; }

static float light_at(const struct plane *plane, int x, int y, bool right) {
    if (plane->spot && is_middle((size_t)(y * WIDTH + x))) return 10;
    if (plane->flash > 0) return 1;
    if (plane->two) return right ? 100 : 1;
    if (plane->steps) return right ? 3 : 1;
    if (plane->spot) return 1;
    return 1 + 0.01f * (float)x + 0.02f * (float)y;
}

// Of the same mean, and seldom much above it.
static float disturbed(float light, float noise, float u) { return light * (1 - noise + (u < 0.1f ? 10 * noise : 0)); }

static void make_picture(const struct plane *plane, int threads, size_t earlier, struct picture *picture) {
    struct error error;
    struct shared_light *shared;
    struct image image;
    assert_int_equal(shared_light_create(&shared, WIDTH, HEIGHT, &error), STATUS_OK);
    assert_int_equal(image_init(&image, WIDTH, HEIGHT, 6, &error), STATUS_OK);
    const size_t passes = (size_t)plane->passes + earlier;
    for (size_t i = 0; i < PIXELS; i++) {
        const int x = (int)i % WIDTH, y = (int)i / WIDTH;
        const float texture = plane->flash > 0 ? 0.5f : 0.2f + 0.7f * (float)((x / 3 + y / 2) % 2);
        double sum = 0, truth = 0;
        for (int pass = 0; pass < plane->passes; pass++) {
            struct sampler sampler = sampler_make(3, i, (uint64_t)pass);
            const vec2 u = sampler_2d(&sampler);
            const bool right = is_right(plane, x, sampler_1d(&sampler));
            const float light = light_at(plane, x, y, right);
            struct shared_sample sample = {
                .surface = plane->two && !plane->bent ? 1 + right : 1,
                .p = {(float)x + u.x, (float)y + u.y, plane->bent && right ? 0.75f * (WIDTH / 2 - (float)x - u.x) : 0},
                .n = {plane->bent && right ? 0.6f : 0, 0, plane->bent && right ? 0.8f : 1}};
            sample.weight[PART % SHARED_WEIGHTS] = rgb_gray(texture);
            sample.light[PART] = rgb_gray(disturbed(light, plane->noise, sampler_1d(&sampler)));
            if (is_middle(i) && pass == 3) sample.light[PART] = rgb_add(sample.light[PART], rgb_gray(plane->flash));
            sum += (double)(texture * sample.light[PART].g);
            truth += (double)(texture * light);
            shared_light_add(shared, i, &sample, 1);
        }
        picture->truth[i] = truth / plane->passes;
        picture->before[i] = (sum + (double)earlier * picture->truth[i]) / (double)passes;
        for (size_t c = 0; c < 3; c++) image.pixels[6 * i + c] = (float)picture->before[i];
    }
    assert_int_equal(shared_light_apply(shared, passes, &image, &(struct run){.threads = threads}, &error), STATUS_OK);
    for (size_t i = 0; i < PIXELS; i++) picture->after[i] = (double)image.pixels[6 * i + 1];
    image_fini(&image);
    shared_light_destroy(shared);
}

static double mean_of(const double *values) {
    double sum = 0;
    for (size_t i = 0; i < PIXELS; i++) sum += values[i] / PIXELS;
    return sum;
}

// Over the columns from x0 to x1.
static double squared_error(const double *values, const struct picture *picture, int x0, int x1) {
    double sum = 0;
    for (int y = 0; y < HEIGHT; y++)
        for (int x = x0; x < x1; x++) {
            const double apart = values[y * WIDTH + x] - picture->truth[y * WIDTH + x];
            sum += apart * apart / (HEIGHT * (x1 - x0));
        }
    return sum;
}

static void test_smooth_light(void **unused) {
    (void)unused;
    static struct picture picture, again;
    for (int passes = 4; passes <= 64; passes *= 4) {
        const struct plane plane = {.passes = passes, .noise = 0.7f};
        make_picture(&plane, 1, 0, &picture);
        make_picture(&plane, 3, 0, &again);
        assert_memory_equal(picture.after, again.after, sizeof picture.after);
        const double before = squared_error(picture.before, &picture, 0, WIDTH),
                     after = squared_error(picture.after, &picture, 0, WIDTH);
        // Of four passes a third of the pixels have a bright sample: some are taken for outliers.
        if (!(after < (passes == 4 ? 0.15 : 0.1) * before)) fail_msg("%d passes: %g -> %g", passes, before, after);
        const double mean = mean_of(picture.truth);
        const double allowed = 4 * sqrt(before / PIXELS) + (passes < 16 ? 0.02 : 0.005) * mean;
        if (fabs(mean_of(picture.after) - mean) > allowed)
            fail_msg("%d passes: mean %g for %g", passes, mean_of(picture.after), mean);
    }
}

// Nothing becomes worse where neighbours differ; what they say decides less the more is known.
static void test_step(void **unused) {
    (void)unused;
    static struct picture picture;
    double apart = 0;
    for (int passes = 64; passes <= 1024; passes *= 16) {
        make_picture(&(struct plane){.passes = passes, .steps = true, .noise = 0.3f}, 2, 0, &picture);
        const double before = squared_error(picture.before, &picture, 0, WIDTH),
                     after = squared_error(picture.after, &picture, 0, WIDTH);
        if (!(after < before)) fail_msg("%d passes: %g -> %g", passes, before, after);
        double edge = 0;
        for (int y = 0; y < HEIGHT; y++)
            for (int x = WIDTH / 2 - 1; x <= WIDTH / 2; x++) {
                const size_t i = (size_t)(y * WIDTH + x);
                edge += fabs(picture.after[i] - picture.truth[i]) / picture.truth[i] / (2 * HEIGHT);
            }
        if (!(edge < (passes == 64 ? 0.15 : 0.04))) fail_msg("%d passes: %g off beside the step", passes, edge);
        if (passes > 64) assert_true(edge < 0.5 * apart);
        apart = edge;
    }
}

static void look_between(bool bent) {
    static struct picture picture;
    enum { middle = WIDTH / 2 };
    make_picture(&(struct plane){.passes = 16, .two = true, .bent = bent, .noise = 0.7f}, 2, 0, &picture);
    double left = 0;
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < middle; x++) {
            const size_t i = (size_t)(y * WIDTH + x);
            left = fmax(left, picture.after[i] / picture.truth[i]);
        }
    assert_true(left < 4); // the other surface has a hundred times the light
    const double before = squared_error(picture.before, &picture, middle, middle + 1);
    const double after = squared_error(picture.after, &picture, middle, middle + 1);
    if (!(after < 0.3 * before)) fail_msg("between them %g -> %g", before, after);
}

static void test_other_surface(void **unused) {
    (void)unused;
    look_between(false);
    look_between(true);
}

// What a single path brings is spread so that no spot is left, and nothing is lost.
static void test_flash(void **unused) {
    (void)unused;
    static struct picture picture;
    const struct plane plane = {.passes = 16, .noise = 0.1f, .flash = 1000};
    make_picture(&plane, 2, 0, &picture);
    double most = 0;
    for (size_t i = 0; i < PIXELS; i++) most = fmax(most, picture.after[i] / picture.truth[i]);
    if (!(most < 2.5)) fail_msg("%g times too bright", most);
    const double before = mean_of(picture.before), after = mean_of(picture.after),
                 flash = before - mean_of(picture.truth);
    if (!(fabs(after - before) < 0.02 * flash)) fail_msg("mean %g -> %g, flash %g", before, after, flash);
}

static void test_true_spot(void **unused) {
    (void)unused;
    static struct picture picture;
    make_picture(&(struct plane){.passes = 256, .noise = 0.2f, .spot = true}, 2, 0, &picture);
    for (size_t i = 0; i < PIXELS; i++)
        if (fabs(picture.after[i] / picture.truth[i] - 1) > 0.1)
            fail_msg("pixel %zu: %g for %g", i, picture.after[i], picture.truth[i]);
}

// Splats of 1 on an evenly coloured plane whose paths bring nothing; those on another surface stay where they are.
static void test_splats(void **unused) {
    (void)unused;
    enum { passes = 16 };
    struct error error;
    struct shared_light *shared;
    struct image image;
    assert_int_equal(shared_light_create(&shared, WIDTH, HEIGHT, &error), STATUS_OK);
    assert_int_equal(image_init(&image, WIDTH, HEIGHT, 6, &error), STATUS_OK);
    const rgb weight = rgb_gray(0.5f), lit = rgb_gray(1);
    struct shared_splat here = {1, {0, 0, 1}, PART, {lit, rgb_gray(0)}, {weight, lit}}, there = here;
    there.surface = 2;
    double before = 0, after = 0, mean = 0;
    for (uint64_t pass = 0; pass < passes; pass++)
        for (size_t i = 0; i < PIXELS; i++) {
            struct sampler sampler = sampler_make(9, i, pass);
            struct shared_sample sample = {.surface = 1, .n = {0, 0, 1}, .weight = {weight, lit}};
            sample.p = (vec3){(float)(i % WIDTH), (float)(i / WIDTH), 0};
            shared_light_add(shared, i, &sample, 1);
            const bool other = is_middle(i);
            if (sampler_1d(&sampler) >= 0.1f) continue;
            shared_light_splat(shared, i, other ? &there : &here, lit);
            for (int c = 0; c < 3; c++) image.pixels[6 * i + (size_t)c] += 1.0f / passes;
        }
    const float middle = image.pixels[6 * (PIXELS / 2 + WIDTH / 2)];
    for (size_t i = 0; i < PIXELS; i++) before += pow((double)image.pixels[6 * i] - 0.1, 2) / PIXELS;
    assert_int_equal(shared_light_apply(shared, passes, &image, &(struct run){.threads = 2}, &error), STATUS_OK);
    for (size_t i = 0; i < PIXELS; i++) {
        after += pow((double)image.pixels[6 * i] - 0.1, 2) / PIXELS;
        mean += (double)image.pixels[6 * i] / PIXELS;
    }
    if (!(after < 0.1 * before)) fail_msg("%g -> %g", before, after);
    if (fabs(mean - 0.1) > 4 * sqrt(before / PIXELS) + 0.001) fail_msg("mean %g for 0.1", mean);
    assert_true(image.pixels[6 * (PIXELS / 2 + WIDTH / 2)] >= middle);
    image_fini(&image);
    shared_light_destroy(shared);
}

static void test_earlier_passes(void **unused) {
    (void)unused;
    static struct picture whole, half;
    const struct plane plane = {.passes = 16, .noise = 0.7f};
    make_picture(&plane, 1, 0, &whole);
    make_picture(&plane, 1, 16, &half);
    for (size_t i = 0; i < PIXELS; i++) {
        const double change = whole.after[i] - whole.before[i];
        assert_float_equal((float)(half.after[i] - half.before[i]), (float)(0.5 * change), 1e-5f);
    }
}

static double room_error(const struct rendering *r, const struct rendering *reference) {
    double sum = 0;
    for (size_t i = 0; i < (size_t)r->width * (size_t)r->height; i++)
        sum += pixel_relative_error(&r->image.pixels[6 * i], &reference->image.pixels[6 * i]);
    return sum / (3.0 * r->width * r->height);
}

static void test_room(void **unused) {
    (void)unused;
    struct rendering with, without, reference;
    size_t dropped;
    render_path(furnished_room, &(struct path_test){PATH_MIS, 512, 2, .seed = 11}, &reference, &dropped);
    render_path(furnished_room, &(struct path_test){PATH_MIS, 16, 2, .seed = 5}, &without, &dropped);
    render_path(furnished_room, &(struct path_test){PATH_MIS, 16, 2, .seed = 5, .share = true}, &with, &dropped);
    const double a = room_error(&with, &reference), b = room_error(&without, &reference);
    if (!(a < 0.25 * b)) fail_msg("relMSE %g with sharing, %g without", a, b);
    for (int c = 0; c < 3; c++) {
        const double noise = hypot(with.error[c], reference.error[c]);
        if (fabs(with.mean[c] - reference.mean[c]) > 4 * noise + 0.01 * reference.mean[c])
            fail_msg("mean %g with sharing, %g in the reference (noise %g)", with.mean[c], reference.mean[c], noise);
    }
    image_fini(&with.image);
    image_fini(&without.image);
    image_fini(&reference.image);
}

static const char *const glossy_room = HEAD("-1", "64", "0,-1.9,0", "0,2,-0.2")
    BOX("x='2' y='2' z='1.5'", "x='0'",
        "<bsdf type='roughplastic'><float name='alpha' value='0.2'/><rgb name='diffuse_reflectance' value='0.12 0.1 "
        "0.08'/></bsdf>") SLAB("x='0.5' y='0.3' z='0.4'", "x='0.7' y='0.6' z='-1.1'",
                               "<bsdf type='plastic'><rgb name='diffuse_reflectance' value='0.2 0.4 0.6'/></bsdf>")
        PANEL("x='0.3' y='0.3'", "0", "x='0.5' y='0.5' z='0.8'", "30") "</scene>";

// The parts are all that the film holds but for lights that the camera sees, and for fourth surfaces.
static void test_parts_add_up(void **unused) {
    (void)unused;
    struct scene scene;
    struct error error = {0};
    struct film film;
    void *state;
    const struct run run = {.threads = 2, .seed = 3};
    if (scene_from_document(&scene, glossy_room, &error)) fail_msg("%s", error.text);
    scene.share_light = true;
    assert_int_equal(film_init(&film, scene.sensor, &error), STATUS_OK);
    assert_int_equal(path_create(&scene, &run, PATH_MIS, &state, &error), STATUS_OK);
    for (uint64_t pass = 0; pass < 24; pass++) {
        assert_int_equal(path_integrator.render_pass(state, &film, pass, &run, &error), STATUS_OK);
        film_end_pass(&film, 2);
    }
    const struct shared_light *shared = ((const struct path_tracer *)state)->shared;
    size_t whole = 0;
    const size_t pixels = (size_t)film.width * (size_t)film.height;
    for (size_t i = 0; i < pixels; i++) {
        double told = 0;
        for (int k = 0; k < SHARED_LAYERS; k++)
            for (int part = 0; part < SHARED_PARTS; part++)
                told += (double)shared->layers[k][i].parts[part].product[1] / (double)shared->paths[i];
        assert_true(told <= film.mean[3 * i + 1] * 1.001 + 1e-6);
        whole += told >= film.mean[3 * i + 1] * 0.999;
    }
    if (whole < pixels * 9 / 10) fail_msg("in %zu of %zu pixels the parts are all", whole, pixels);
    path_integrator.destroy(state);
    film_fini(&film);
    scene_fini(&scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_smooth_light),  cmocka_unit_test(test_step),
                                       cmocka_unit_test(test_other_surface), cmocka_unit_test(test_earlier_passes),
                                       cmocka_unit_test(test_flash),         cmocka_unit_test(test_true_spot),
                                       cmocka_unit_test(test_splats),        cmocka_unit_test(test_parts_add_up),
                                       cmocka_unit_test(test_room)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
