// Groups of emitters baked separately: dimmed and tinted they are the lamp with other radiances, as traced and as baked
// anew; an interrupted bake goes on; errors.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "bake/bake_job.h"
#include "format/safetensors.h"

static char folder[64];

static int make_folder(void **state) {
    (void)state;
    strcpy(folder, "/tmp/sconce_groups_XXXXXX");
    return mkdtemp(folder) ? 0 : -1;
}

static int remove_folder(void **state) {
    (void)state;
    char command[128];
    snprintf(command, sizeof command, "rm -r %s", folder);
    return system(command);
}

static const char *in_folder(const char *name) {
    static char paths[8][128];
    static int next;
    char *path = paths[next++ & 7];
    snprintf(path, 128, "%s/%s", folder, name);
    return path;
}

// Two bulbs of the group `bulb`, one of `spot`, a block that casts shadows, in a rough-glass ball.
static const char *write_lamp(const char *name, const char *bulb, const char *spot) {
    const char *path = in_folder(name);
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    fputs("<scene version=\"3.0.0\">\n", file);
    for (int i = 0; i < 3; i++)
        fprintf(file,
                "<shape type=\"sphere\"><point name=\"center\" x=\"%g\" y=\"%g\" z=\"0\"/><float name=\"radius\" "
                "value=\"0.12\"/><emitter type=\"area\" id=\"%s.%d\"><rgb name=\"radiance\" value=\"%s\"/></emitter>"
                "</shape>\n",
                i == 0 ? 0.3 : -0.2, i == 2 ? -0.3 : 0.2, i < 2 ? "bulb" : "spot", i, i < 2 ? bulb : spot);
    fputs("<shape type=\"cube\"><transform name=\"to_world\"><scale value=\"0.1\"/></transform></shape>\n"
          "<shape type=\"sphere\" id=\"glass\"><float name=\"radius\" value=\"0.7\"/><bsdf type=\"roughdielectric\">"
          "<float name=\"alpha\" value=\"0.3\"/></bsdf></shape>\n</scene>\n",
          file);
    fclose(file);
    return path;
}

static const struct bake_plan small = {
    100000, 1, 12, 8, 400000, 12, {400000, 400000, 16, 64, 0, 0}, {.chunks = 0}, false, LIGHT_LOSS_LIKELIHOOD, 0, 0};

static bool stop(void *user) {
    int *left = user;
    return *left >= 0 && (*left)-- == 0;
}

// For what does not ask how good the file is.
static const struct bake_plan tiny = {
    20000, 0, 2, 3, 400000, 10, {40000, 65536, 4, 4, 0, 0}, {.chunks = 0}, false, LIGHT_LOSS_LIKELIHOOD, 0, 0};

static enum status bake(const struct bake_plan *plan, const char *lamp, const char *output, enum bake_groups groups,
                        int stop_after, bool resume, struct bake_report *report, struct error *error) {
    struct bake_options options = {
        .lamp_path = lamp, .output_path = output, .quality = BAKE_DRAFT, .resume = resume, .groups = groups};
    struct run run = {.threads = 2, .seed = 1, .cancelled = stop, .user = &stop_after};
    return bake_lamp_plan(&options, plan, &run, report, error);
}

static struct evaluation measure(const struct luminaire *luminaire, const char *lamp) {
    struct scene scene;
    struct error error;
    const struct scene_options options = {.lamp_only = true, .threads = 2};
    const struct run run = {.threads = 2, .seed = 7};
    struct evaluation evaluation;
    assert_int_equal(scene_load(&scene, lamp, &options, &run, &error), STATUS_OK);
    assert_int_equal(evaluate_luminaire(luminaire, &scene, &small.evaluation, &run, &evaluation, &error), STATUS_OK);
    scene_fini(&scene);
    return evaluation;
}

static void dimmed_is_baked_anew(void **state) {
    (void)state;
    const char *grouped = in_folder("grouped.safetensors"), *anew = in_folder("anew.safetensors");
    const char *before = write_lamp("before.xml", "10, 20, 5", "4, 2, 30");
    const char *after = write_lamp("after.xml", "3, 40, 0.5", "12, 6, 9"); // by 0.3, 2, 0.1 and 3, 3, 0.3
    struct bake_report report;
    struct error error;
    assert_int_equal(bake(&small, before, grouped, BAKE_GROUPS_NAMED, -1, false, &report, &error), STATUS_OK);
    assert_int_equal(bake(&small, after, anew, BAKE_GROUPS_NONE, -1, false, &report, &error), STATUS_OK);
    struct luminaire *file, *tinted, *rebaked, *off;
    assert_int_equal(luminaire_load(&file, grouped, &error), STATUS_OK);
    assert_int_equal(luminaire_load(&rebaked, anew, &error), STATUS_OK);
    assert_int_equal(luminaire_group_count(file), 2);
    assert_string_equal(luminaire_group(file, 0, NULL), "bulb");
    assert_string_equal(luminaire_group(file, 1, NULL), "spot");
    assert_non_null(strstr(luminaire_metadata(file, "bake.groups"), "\"name\":\"spot\""));
    const float factors[2][3] = {{0.3f, 2, 0.1f}, {3, 3, 0.3f}}, only[2][3] = {{1, 1, 1}, {0}};
    assert_int_equal(luminaire_dim(&tinted, file, factors, &error), STATUS_OK);
    assert_int_equal(luminaire_dim(&off, file, only, &error), STATUS_OK);

    struct evaluation wrong = measure(file, after), right = measure(tinted, after), again = measure(rebaked, after);
    printf("flux error %.4f, irradiance error %.4f (baked anew %.4f, noise %.4f, not tinted %.4f)\n",
           (double)right.flux_error[2], (double)right.irradiance_error[1], (double)again.irradiance_error[1],
           (double)right.irradiance_noise[1], (double)wrong.irradiance_error[1]);
    for (int c = 0; c < 3; c++) {
        assert_true(fabsf(right.flux_error[c]) < 0.02f);
        assert_true(fabsf(wrong.flux_error[c]) > 0.2f);
    }
    for (int k = 0; k < EVALUATION_DISTANCES; k++)
        assert_true(right.irradiance_error[k] < 1.5f * again.irradiance_error[k] + 0.01f);
    assert_true(right.light_field_error < 2 * again.light_field_error + 0.01f);
    assert_true(right.sample_variance < 2 * again.sample_variance);

    // One group off: the lamp whose other emitters are black.
    struct evaluation dark = measure(off, write_lamp("dark.xml", "10, 20, 5", "0, 0, 0"));
    for (int c = 0; c < 3; c++) assert_true(fabsf(dark.flux_error[c]) < 0.02f);
    assert_true(dark.irradiance_error[1] < 0.1f + dark.irradiance_noise[1]);

    luminaire_destroy(tinted);
    luminaire_destroy(off);
    luminaire_destroy(rebaked);
    luminaire_destroy(file);
}

