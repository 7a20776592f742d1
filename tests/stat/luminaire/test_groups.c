// Groups of emitters in one luminaire: the light is exactly the sum of theirs, the samples' density exactly the mixture
// of theirs; dimmed copies; the file; and what the settings mean. argv: writes the fuzzers' seed.
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <unistd.h>
#include <cmocka.h>

#include "../../chi_square.h"
#include "base/file.h"
#include "format/spectrum.h"
#include "luminaire/group_setting.h"
#include "luminaire/hull.h"
#include "luminaire/view_field.h"
#include "synthetic_lamp.h"

enum { GROUPS = 3, EXITS = 60000, LINES = 1500 };
static const char *const names[GROUPS] = {"ring", "spot", "rest"};
static const float odd[GROUPS][3] = {{0.3f, 2, 0}, {1, 1, 1}, {0.01f, 0.02f, 5}};
static const float none[GROUPS][3] = {{0}};

// Group g: the balls i of the clear lamp with i % GROUPS == g, large enough for a quadrature to see them.
static struct lamp group_lamp(int g) {
    struct lamp all = lamp_clear(), lamp = {.proxy = all.proxy};
    for (int i = g; i < all.count; i += GROUPS) {
        lamp.balls[lamp.count] = all.balls[i];
        lamp.balls[lamp.count++].radius = 0.05f;
    }
    return lamp;
}

struct part {
    struct light_field *field;
    struct sampling_density *density;
    struct view_field *view;
    float flux[3];
};

static struct part make_part(int g, const struct hull *hull) {
    struct lamp lamp = group_lamp(g);
    struct part part = {.view = NULL};
    float anchors[12][3];
    for (int i = 0; i < lamp.count; i++) store(anchors[i], lamp.balls[i].center);
    struct light_field_options options = {.proxy = lamp.proxy,
                                          .anchors = (const float(*)[3])anchors,
                                          .anchor_count = (size_t)lamp.count,
                                          .anchor_radius = 0.06f,
                                          .use_grid4 = true,
                                          .radiance_unit = 0.5f,
                                          .log2_entries = 10,
                                          .steps = 20,
                                          .seed = (uint64_t)g};
    struct error error;
    assert_int_equal(light_field_create(&part.field, &options, &error), STATUS_OK);
    struct line_sample *samples = malloc(512 * sizeof *samples);
    for (size_t step = 0; step < 4; step++) {
        lamp_batch(&lamp, DATA_CAMERA, 0.5f, step, 512, samples);
        light_field_train(part.field, samples, 512, 1, NULL);
    }
    free(samples);
    struct line_exit *exits = malloc(EXITS * sizeof *exits);
    size_t used = 0;
    for (size_t i = 0; i < EXITS; i++) {
        struct sampler s = sampler_make(3, 0, i);
        if (!lamp_exit(&lamp, &s, &exits[used])) continue;
        for (int c = 0; c < 3; c++) part.flux[c] += exits[used].flux[c] / EXITS;
        used++;
    }
    assert_int_equal(sampling_density_build(&part.density, &lamp.proxy, (const float(*)[3])anchors, (size_t)lamp.count,
                                            exits, used, 5, 1, &error),
                     STATUS_OK);
    free(exits);
    if (!hull) return part;
    struct view_field_options view = {.center = {lamp.proxy.center[0], lamp.proxy.center[1], lamp.proxy.center[2]},
                                      .radius = lamp.proxy.radius,
                                      .part_count = 1,
                                      .log2_entries = 10,
                                      .radiance_unit = (float)(g + 1)};
    assert_int_equal(view_field_create(&part.view, &view, 1, 1, &error), STATUS_OK);
    return part;
}

static struct hull *make_hull(void) { // one triangle
    struct lamp lamp = lamp_clear();
    struct hull *hull;
    struct error error;
    assert_int_equal(hull_allocate(&hull, 3, 1, &error), STATUS_OK);
    for (int a = 0; a < 3; a++) {
        hull->lower[a] = lamp.proxy.center[a];
        hull->step[a] = 1e-8f;
        hull->triangles[0][a] = (uint16_t)a;
        for (int v = 0; v < 3; v++) hull->vertices[v][a] = v == a ? 6000000 : 0;
    }
    hull->part_count = 1;
    hull->parts[0] = (struct hull_part){.kind = HULL_OPAQUE, .count = 1, .eta = 1};
    return hull;
}

