// Whole bakes of small lamps: against closed forms (a bare sphere), the same file for any number of threads and after
// an interruption, errors by name.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "bake/bake_job.h"
#include "format/safetensors.h"
#include "math/sampler.h"
#include "math/warp.h"

static char folder[64];

static int make_folder(void **state) {
    (void)state;
    strcpy(folder, "/tmp/sconce_bake_XXXXXX");
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

static const char *write_lamp(const char *name, const char *body) {
    const char *path = in_folder(name);
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    fprintf(file, "<scene version=\"3.0.0\">\n%s\n</scene>\n", body);
    fclose(file);
    return path;
}

static const char bulb[] = "<shape type=\"sphere\"><point name=\"center\" x=\"1\" y=\"2\" z=\"3\"/>"
                           "<float name=\"radius\" value=\"0.25\"/>"
                           "<emitter type=\"area\"><rgb name=\"radiance\" value=\"10, 20, 5\"/></emitter></shape>";
static const char shell[] = "<shape type=\"sphere\"><point name=\"center\" x=\"1\" y=\"2\" z=\"3\"/>"
                            "<float name=\"radius\" value=\"0.8\"/><bsdf type=\"roughdielectric\">"
                            "<float name=\"alpha\" value=\"0.3\"/></bsdf></shape>";
static const char block[] = "<shape type=\"cube\"><transform name=\"to_world\"><scale value=\"0.3\"/>"
                            "<translate x=\"2\" y=\"2\" z=\"3\"/></transform><bsdf type=\"diffuse\"/></shape>";

struct listener {
    char warnings[2000];
    int left; // calls of cancelled() until it says so; < 0: never
};

static void hear(void *user, enum message_level level, const char *text) {
    struct listener *l = user;
    if (level == MESSAGE_WARNING) strncat(l->warnings, text, sizeof l->warnings - strlen(l->warnings) - 1);
}

static bool stop(void *user) {
    struct listener *l = user;
    return l->left >= 0 && l->left-- == 0;
}

static const struct bake_plan small = {
    100000, 1, 4, 8, 400000, 12, {200000, 262144, 16, 64, 0, 0}, {.chunks = 0}, false, LIGHT_LOSS_LIKELIHOOD, 0, 0};

static enum status bake(const char *lamp, const char *output, int threads, int stop_after, bool resume,
                        struct bake_report *report, struct listener *listener, struct error *error) {
    *listener = (struct listener){.left = stop_after};
    struct bake_options options = {.lamp_path = lamp, .output_path = output, .quality = BAKE_DRAFT, .resume = resume};
    struct run run = {.threads = threads, .seed = 1, .message = hear, .cancelled = stop, .user = listener};
    return bake_lamp_plan(&options, &small, &run, report, error);
}

static void bare_sphere_is_exact(void **state) {
    (void)state;
    struct bake_report report;
    struct listener listener;
    struct error error;
    const char *path = in_folder("bare.safetensors");
    assert_int_equal(bake(write_lamp("bare.xml", bulb), path, 2, -1, false, &report, &listener, &error), STATUS_OK);
    const float radiance[3] = {10, 20, 5};
    struct luminaire *luminaire;
    assert_int_equal(luminaire_load(&luminaire, path, &error), STATUS_OK);
    float flux[3];
    luminaire_flux(luminaire, flux);
    for (int c = 0; c < 3; c++) {
        double exact = 4 * M_PI * M_PI * 0.25 * 0.25 * (double)radiance[c]; // pi L 4 pi r^2
        assert_true(fabs((double)flux[c] / exact - 1) < 0.005);
        assert_true(fabs((double)report.evaluation.flux_error[c]) < 0.01);
    }
    assert_true(report.evaluation.irradiance_error[1] < 0.03f + report.evaluation.irradiance_noise[1]);
    float point[1][3] = {{1, 2, 3}}, w[1][3] = {{0.6f, 0, 0.8f}}, l[1][3];
    luminaire_eval(luminaire, 1, (const float(*)[3])point, (const float(*)[3])w, l);
    for (int c = 0; c < 3; c++) assert_true(fabsf(l[0][c] / radiance[c] - 1) < 0.1f);
    assert_non_null(luminaire_metadata(luminaire, "bake.evaluation"));
    assert_string_equal(luminaire_metadata(luminaire, "bake.source"), "bare.xml");
    luminaire_destroy(luminaire);
    assert_int_not_equal(access(in_folder("bare.safetensors.checkpoint"), F_OK), 0);
}

static void read_weights(const char *path, struct safetensors *file) {
    struct error error;
    assert_int_equal(safetensors_load(file, path, &error), STATUS_OK);
}

static void assert_same_tensors(const char *a_path, const char *b_path) {
    struct safetensors a, b;
    read_weights(a_path, &a);
    read_weights(b_path, &b);
    assert_int_equal(a.tensor_count, b.tensor_count);
    for (size_t i = 0; i < a.tensor_count; i++) {
        size_t size = tensor_element_size(a.tensors[i].type);
        for (size_t d = 0; d < a.tensors[i].dimension_count; d++) size *= a.tensors[i].shape[d];
        assert_memory_equal(a.tensors[i].data, b.tensors[i].data, size);
    }
    safetensors_fini(&a);
    safetensors_fini(&b);
}

// The second bake has other threads and is interrupted.
static void same_file_for_threads_and_resume(void **state) {
    (void)state;
    char body[2000];
    snprintf(body, sizeof body, "%s%s%s", bulb, shell, block);
    const char *lamp = write_lamp("frosted.xml", body);
    struct bake_report report;
    struct listener listener;
    struct error error;
    assert_int_equal(bake(lamp, in_folder("one.safetensors"), 1, -1, false, &report, &listener, &error), STATUS_OK);
    const char *second = in_folder("two.safetensors");
    assert_int_equal(bake(lamp, second, 2, 12, false, &report, &listener, &error), STATUS_CANCELLED);
    assert_non_null(strstr(error.text, "--resume"));
    assert_int_not_equal(access(second, F_OK), 0);
    assert_int_equal(access(in_folder("two.safetensors.checkpoint/state.json"), F_OK), 0);
    assert_int_equal(bake(lamp, second, 2, -1, true, &report, &listener, &error), STATUS_OK);
    assert_same_tensors(in_folder("one.safetensors"), second);
}

static void errors_say_what_to_do(void **state) {
    (void)state;
    struct bake_report report;
    struct listener listener;
    struct error error;
    assert_int_equal(bake(write_lamp("dark.xml", shell), in_folder("x"), 2, -1, false, &report, &listener, &error),
                     STATUS_INVALID);
    assert_non_null(strstr(error.text, "no emitter"));
    const char *black =
        "<shape type=\"sphere\"><emitter type=\"area\"><rgb name=\"radiance\" value=\"0, 0, 0\"/></emitter></shape>";
    assert_int_equal(bake(write_lamp("black.xml", black), in_folder("x"), 2, -1, false, &report, &listener, &error),
                     STATUS_INVALID);
    assert_non_null(strstr(error.text, "power"));
    char body[1000];
    snprintf(body, sizeof body,
             "%s<shape type=\"sphere\"><point name=\"center\" x=\"1\" y=\"2\" z=\"3\"/><bsdf type=\"twosided\">"
             "<bsdf type=\"diffuse\"><rgb name=\"reflectance\" value=\"0, 0, 0\"/></bsdf></bsdf></shape>",
             bulb);
    assert_int_equal(bake(write_lamp("box.xml", body), in_folder("x"), 2, -1, false, &report, &listener, &error),
                     STATUS_INVALID);
    assert_non_null(strstr(error.text, "no light leaves"));
    FILE *mesh = fopen(in_folder("open.obj"), "w");
    assert_non_null(mesh);
    fputs("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 3 4\nf 1 4 2\n", mesh);
    fclose(mesh);
    snprintf(body, sizeof body,
             "%s<emitter type=\"point\"/><shape type=\"obj\" id=\"vase\"><string name=\"filename\" value=\"open.obj\"/>"
             "<bsdf type=\"dielectric\"/></shape>",
             bulb);
    assert_int_equal(bake(write_lamp("open.xml", body), in_folder("x"), 2, 0, false, &report, &listener, &error),
                     STATUS_CANCELLED);
    assert_non_null(strstr(listener.warnings, "'vase' is open (3 edges"));
    assert_non_null(strstr(listener.warnings, "1 of the lamp's emitters are points"));
}

static enum status bake_with_hull(const char *lamp, const char *path, size_t file_bytes, size_t triangles,
                                  struct bake_report *report, struct error *error) {
    struct bake_plan plan = small;
    plan.view = (struct view_plan){.chunks = 1, .log2_entries = 10};
    plan.file_bytes = file_bytes;
    plan.hull_triangles = triangles;
    const struct bake_options options = {.lamp_path = lamp, .output_path = path, .quality = BAKE_DRAFT};
    const struct run run = {.threads = 2, .seed = 1};
    return bake_lamp_plan(&options, &plan, &run, report, error);
}

// With a hull in the file T is exact off its silhouettes: 0 through the bulb or the block, 1 beside both.
static void silhouettes_are_exact(void **state) {
    (void)state;
    char body[1000];
    snprintf(body, sizeof body, "%s%s", bulb, block);
    const char *path = in_folder("hull.safetensors"), *lamp = write_lamp("hull.xml", body);
    struct bake_report report;
    struct error error;
    assert_int_equal(bake_with_hull(lamp, path, 400000, 4000, &report, &error), STATUS_OK);
    assert_true(report.evaluation.transparency_error < 0.01f);
    struct luminaire *luminaire;
    assert_int_equal(luminaire_load(&luminaire, path, &error), STATUS_OK);
    int through = 0, beside = 0;
    for (int i = 0; i < 2000; i++) {
        struct sampler s = sampler_make(8, 0, (uint64_t)i);
        vec3 d = warp_uniform_sphere(sampler_2d(&s)), p = {0.8f + 1.4f * sampler_1d(&s), 1.5f + sampler_1d(&s), 3};
        vec3 from_bulb = vec3_sub(p, (vec3){1, 2, 3});
        float offset = vec3_length(vec3_mad(d, -vec3_dot(from_bulb, d), from_bulb));
        const float at[3] = {p.x - 2, p.y - 2, 0}, inverse[3] = {1 / d.x, 1 / d.y, 1 / d.z};
        bool in_block[2]; // made 2 % smaller and larger
        for (int k = 0; k < 2; k++) {
            float half = k ? 0.306f : 0.294f, near = -INFINITY, far = INFINITY;
            for (int a = 0; a < 3; a++) {
                float t0 = (-half - at[a]) * inverse[a], t1 = (half - at[a]) * inverse[a];
                near = fmaxf(near, fminf(t0, t1));
                far = fminf(far, fmaxf(t0, t1));
            }
            in_block[k] = near <= far;
        }
        const float point[1][3] = {{p.x, p.y, p.z}}, w[1][3] = {{d.x, d.y, d.z}};
        float t[1][3];
        luminaire_transmittance(luminaire, 1, point, w, t);
        if (in_block[0] || offset < 0.23f) { // the bulb is a mesh of few triangles in the hull
            through++;
            assert_true(t[0][0] == 0 && luminaire_seen(luminaire, point[0], w[0]));
        } else if (!in_block[1] && offset > 0.255f) {
            beside++;
            assert_true(t[0][0] == 1 && !luminaire_seen(luminaire, point[0], w[0]));
        }
    }
    assert_true(through > 100 && beside > 100);
    luminaire_destroy(luminaire);
}

// A hundred balls of 528 triangles each: all of them where the file has room, fewer where it has not.
static void a_hull_leaves_room_for_the_rest(void **state) {
    (void)state;
    enum { BALLS = 100 };
    struct bake_plan plan = small;
    plan.light_chunks = plan.trial_chunks = plan.transparency_chunks = 1;
    plan.log2_entries = 10;
    plan.view = (struct view_plan){.chunks = 1, .log2_entries = 10};
    plan.hull_triangles = 100000;
    static char body[BALLS * 200];
    size_t used = (size_t)snprintf(body, sizeof body, "%s", bulb);
    for (int i = 0; i < BALLS; i++)
        used += (size_t)snprintf(body + used, sizeof body - used,
                                 "<shape type=\"sphere\"><point name=\"center\" x=\"%d\" y=\"%d\" z=\"2\"/>"
                                 "<float name=\"radius\" value=\"%g\"/><bsdf type=\"diffuse\"/></shape>",
                                 i % 10, i / 10, 0.3 + 0.001 * i);
    const char *lamp = write_lamp("full.xml", body);
    size_t bytes[2], triangles[2];
    for (int i = 0; i < 2; i++) {
        const char *path = in_folder(i ? "tight.safetensors" : "roomy.safetensors");
        plan.file_bytes = i ? bytes[0] - 40000 : 2000000;
        struct bake_options options = {.lamp_path = lamp, .output_path = path, .quality = BAKE_DRAFT};
        struct run run = {.threads = 2, .seed = 1};
        struct bake_report report;
        struct luminaire *luminaire;
        struct error error;
        assert_int_equal(bake_lamp_plan(&options, &plan, &run, &report, &error), STATUS_OK);
        assert_int_equal(luminaire_load(&luminaire, path, &error), STATUS_OK);
        bytes[i] = report.bytes;
        triangles[i] = luminaire_hull(luminaire)->triangle_count;
        printf("%zu bytes of at most %zu, hull of %zu triangles\n", bytes[i], plan.file_bytes, triangles[i]);
        assert_true(bytes[i] <= plan.file_bytes);
        luminaire_destroy(luminaire);
    }
    assert_true(triangles[0] > 40000 && triangles[1] < triangles[0] && triangles[1] > triangles[0] / 8);
}

// A checkerboard of opacity becomes holes in the hull.
static void holes_are_holes(void **state) {
    (void)state;
    char body[1200];
    snprintf(body, sizeof body,
             "%s<shape type=\"sphere\"><point name=\"center\" x=\"1\" y=\"2\" z=\"3\"/><bsdf type=\"mask\">"
             "<texture name=\"opacity\" type=\"checkerboard\"><rgb name=\"color0\" value=\"1\"/>"
             "<rgb name=\"color1\" value=\"0\"/><transform name=\"to_uv\"><scale x=\"8\" y=\"4\"/></transform>"
             "</texture><bsdf type=\"twosided\"><bsdf type=\"diffuse\"/></bsdf></bsdf></shape>",
             bulb);
    struct bake_report report;
    struct error error;
    assert_int_equal(
        bake_with_hull(write_lamp("holes.xml", body), in_folder("holes.safetensors"), 2000000, 30000, &report, &error),
        STATUS_OK);
    assert_true(report.evaluation.transparency_error < 0.05f); // 0.4 where it is blurred
}

// Light samples aim at beads along tubes: with cones about clusters alone they vary by 6.
static void thin_tubes_are_aimed_at(void **state) {
    (void)state;
    char body[4000] = "";
    for (int i = 0; i < 6; i++) {
        const double a = M_PI / 3 * i, b = M_PI / 3 * (i + 1);
        snprintf(body + strlen(body), sizeof body - strlen(body),
                 "<shape type=\"cylinder\"><point name=\"p0\" x=\"%g\" y=\"0\" z=\"%g\"/>"
                 "<point name=\"p1\" x=\"%g\" y=\"0\" z=\"%g\"/><float name=\"radius\" value=\"0.012\"/>"
                 "<emitter type=\"area\"/></shape>",
                 cos(a), sin(a), cos(b), sin(b));
    }
    struct bake_report report;
    struct listener listener;
    struct error error;
    const char *path = in_folder("ring.safetensors");
    assert_int_equal(bake(write_lamp("ring.xml", body), path, 2, -1, false, &report, &listener, &error), STATUS_OK);
    assert_true(report.evaluation.sampling_measured);
    assert_true(report.evaluation.sample_variance < 3);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(bare_sphere_is_exact),
                                       cmocka_unit_test(thin_tubes_are_aimed_at),
                                       cmocka_unit_test(holes_are_holes),
                                       cmocka_unit_test(same_file_for_threads_and_resume),
                                       cmocka_unit_test(errors_say_what_to_do),
                                       cmocka_unit_test(silhouettes_are_exact),
                                       cmocka_unit_test(a_hull_leaves_room_for_the_rest)};
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