static void assert_same_tensors(const char *a_path, const char *b_path) {
    struct safetensors a, b;
    struct error error;
    assert_int_equal(safetensors_load(&a, a_path, &error), STATUS_OK);
    assert_int_equal(safetensors_load(&b, b_path, &error), STATUS_OK);
    assert_int_equal(a.tensor_count, b.tensor_count);
    for (size_t i = 0; i < a.tensor_count; i++) {
        size_t size = tensor_element_size(a.tensors[i].type);
        for (size_t d = 0; d < a.tensors[i].dimension_count; d++) size *= a.tensors[i].shape[d];
        assert_memory_equal(a.tensors[i].data, b.tensors[i].data, size);
    }
    safetensors_fini(&a);
    safetensors_fini(&b);
}

// In either group.
static void interrupted_goes_on(void **state) {
    (void)state;
    const char *lamp = write_lamp("again.xml", "10, 20, 5", "4, 2, 30");
    const char *one = in_folder("one.safetensors"), *two = in_folder("two.safetensors");
    struct bake_report report;
    struct error error;
    assert_int_equal(bake(&tiny, lamp, one, BAKE_GROUPS_NAMED, -1, false, &report, &error), STATUS_OK);
    const char *second = in_folder("two.safetensors.checkpoint.1/state.json");
    assert_int_equal(bake(&tiny, lamp, two, BAKE_GROUPS_NAMED, 5, false, &report, &error), STATUS_CANCELLED);
    assert_non_null(strstr(error.text, "--resume"));
    assert_int_not_equal(access(second, F_OK), 0); // in the first group
    assert_int_equal(bake(&tiny, lamp, two, BAKE_GROUPS_NAMED, 9, true, &report, &error), STATUS_CANCELLED);
    assert_int_equal(access(second, F_OK), 0); // in the second
    assert_int_equal(bake(&tiny, lamp, two, BAKE_GROUPS_NAMED, -1, true, &report, &error), STATUS_OK);
    assert_same_tensors(one, two);
    static const char *const left[] = {"two.safetensors.checkpoint", "two.safetensors.checkpoint.1"};
    for (int i = 0; i < 2; i++) assert_int_not_equal(access(in_folder(left[i]), F_OK), 0);
}

static void errors_say_what_to_do(void **state) {
    (void)state;
    struct bake_report report;
    struct error error;
    const char *lamp = in_folder("many.xml");
    FILE *file = fopen(lamp, "w");
    assert_non_null(file);
    fputs("<scene version=\"3.0.0\">\n", file);
    for (int i = 0; i < 17; i++)
        fprintf(file,
                "<shape type=\"sphere\" id=\"bulb.%d\"><point name=\"center\" x=\"%d\" y=\"0\" z=\"0\"/>"
                "<float name=\"radius\" value=\"0.1\"/><emitter type=\"area\"/></shape>\n",
                i, i);
    fputs("</scene>\n", file);
    fclose(file);
    assert_int_equal(bake(&tiny, lamp, in_folder("x"), BAKE_GROUPS_EACH, -1, false, &report, &error), STATUS_INVALID);
    assert_non_null(strstr(error.text, "17 groups of emitters, at most 16"));
    assert_int_equal(bake(&tiny, lamp, in_folder("x"), BAKE_GROUPS_NAMED, 0, false, &report, &error), STATUS_CANCELLED);
    assert_int_equal(bake(&tiny, write_lamp("black.xml", "1, 1, 1", "0, 0, 0"), in_folder("x"), BAKE_GROUPS_NAMED, -1,
                          false, &report, &error),
                     STATUS_INVALID);
    assert_non_null(strstr(error.text, "group 'spot' have no power"));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(errors_say_what_to_do),
        cmocka_unit_test(interrupted_goes_on),
        cmocka_unit_test(dimmed_is_baked_anew),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