// Of all groups, or of one alone and without a name.
static struct luminaire *make_luminaire(int first, int last, bool with_hull) {
    struct lamp lamp = lamp_clear();
    struct hull *hull = with_hull ? make_hull() : NULL;
    struct part part = make_part(first, hull);
    struct error error = {0};
    struct luminaire *luminaire;
    assert_int_equal(
        luminaire_assemble(&luminaire, &lamp.proxy, part.field, NULL, part.density, part.flux, NULL, NULL, 0, &error),
        STATUS_OK);
    if (hull) assert_int_equal(luminaire_set_view(luminaire, hull, part.view, &error), STATUS_OK);
    for (int g = first + 1; g <= last; g++) {
        part = make_part(g, hull);
        assert_int_equal(luminaire_add_group(luminaire, part.field, part.density, part.view, part.flux, &error),
                         STATUS_OK);
    }
    if (last > first) assert_int_equal(luminaire_name_groups(luminaire, names, &error), STATUS_OK);
    return luminaire;
}

static struct luminaire *dim(const struct luminaire *luminaire, const float (*factors)[3]) {
    struct luminaire *dimmed;
    struct error error;
    assert_int_equal(luminaire_dim(&dimmed, luminaire, factors, &error), STATUS_OK);
    return dimmed;
}

struct lines {
    float point[LINES][3], w[LINES][3];
};

static void draw_lines(struct lines *lines) {
    struct lamp lamp = lamp_clear();
    for (int i = 0; i < LINES; i++) {
        struct sampler s = sampler_make(9, 0, (uint64_t)i);
        vec3 w = warp_uniform_sphere(sampler_2d(&s)), p = warp_uniform_sphere(sampler_2d(&s));
        store(lines->point[i], vec3_mad(p, 0.9f * lamp.proxy.radius, lamp_center(&lamp)));
        store(lines->w[i], w);
    }
}

static void light_is_the_sum(void **state) {
    (void)state;
    struct luminaire *all = make_luminaire(0, GROUPS - 1, true), *dimmed = dim(all, odd), *single[GROUPS];
    static struct lines lines;
    static float sum[LINES][3], dim_sum[LINES][3], one[LINES][3];
    const float(*point)[3] = (const float(*)[3])lines.point, (*w)[3] = (const float(*)[3])lines.w;
    draw_lines(&lines);
    float flux[3], expected[3] = {0};
    for (int g = 0; g < GROUPS; g++) {
        single[g] = make_luminaire(g, g, true);
        assert_int_equal(luminaire_group_count(single[g]), 0);
        luminaire_eval(single[g], LINES, point, w, one);
        luminaire_flux(single[g], flux);
        for (int i = 0; i < LINES; i++)
            for (int c = 0; c < 3; c++) {
                sum[i][c] += one[i][c];
                dim_sum[i][c] += odd[g][c] * one[i][c];
            }
        for (int c = 0; c < 3; c++) expected[c] += odd[g][c] * flux[c];
    }
    luminaire_flux(dimmed, flux);
    for (int c = 0; c < 3; c++) assert_true(fabsf(flux[c] - expected[c]) <= 1e-5f * expected[c]);
    for (int pass = 0; pass < 2; pass++) {
        luminaire_eval(pass ? dimmed : all, LINES, point, w, one);
        for (int i = 0; i < LINES; i++)
            for (int c = 0; c < 3; c++)
                assert_true(fabsf(one[i][c] - (pass ? dim_sum : sum)[i][c]) <= 2e-6f * (pass ? dim_sum : sum)[i][c]);
    }
    // The hull's radiance likewise; darkness is darkness.
    struct view_point at = {.point = {0.1f, -0.2f, 2}, .normal = {0, 0, 1}, .w = {0, 0.6f, 0.8f}};
    float seen[3], seen_sum[3] = {0};
    for (int g = 0; g < GROUPS; g++) {
        luminaire_view(single[g], 1, &at, &seen);
        for (int c = 0; c < 3; c++) seen_sum[c] += odd[g][c] * seen[c];
    }
    luminaire_view(dimmed, 1, &at, &seen);
    for (int c = 0; c < 3; c++) assert_true(seen[c] > 0 && fabsf(seen[c] - seen_sum[c]) <= 2e-6f * seen_sum[c]);
    struct luminaire *off = dim(all, none);
    luminaire_eval(off, LINES, point, w, one);
    for (int i = 0; i < LINES; i++) assert_true(one[i][0] == 0 && one[i][1] == 0 && one[i][2] == 0);
    float pdf;
    luminaire_pdf(off, 1, (const float(*)[3])lines.point, (const float(*)[3])lines.w, &pdf);
    assert_true(pdf > 0);
    luminaire_destroy(off);
    for (int g = 0; g < GROUPS; g++) luminaire_destroy(single[g]);
    luminaire_destroy(dimmed);
    luminaire_destroy(all);
}

