// The ceiling of a light field: what it lowers, by how much, and that a file keeps it.
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <unistd.h>
#include <cmocka.h>

#include "../../stat/luminaire/synthetic_lamp.h"
#include "luminaire/luminaire_private.h"
#include "luminaire/sampling_sums.h"

enum { LINES = 60000, STEPS = 100, BATCH = 4000, ANCHORS = 4 }; // the other four bulbs are "bent" light

#define DIM 0.02 // of the brightest line that passes all anchors

struct fitted {
    struct light_field *field;
    struct sampling_density *density;
    struct line_exit *exits;
    float (*point)[3], (*w)[3], (*before)[3], (*after)[3]; // of the same lines
    double flux_before, flux_after, bent_before; // sums of the exits'; before, of those that pass all anchors
};

static struct light_field *train(const struct lamp *lamp) {
    float anchors[12][3];
    for (int i = 0; i < ANCHORS; i++) store(anchors[i], lamp->balls[i].center);
    struct light_field_options options = {.proxy = lamp->proxy,
                                          .anchors = (const float(*)[3])anchors,
                                          .anchor_count = ANCHORS,
                                          .anchor_radius = 0.03f,
                                          .use_grid4 = true,
                                          .radiance_unit = 0.5f,
                                          .log2_entries = 10,
                                          .steps = STEPS,
                                          .seed = 2};
    struct light_field *field;
    struct error error;
    assert_int_equal(light_field_create(&field, &options, &error), STATUS_OK);
    struct line_sample *samples = malloc(BATCH * sizeof *samples);
    for (size_t step = 0; step < STEPS; step++) {
        lamp_batch(lamp, DATA_CAMERA, 0.5f, step, BATCH, samples);
        light_field_train(field, samples, BATCH, 1, NULL);
    }
    free(samples);
    assert_int_equal(light_field_finish(field, &error), STATUS_OK);
    return field;
}

static double mean_of(const float v[3]) { return ((double)v[0] + (double)v[1] + (double)v[2]) / 3; }

static bool is_bent(const struct fitted *f, size_t i) {
    return sampling_anchor_of(f->density, vec3_from(f->point[i]), vec3_from(f->w[i])) < 0;
}

// Leaves of the lines that pass all anchors the dim ones and, with this share of the flux, the brightest.
static void make_spots(struct fitted *f, double share) {
    double brightest = 0, all = 0, top = 0;
    for (size_t i = 0; i < LINES; i++)
        if (is_bent(f, i)) brightest = fmax(brightest, mean_of(f->before[i]));
    for (size_t i = 0; i < LINES; i++) {
        const double flux = mean_of(f->exits[i].flux), l = mean_of(f->before[i]) / brightest;
        if (!is_bent(f, i) || l < DIM)
            all += flux;
        else if (l > 0.8)
            top += flux;
    }
    for (size_t i = 0; i < LINES; i++) {
        const double l = mean_of(f->before[i]) / brightest;
        if (!is_bent(f, i) || l < DIM) continue;
        for (int c = 0; c < 3; c++) f->exits[i].flux[c] *= l > 0.8 ? share * all / top : 0;
    }
}

static void fit(struct fitted *f, double spots) {
    const struct lamp lamp = lamp_clear();
    float anchors[12][3];
    struct error error;
    *f = (struct fitted){.field = train(&lamp), .exits = malloc(LINES * sizeof *f->exits)};
    f->point = malloc(LINES * sizeof *f->point), f->w = malloc(LINES * sizeof *f->w);
    f->before = malloc(LINES * sizeof *f->before), f->after = malloc(LINES * sizeof *f->after);
    for (int i = 0; i < ANCHORS; i++) store(anchors[i], lamp.balls[i].center);
    float *mass = malloc(LINES * sizeof *mass);
    for (size_t i = 0; i < LINES; i++) {
        struct sampler s = sampler_make(5, 0, i);
        vec3 p, w;
        mass[i] = lamp_line(&lamp, &s, &p, &w);
        store(f->point[i], p), store(f->w[i], w);
    }
    light_field_eval(f->field, LINES, (const float(*)[3])f->point, (const float(*)[3])f->w, f->before);
    for (size_t i = 0; i < LINES; i++) {
        memcpy(f->exits[i].point, f->point[i], sizeof f->point[i]);
        memcpy(f->exits[i].w, f->w[i], sizeof f->w[i]);
        for (int c = 0; c < 3; c++) f->exits[i].flux[c] = mass[i] * f->before[i][c];
    }
    free(mass);
    assert_int_equal(sampling_density_build(&f->density, &lamp.proxy, (const float(*)[3])anchors, ANCHORS, f->exits,
                                            LINES, 1, 1, &error),
                     STATUS_OK);
    make_spots(f, spots);
    double flux[3] = {0}, left[3];
    for (size_t i = 0; i < LINES; i++) {
        for (int c = 0; c < 3; c++) flux[c] += f->exits[i].flux[c];
        if (is_bent(f, i)) f->bent_before += mean_of(f->exits[i].flux);
    }
    assert_int_equal(light_field_fit_ceiling(f->field, f->density, f->exits, LINES, 2, left, &error), STATUS_OK);
    light_field_eval(f->field, LINES, (const float(*)[3])f->point, (const float(*)[3])f->w, f->after);
    for (int c = 0; c < 3; c++) {
        f->flux_before += flux[c] / 3;
        f->flux_after += flux[c] * left[c] / 3;
    }
}

