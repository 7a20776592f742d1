// The cache of radiance: its cells alone, told by several threads; and renderings with and without it: a furnace, a
// furnished room, and a dark chamber behind a thin wall, into which no light may leak.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#include "base/parallel.h"
#include "math/sampler.h"
#include "math/warp.h"
#include "render_path.h"
#include "room_text.h"
#include "trace/radiance_cache.h"

// --- Cells ---

#define BULB "<emitter type='point'><rgb name='intensity' value='1'/></emitter>"
#define BALL(radius) "<shape type='sphere'><float name='radius' value='" radius "'/></shape>"

enum { TOLD = 200000, WIDTHS = 3 };
static const float widths[WIDTHS] = {10, 0.1f, 0.01f};

static struct cache_place place_number(size_t i) {
    struct sampler sampler = sampler_make(9, 0, i);
    const vec3 n = warp_uniform_sphere(sampler_2d(&sampler)), p = warp_uniform_sphere(sampler_2d(&sampler));
    return (struct cache_place){vec3_scale(p, 0.1f), n, widths[i % WIDTHS], (uint32_t)(i / 2 % 2), (int)(i / 4 % 2)};
}

// Radiance that tells the cells apart: by position, the side of the normal, shape and kind.
static rgb radiance_at(const struct cache_place *place) {
    return (rgb){2 + place->p.x, 1 + 4 * (float)place->shape, 1 + (float)place->kind};
}

static void tell(void *user, size_t i, int worker) {
    (void)worker;
    const struct cache_place place = place_number(i);
    struct cache_cells cells;
    if (radiance_cache_cells(user, &place, &cells)) radiance_cache_tell(user, &cells, radiance_at(&place));
}

static void told_cache(struct radiance_cache **cache, const struct scene *scene, int threads) {
    struct error error;
    assert_int_equal(radiance_cache_create(cache, scene, &error), STATUS_OK);
    parallel_for(threads, TOLD, tell, *cache);
}

// Seven tenths of what is told are what the cache answers, so 1 is the truth; of a first answer of 10 little may stay.
static void test_forgets(void **unused) {
    (void)unused;
    enum { passes = 64, tellings = 50 };
    struct scene scene;
    struct error error;
    if (scene_from_text(&scene, BULB BALL("1"), &error)) fail_msg("%s", error.text);
    struct radiance_cache *cache;
    assert_int_equal(radiance_cache_create(&cache, &scene, &error), STATUS_OK);
    const struct cache_place place = place_number(0);
    struct cache_cells cells;
    float answer = 0;
    for (int pass = 0; pass < passes; pass++) {
        rgb mean = rgb_gray(0);
        radiance_cache_learn(cache);
        const bool known = radiance_cache_mean(cache, &place, &mean);
        assert_true(known == (pass > 0));
        answer = mean.g;
        assert_true(radiance_cache_cells(cache, &place, &cells));
        for (int i = 0; i < tellings; i++)
            radiance_cache_tell(cache, &cells, rgb_gray(known ? 0.3f + 0.7f * mean.g : 10));
    }
    assert_true(answer > 1 && answer < 1.9f);
    radiance_cache_destroy(cache);
    scene_fini(&scene);
}

// Each pass tells two places what `radiance` says.
static float mean_at_second(float (*radiance)(int place, int pass, int i), int passes) {
    enum { tellings = 40 };
    struct scene scene;
    struct error error;
    struct radiance_cache *cache;
    if (scene_from_text(&scene, BULB BALL("1"), &error)) fail_msg("%s", error.text);
    assert_int_equal(radiance_cache_create(&cache, &scene, &error), STATUS_OK);
    struct cache_place places[2] = {{.n = {0, 0, 1}, .width = 1}, {.n = {0, 0, 1}, .width = 1, .shape = 1}};
    rgb mean;
    for (int pass = 0; pass <= passes; pass++) {
        radiance_cache_learn(cache);
        for (int k = 0; k < 2 && pass < passes; k++) {
            struct cache_cells cells;
            assert_true(radiance_cache_cells(cache, &places[k], &cells));
            for (int i = 0; i < tellings; i++) radiance_cache_tell(cache, &cells, rgb_gray(radiance(k, pass, i)));
        }
    }
    assert_true(radiance_cache_mean(cache, &places[1], &mean));
    radiance_cache_destroy(cache);
    scene_fini(&scene);
    return mean.g;
}

static float flash(int place, int pass, int i) { return place == 1 && pass == 5 && i == 7 ? 1e5f : 1; }
static float bright_corner(int place, int pass, int i) { return pass >= 2 && place == 1 ? i % 20 ? 0 : 2e4f : 1; }