struct viewpoint {
    const struct luminaire *luminaire;
    float s[3];
};

static bool viewpoint_sample(void *user, uint64_t index, vec3 *w) {
    const struct viewpoint *view = user;
    struct sampler s = sampler_make(11, 0, index);
    vec2 first = sampler_2d(&s);
    float u[3] = {first.x, first.y, sampler_1d(&s)}, direction[3], pdf, again;
    luminaire_sample(view->luminaire, 1, (const float(*)[3])view->s, (const float(*)[3])u, &direction, &pdf);
    luminaire_pdf(view->luminaire, 1, (const float(*)[3])view->s, (const float(*)[3])direction, &again);
    assert_true(pdf > 0 && fabsf(again - pdf) <= 1e-5f * pdf);
    *w = vec3_make(direction[0], direction[1], direction[2]);
    return true;
}

static double viewpoint_pdf(void *user, vec3 w) {
    const struct viewpoint *view = user;
    float direction[3] = {w.x, w.y, w.z}, pdf;
    luminaire_pdf(view->luminaire, 1, (const float(*)[3])view->s, (const float(*)[3])direction, &pdf);
    return (double)pdf;
}

static void samples_have_their_density(void **state) {
    (void)state;
    struct luminaire *all = make_luminaire(0, GROUPS - 1, false), *dimmed = dim(all, odd);
    static const float points[3][3] = {{0.1f, -0.2f, 2}, {0.2f, -0.1f, 2.2f}, {0.5f, -0.2f, 2}};
    for (int k = 0; k < 3; k++) {
        struct viewpoint view = {dimmed, {points[k][0], points[k][1], points[k][2]}};
        struct chi_square_direction test = {.sample = viewpoint_sample,
                                            .pdf_sa = viewpoint_pdf,
                                            .user = &view,
                                            .samples = 12000,
                                            .rows = 8,
                                            .columns = 16,
                                            .frame = frame_from_normal(vec3_normalize(vec3_make(0.3f, 0.5f, 0.8f)))};
        struct chi_square result = chi_square_test_directions(&test);
        printf("point %d: integral %.4f, p = %.3g\n", k, result.integral, result.p);
        assert_true(fabs(result.integral - 1) < 0.02);
        assert_true(result.p > chi_square_sidak(1e-3, 3));
    }
    luminaire_destroy(dimmed);
    luminaire_destroy(all);
}