static void fitted_fini(struct fitted *f) {
    light_field_destroy(f->field);
    sampling_density_destroy(f->density);
    free(f->exits), free(f->point), free(f->w), free(f->before), free(f->after);
}

static void takes_its_share_from_the_brightest(void **state) {
    (void)state;
    struct fitted f;
    fit(&f, 0.01);
    const double share = fmin(LIGHT_CEILING_SHARE * f.flux_before, 0.05 * f.bent_before);
    assert_true(share > 0);
    assert_float_equal((f.flux_before - f.flux_after) / share, 1, 1e-3);
    double ceiling = 0;
    for (size_t i = 0; i < LINES; i++)
        if (is_bent(&f, i)) ceiling = fmax(ceiling, mean_of(f.after[i]));
    size_t lowered = 0;
    for (size_t i = 0; i < LINES; i++) {
        const double before = mean_of(f.before[i]), expected = is_bent(&f, i) ? fmin(1, ceiling / before) : 1;
        lowered += expected < 0.999;
        for (int c = 0; c < 3; c++) assert_float_equal(f.after[i][c], f.before[i][c] * expected, 1e-4 * before);
    }
    assert_in_range(lowered, 5, LINES / 20);
    fitted_fini(&f);
}

// Where all of it is about as bright, a ceiling would cost flux and spare no noise.
static void spares_even_light(void **state) {
    (void)state;
    struct fitted f;
    fit(&f, 0.5);
    assert_true(f.flux_after == f.flux_before);
    assert_memory_equal(f.before, f.after, LINES * sizeof *f.after);
    fitted_fini(&f);
}

static struct luminaire *assemble(struct fitted *f) { // takes field and density
    const struct lamp lamp = lamp_clear();
    const float flux[3] = {1, 1, 1};
    struct luminaire *luminaire;
    struct error error;
    assert_int_equal(
        luminaire_assemble(&luminaire, &lamp.proxy, f->field, NULL, f->density, flux, NULL, NULL, 0, &error),
        STATUS_OK);
    f->field = NULL, f->density = NULL;
    return luminaire;
}

static void the_file_keeps_it(void **state) {
    (void)state;
    struct fitted f;
    fit(&f, 0.01);
    char path[] = "/tmp/sconce_ceiling_XXXXXX";
    int file = mkstemp(path);
    assert_true(file >= 0);
    close(file);
    struct luminaire *made = assemble(&f), *read;
    struct error error;
    assert_int_equal(luminaire_save(made, path, &error), STATUS_OK);
    assert_int_equal(luminaire_load(&read, path, &error), STATUS_OK);
    assert_true(read->emissions[0].light->ceiling > 0);
    light_field_eval(read->emissions[0].light, LINES, (const float(*)[3])f.point, (const float(*)[3])f.w, f.before);
    assert_memory_equal(f.before, f.after, LINES * sizeof *f.after);
    luminaire_destroy(made), luminaire_destroy(read);
    fitted_fini(&f);
    unlink(path);
}

int main(int argc, char **argv) {
    if (argc == 2) { // writes the fuzzers' seed
        struct fitted f;
        fit(&f, 0.01);
        struct luminaire *luminaire = assemble(&f);
        struct error error;
        enum status status = luminaire_save(luminaire, argv[1], &error);
        luminaire_destroy(luminaire);
        fitted_fini(&f);
        return status != STATUS_OK;
    }
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(takes_its_share_from_the_brightest),
        cmocka_unit_test(spares_even_light),
        cmocka_unit_test(the_file_keeps_it),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