// A single bright telling changes little (of 400 it would be worth 250); where all light comes by such, all of it
// counts before long.
static void test_bright_tellings(void **unused) {
    (void)unused;
    const float with_flash = mean_at_second(flash, 10), corner = mean_at_second(bright_corner, 64);
    if (!(with_flash < 2)) fail_msg("a flash makes 1 to %g", (double)with_flash);
    if (fabsf(corner - 1000) > 50) fail_msg("%g instead of 1000", (double)corner);
}

static void test_cells(void **unused) {
    (void)unused;
    struct scene scene;
    struct error error;
    if (scene_from_text(&scene, BULB BALL("1"), &error)) fail_msg("%s", error.text);
    struct radiance_cache *one, *two;
    told_cache(&one, &scene, 1);
    told_cache(&two, &scene, 2);
    rgb mean, same;
    const struct cache_place first = place_number(0);
    assert_false(radiance_cache_mean(one, &first, &mean)); // not before it has learned
    for (int before = 0; before < 2; before++) { // and after a pass
        radiance_cache_learn(one);
        radiance_cache_learn(two);
    }
    size_t known = 0;
    double error2 = 0;
    for (size_t i = 0; i < TOLD; i++) {
        const struct cache_place place = place_number(i);
        const bool is_known = radiance_cache_mean(one, &place, &mean);
        assert_int_equal(is_known, radiance_cache_mean(two, &place, &same));
        if (!is_known) continue;
        known++;
        assert_memory_equal(&mean, &same, sizeof mean);
        const rgb expected = radiance_at(&place);
        assert_true(fabsf(mean.g - expected.g) < 1e-4f); // one shape's and one kind's alone
        assert_true(fabsf(mean.b - expected.b) < 1e-4f);
        assert_true(fabsf(mean.r - expected.r) <= 0.10001f); // from somewhere in the largest cell
        error2 += (double)sqrf(mean.r - expected.r);
    }
    assert_true(known > TOLD / 5);
    assert_true(error2 / (double)known < sqrf(0.1f) / 6);

    struct cache_place fine = place_number(1);
    fine.width = 1e-6f;
    struct cache_cells cells;
    assert_false(radiance_cache_mean(one, &fine, &mean)); // no cell is so small
    assert_false(radiance_cache_cells(one, &fine, &cells));
    radiance_cache_destroy(one);
    radiance_cache_destroy(two);
    scene_fini(&scene);
}

// What many have told is answered by the smaller cells: the answer follows a step of the radiance.
static void test_refines(void **unused) {
    (void)unused;
    struct scene scene;
    struct error error;
    if (scene_from_text(&scene, BULB BALL("1"), &error)) fail_msg("%s", error.text);
    struct radiance_cache *cache;
    assert_int_equal(radiance_cache_create(&cache, &scene, &error), STATUS_OK);
    struct cache_place place = {.n = {0, 0, 1}, .width = 1};
    float errors[2] = {0};
    for (int round = 0; round < 2; round++) {
        for (uint64_t i = 0; i < (round ? 20000 : 40); i++) {
            struct sampler sampler = sampler_make(4, (uint64_t)round, i);
            place.p = (vec3){0.05f * sampler_1d(&sampler), 0.001f, 0.001f};
            struct cache_cells cells;
            assert_true(radiance_cache_cells(cache, &place, &cells));
            radiance_cache_tell(cache, &cells, rgb_gray(place.p.x < 0.02f ? 1 : 0));
        }
        for (int pass = 0; pass < 8; pass++) radiance_cache_learn(cache);
        for (int k = 0; k < 50; k++) {
            place.p.x = 0.001f * (float)k + 0.0005f;
            rgb mean;
            assert_true(radiance_cache_mean(cache, &place, &mean));
            errors[round] += fabsf(mean.r - (place.p.x < 0.02f ? 1.0f : 0.0f)) / 50;
        }
    }
    assert_true(errors[0] > 0.3f);
    assert_true(errors[1] < 0.15f);
    radiance_cache_destroy(cache);
    scene_fini(&scene);
}

// --- Renderings ---

static void render(const char *xml, bool cache, int threads, int passes, struct rendering *result) {
    size_t dropped;
    render_path(xml, &(struct path_test){PATH_MIS, passes, threads, .seed = 7, .share = cache}, result, &dropped);
    assert_int_equal(dropped, 0);
}