// In a batch as alone; a group that is off has no part in the density.
static void density_is_the_mixture(void **state) {
    (void)state;
    struct luminaire *all = make_luminaire(0, GROUPS - 1, false), *dimmed = dim(all, odd), *single[GROUPS];
    static struct lines lines;
    static float pdf[LINES], one[GROUPS][LINES], direction[LINES][3], sampled[LINES];
    static float u[LINES][3];
    draw_lines(&lines);
    const float(*s)[3] = (const float(*)[3])lines.point, (*w)[3] = (const float(*)[3])lines.w;
    double share[GROUPS], total = 0;
    for (int g = 0; g < GROUPS; g++) {
        float flux[3];
        single[g] = make_luminaire(g, g, false);
        assert_string_equal(luminaire_group(all, (size_t)g, flux), names[g]);
        total += share[g] = odd[g][0] * flux[0] + odd[g][1] * flux[1] + odd[g][2] * flux[2];
        luminaire_pdf(single[g], LINES, s, w, one[g]);
    }
    luminaire_pdf(dimmed, LINES, s, w, pdf);
    for (int i = 0; i < LINES; i++) {
        double mixture = 0;
        for (int g = 0; g < GROUPS; g++) mixture += share[g] / total * (double)one[g][i];
        assert_true(fabs((double)pdf[i] - mixture) <= 1e-5 * mixture);
        struct sampler random = sampler_make(4, 0, (uint64_t)i);
        for (int c = 0; c < 3; c++) u[i][c] = sampler_1d(&random);
    }
    luminaire_sample(dimmed, LINES, s, (const float(*)[3])u, direction, sampled);
    for (int i = 0; i < LINES; i += 7) {
        float alone[3], alone_pdf;
        luminaire_sample(dimmed, 1, s + i, (const float(*)[3])u[i], &alone, &alone_pdf);
        for (int c = 0; c < 3; c++) assert_true(fabsf(alone[c] - direction[i][c]) < 1e-6f);
        assert_true(fabsf(alone_pdf - sampled[i]) <= 1e-5f * alone_pdf);
    }
    float only[GROUPS][3] = {{0}, {0.5f, 0, 0}, {0}};
    struct luminaire *spot = dim(all, (const float(*)[3])only);
    luminaire_pdf(spot, LINES, s, w, pdf);
    assert_memory_equal(pdf, one[1], sizeof pdf);
    luminaire_destroy(spot);
    for (int g = 0; g < GROUPS; g++) luminaire_destroy(single[g]);
    luminaire_destroy(dimmed);
    luminaire_destroy(all);
}

static void file_keeps_groups(void **state) {
    (void)state;
    char path[] = "/tmp/sconce_groups_XXXXXX";
    int file = mkstemp(path);
    assert_true(file >= 0);
    close(file);
    struct luminaire *all = make_luminaire(0, GROUPS - 1, true), *dimmed = dim(all, odd), *loaded;
    struct error error = {0};
    assert_int_equal(luminaire_save(dimmed, path, &error), STATUS_OK); // as baked
    assert_int_equal(luminaire_load(&loaded, path, &error), STATUS_OK);
    assert_int_equal(luminaire_group_count(loaded), GROUPS);
    assert_string_equal(luminaire_metadata(loaded, "groups"), "ring,spot,rest");
    struct luminaire *again = dim(loaded, odd);
    static struct lines lines;
    static float a[LINES][3], b[LINES][3];
    draw_lines(&lines);
    luminaire_eval(dimmed, LINES, (const float(*)[3])lines.point, (const float(*)[3])lines.w, a);
    luminaire_eval(again, LINES, (const float(*)[3])lines.point, (const float(*)[3])lines.w, b);
    assert_memory_equal(a, b, sizeof a);
    for (size_t g = 0; g < GROUPS; g++) {
        float flux[3], kept[3];
        assert_string_equal(luminaire_group(loaded, g, kept), luminaire_group(all, g, flux));
        assert_memory_equal(flux, kept, sizeof flux);
    }
    luminaire_destroy(again);
    luminaire_destroy(loaded);
    // Any byte of the header may be wrong.
    uint8_t *bytes;
    size_t length;
    assert_int_equal(file_read(path, &bytes, &length, &error), STATUS_OK);
    for (size_t i = 0; i < 9000 && i < length; i += 5) {
        uint8_t kept = bytes[i];
        bytes[i] ^= (uint8_t)(1 << i % 8);
        if (luminaire_parse(&loaded, "changed", bytes, length, &error) == STATUS_OK) luminaire_destroy(loaded);
        bytes[i] = kept;
    }
    free(bytes);
    unlink(path);
    luminaire_destroy(dimmed);
    luminaire_destroy(all);
}

static void settings_mean_what_they_say(void **state) {
    (void)state;
    const struct group_light fresh[2] = {{"bulb", {30, 20, 10}, {1, 1, 1}}, {"spot", {1, 4, 9}, {1, 1, 1}}};
    struct group_light lights[2];
    struct error error;
    memcpy(lights, fresh, sizeof fresh);
    assert_int_equal(group_settings_apply(" bulb = 0.3 ;spot=1:0.5:2, all=2;", lights, 2, &error), STATUS_OK);
    for (int c = 0; c < 3; c++) {
        assert_true(fabsf(lights[0].factor[c] - 0.6f) < 1e-6f);
        assert_true(fabsf(lights[1].factor[c] - 2 * (float[3]){1, 0.5f, 2}[c]) < 1e-6f);
    }
    // 2700 K: the colour of the black body at the same luminous flux; then the lumens.
    memcpy(lights, fresh, sizeof fresh);
    assert_int_equal(group_settings_apply("bulb=2700K;spot=800lm 6500K", lights, 2, &error), STATUS_OK);
    rgb warm = spectrum_blackbody_rgb(2700), cool = spectrum_blackbody_rgb(6500);
    float light[2][3];
    for (int g = 0; g < 2; g++)
        for (int c = 0; c < 3; c++) light[g][c] = fresh[g].flux[c] * lights[g].factor[c];
    assert_true(fabsf(light[0][0] / light[0][1] - warm.r / warm.g) < 1e-4f * warm.r / warm.g);
    assert_true(fabsf(light[1][2] / light[1][1] - cool.b / cool.g) < 1e-4f * cool.b / cool.g);
    assert_true(fabsf(luminous_flux(light[0]) / luminous_flux(fresh[0].flux) - 1) < 1e-4f);
    assert_true(fabsf(luminous_flux(light[1]) / 800 - 1) < 1e-4f);
    // "all" is the sum as it then is.
    memcpy(lights, fresh, sizeof fresh);
    assert_int_equal(group_settings_apply("bulb=0;all=1000lm", lights, 2, &error), STATUS_OK);
    assert_true(lights[0].factor[0] == 0);
    for (int c = 0; c < 3; c++) light[1][c] = fresh[1].flux[c] * lights[1].factor[c];
    assert_true(fabsf(luminous_flux(light[1]) / 1000 - 1) < 1e-4f);

    static const struct {
        const char *text, *says;
    } bad[] = {{"lamp=1", "no group 'lamp'; this lamp has bulb, spot"},
               {"bulb", "NAME=SETTING"},
               {"bulb=", "no setting"},
               {"bulb=-1", "no setting"},
               {"bulb=nan", "no setting"},
               {"bulb=1:2", "no setting"},
               {"bulb=1:2:3:4", "no setting"},
               {"bulb=270K", "no setting"},
               {"bulb=3000 K", "no setting"},
               {"bulb=3000K 4000K", "no setting"},
               {"bulb=0.5kg", "no setting"},
               {"bulb=1;bulb=2", "set twice"},
               {"all=1;all=1", "set twice"},
               {"bulb=0;spot=0;all=9lm", "'all' is dark"}};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        memcpy(lights, fresh, sizeof fresh);
        assert_int_equal(group_settings_apply(bad[i].text, lights, 2, &error), STATUS_INVALID);
        if (!strstr(error.text, bad[i].says)) fail_msg("%s: %s", bad[i].text, error.text);
    }
    struct group_light red = {"exit", {1, 0, 0}, {1, 1, 1}}, whole = {NULL, {1, 1, 1}, {1, 1, 1}};
    assert_int_equal(group_settings_apply("exit=2700K", &red, 1, &error), STATUS_INVALID);
    assert_non_null(strstr(error.text, "no green light"));
    assert_int_equal(group_settings_apply("exit=5", &whole, 1, &error), STATUS_INVALID);
    assert_non_null(strstr(error.text, "without groups"));
    assert_int_equal(group_settings_apply("all=100lm", &whole, 1, &error), STATUS_OK);
    assert_true(fabsf(whole.factor[1] - 100.0f / LUMENS_PER_WATT) < 1e-5f);
}

static void names_are_checked(void **state) {
    (void)state;
    struct error error;
    assert_int_equal(group_name_check("bulb_3", &error), STATUS_OK);
    static const char *const bad[] = {
        "", "all", "a b", "a,b", "a=b", "a;b", "0123456789012345678901234567890123456789012345678901234567890123"};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        assert_int_equal(group_name_check(bad[i], &error), STATUS_INVALID);
}

int main(int argc, char **argv) {
    if (argc == 2) { // writes the fuzzers' seed
        struct luminaire *luminaire = make_luminaire(0, 1, true);
        struct error error;
        enum status status = luminaire_save(luminaire, argv[1], &error);
        luminaire_destroy(luminaire);
        return status != STATUS_OK;
    }
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(light_is_the_sum),
        cmocka_unit_test(samples_have_their_density),
        cmocka_unit_test(density_is_the_mixture),
        cmocka_unit_test(file_keeps_groups),
        cmocka_unit_test(settings_mean_what_they_say),
        cmocka_unit_test(names_are_checked),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