static void assert_means_agree(const struct rendering *with, const struct rendering *without, double tolerance) {
    for (int c = 0; c < 3; c++) {
        const double noise = hypot(with->error[c], without->error[c]);
        if (fabs(with->mean[c] - without->mean[c]) > 4 * noise + tolerance * without->mean[c])
            fail_msg("mean %g with the cache, %g without (noise %g)", with->mean[c], without->mean[c], noise);
    }
}

// Walls that all glow alike, round a block of plastic.
static void test_furnace(void **unused) {
    (void)unused;
    static const char *const furnace = HEAD("-1", "32", "0,0,0", "1,0.3,0.2")
        BOX("value='1'", "x='0'", DIFFUSE("0.5") "<emitter type='area'><rgb name='radiance' value='1'/></emitter>")
            SLAB("value='0.2'", "x='0.6' y='0.2' z='-0.4'",
                 "<bsdf type='plastic'><rgb name='diffuse_reflectance' value='0.5'/></bsdf>") "</scene>";
    struct rendering with, without;
    render(furnace, true, 2, 64, &with);
    render(furnace, false, 2, 64, &without);
    assert_means_agree(&with, &without, 0.002);
    image_fini(&with.image);
    image_fini(&without.image);
}

static double relative_variance(const struct rendering *r, const struct rendering *other) {
    double sum = 0;
    const size_t count = (size_t)r->width * (size_t)r->height;
    for (size_t i = 0; i < count; i++) {
        const double level = 0.5 * (double)(r->image.pixels[6 * i + 1] + other->image.pixels[6 * i + 1]);
        sum += (double)r->image.pixels[6 * i + 4] / (level * level + 1e-3) / (double)count;
    }
    return sum;
}

static void test_room(void **unused) {
    (void)unused;
    struct rendering with, without, twice;
    render(furnished_room, true, 1, 128, &with);
    render(furnished_room, true, 2, 128, &twice);
    render(furnished_room, false, 2, 128, &without);
    const size_t count = (size_t)with.width * (size_t)with.height;
    assert_memory_equal(with.image.pixels, twice.image.pixels, 6 * count * sizeof(float));
    assert_means_agree(&with, &without, 0.01);
    const double a = relative_variance(&with, &without), b = relative_variance(&without, &with);
    if (!(a < 0.7 * b)) fail_msg("relative variance %g with the cache, %g without", a, b);
    image_fini(&with.image);
    image_fini(&twice.image);
    image_fini(&without.image);
}

// A chamber seen from inside, lit through a slit only, beside a bright one; both sides of the wall between them are
// one mesh, thinner than any cell.
static void test_no_leak(void **unused) {
    (void)unused;
    static const char *const chambers =
        HEAD("-1", "32", "1.8,-0.8,0", "0.3,0.6,0") BOX("x='2' y='1' z='1'", "x='0'", DIFFUSE("0.7"))
            SLAB("x='0.01' y='0.97' z='1'", "x='0' y='-0.03'", DIFFUSE("0.7"))
                PANEL("x='0.5' y='0.5'", "180", "x='-1' z='0.95'", "20") "</scene>";
    struct rendering with, without;
    render(chambers, true, 2, 512, &with);
    render(chambers, false, 2, 512, &without);
    assert_means_agree(&with, &without, 0.02);
    assert_true(hypot(with.error[1], without.error[1]) < 0.02 * without.mean[1]); // else that says nothing
    image_fini(&with.image);
    image_fini(&without.image);
}

// Paths with a limit are followed to their end.
static void test_short_paths(void **unused) {
    (void)unused;
    static const char *const limited = HEAD("4", "32", "0,-1.9,0", "0,2,-0.2")
        BOX("x='2' y='2' z='1.5'", "x='0'", DIFFUSE("0.5")) PANEL("x='0.3' y='0.3'", "180", "z='1.4'", "30") "</scene>";
    struct rendering with, without;
    render(limited, true, 2, 8, &with);
    render(limited, false, 2, 8, &without);
    for (size_t i = 0; i < (size_t)with.width * (size_t)with.height;
         i++) // the variances, which are of the samples alone
        assert_memory_equal(&with.image.pixels[6 * i + 3], &without.image.pixels[6 * i + 3], 3 * sizeof(float));
    image_fini(&with.image);
    image_fini(&without.image);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_cells),       cmocka_unit_test(test_forgets),
        cmocka_unit_test(test_refines),     cmocka_unit_test(test_furnace),
        cmocka_unit_test(test_room),        cmocka_unit_test(test_no_leak),
        cmocka_unit_test(test_short_paths), cmocka_unit_test(test_bright_tellings),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
