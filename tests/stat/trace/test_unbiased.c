// Unbiased rendering with a luminaire whose light field and transparency are wrong, against bidirectional path tracing
// of the lamp's real geometry: every block of the image and every colour by a z-test, and the same test must refuse the
// picture that the luminaire alone gives. One lamp is clear (its near lines come from the camera's side), one frosted
// whose bulb is a ball of glass (particles bring all). The level is split over the blocks by Sidak's correction, as in
// test_agree.c.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <cmocka.h>

#include "math/warp.h"
#include "trace/path.h"
#include "trace/residual.h"
#include "luminaire_stand_in.h"
#include "write_file.h"

extern const struct integrator_type bdpt_integrator;

// --- The luminaire: a soft ball of half transparent light. ---

struct luminaire {
    float radius;
};
static struct luminaire the_luminaire = {0.7f};
static struct luminaire *stand_in(void) { return &the_luminaire; }

void luminaire_flux(const struct luminaire *luminaire, float flux[3]) {
    (void)luminaire;
    flux[0] = flux[1] = flux[2] = 20;
}

void luminaire_eval(const struct luminaire *luminaire, size_t n, const float (*point)[3], const float (*w)[3],
                    float (*radiance)[3]) {
    for (size_t i = 0; i < n; i++) {
        float r = line_distance(point[i], w[i]) / luminaire->radius, value = r < 1 ? 6 * (1 - r * r) : 0;
        radiance[i][0] = value;
        radiance[i][1] = value * (1 + 0.5f * w[i][0]);
        radiance[i][2] = value;
    }
}

void luminaire_transmittance(const struct luminaire *luminaire, size_t n, const float (*point)[3], const float (*w)[3],
                             float (*transmittance)[3]) {
    (void)luminaire, (void)point, (void)w;
    for (size_t i = 0; i < n; i++) transmittance[i][0] = transmittance[i][1] = transmittance[i][2] = 0.5f;
}

// --- The lamp: an emitter in a shell, a crystal, a metal plate, a plate that is half there. ---

#define DIFFUSE(value) "<bsdf type='diffuse'><rgb name='reflectance' value='" value "'/></bsdf>"
#define TWO(bsdf) "<bsdf type='twosided'>" bsdf "</bsdf>"
#define BALL(x, y, z, radius, rest)                                                                                    \
    "<shape type='sphere'><point name='center' x='" x "' y='" y "' z='" z "'/><float name='radius' value='" radius     \
    "'/>" rest "</shape>"
#define PLATE(size, turn, place, bsdf)                                                                                 \
    "<shape type='rectangle'><transform name='to_world'><scale value='" size "'/><rotate " turn "/><translate " place  \
    "/></transform>" bsdf "</shape>"
#define GLASS(outside, inside)                                                                                         \
    "<float name='int_ior' value='" inside "'/><float name='ext_ior' value='" outside "'/></bsdf>"
#define SHELL(bsdf)                                                                                                    \
    BALL("0", "0", "0", "0.6", bsdf GLASS("1", "1.5")) BALL("0", "0", "0", "0.55", bsdf GLASS("1.5", "1"))
#define LAMP(radius, radiance, shell, bulb)                                                                            \
    "<scene version='3.0.0'>" BALL("0.05", "0", "0", radius,                                                           \
                                   DIFFUSE("0.1") "<emitter type='area'><rgb name='radiance' value='" radiance         \
                                                  "'/></emitter>") SHELL(shell)                                        \
        bulb BALL("-0.4", "0.5", "-0.5", "0.2", "<bsdf type='dielectric'/>") PLATE(                                    \
            "0.25", "x='1' angle='60'", "y='-0.3' z='0.75'",                                                           \
            TWO("<bsdf type='roughconductor'><float name='alpha' value='0.3'/></bsdf>"))                               \
            PLATE("0.3", "x='1' angle='20'", "x='0.3' z='-0.75'",                                                      \
                  "<bsdf type='mask'><float name='opacity' value='0.5'/>" TWO(DIFFUSE("0.6")) "</bsdf>") "</scene>"

// --- The room: a mirror, a half transparent curtain before the lamp, a light of its own. ---

static const char *const room =
    "<scene version='3.0.0'><integrator type='path'><integer name='max_depth' value='9'/></integrator>"
    "<sensor type='perspective'><float name='fov' value='48'/><transform name='to_world'>"
    "<lookat origin='0,-3.4,0.3' target='0,0,-0.2' up='0,0,1'/></transform><film type='hdrfilm'>"
    "<integer name='width' value='32'/><integer name='height' value='32'/><rfilter type='box'/></film></sensor>" //
    PLATE("1.5", "x='1' angle='0'", "z='-1.5'", DIFFUSE("0.6 0.5 0.4")) //
    PLATE("1.5", "x='1' angle='180'", "z='1.5'", DIFFUSE("0.7")) //
    PLATE("1.5", "x='1' angle='90'", "y='1.5'", DIFFUSE("0.6")) //
    PLATE("1.5", "y='1' angle='90'", "x='-1.5'", DIFFUSE("0.6 0.2 0.2")) //
    PLATE("1.5", "y='1' angle='-90'", "x='1.5'", DIFFUSE("0.2 0.5 0.2")) //
    PLATE("0.5", "y='1' angle='-80'", "x='1.3' y='-0.4' z='-0.6'",
          TWO("<bsdf type='conductor'><rgb name='specular_reflectance' value='0.8'/></bsdf>")) //
    PLATE("0.4", "y='1' angle='90'", "x='-0.8' y='0.2' z='0.2'",
          "<bsdf type='mask'><float name='opacity' value='0.5'/>" TWO(DIFFUSE("0.5")) "</bsdf>") //
    BALL(
        "-0.9", "0.6", "-1.2", "0.3",
        DIFFUSE(
            "0") "<emitter type='area'><rgb name='radiance' value='1 2 3'/></emitter>") "<shape "
                                                                                        "type='luminaire'><string "
                                                                                        "name='filename' "
                                                                                        "value='%s'/>%s<rgb name='dim' "
                                                                                        "value='1 0.8 0.6'/>"
                                                                                        "<transform "
                                                                                        "name='to_world'><rotate x='1' "
                                                                                        "angle='30'/><scale "
                                                                                        "value='0.7'/><translate "
                                                                                        "x='0.1' y='0.3' z='0.5'/>"
                                                                                        "</transform></shape></scene>";

enum kind { GEOMETRY, MODEL, UNBIASED };

static void load(struct scene *scene, const char *lamp, enum kind kind, const struct run *run) {
    char folder[] = "/tmp/sconce_test_unbiased_XXXXXX", lamp_path[100], room_path[100];
    assert_non_null(mkdtemp(folder));
    snprintf(lamp_path, sizeof lamp_path, "%s/lamp.xml", folder);
    snprintf(room_path, sizeof room_path, "%s/room.xml", folder);
    write_file(lamp_path, "%s", lamp);
    write_file(room_path, room, kind == GEOMETRY ? "lamp.xml" : "lamp.safetensors",
               kind == GEOMETRY ? "" : "<string name='geometry' value='lamp.xml'/>");
    struct error error = {0};
    struct scene_options options = {.threads = 1, .unbiased = kind == UNBIASED};
    enum status status = scene_load(scene, room_path, &options, run, &error);
    unlink(lamp_path);
    unlink(room_path);
    rmdir(folder);
    if (status != STATUS_OK) fail_msg("%s", error.text);
    assert_int_equal(scene->luminaire_count, kind != GEOMETRY);
}

// --- Pictures and their comparison. ---

enum { SIZE = 32, BLOCKS = 4, MEANS = BLOCKS * BLOCKS * 3 };
static const double level = 1e-3; // chance that a correct program fails a comparison

struct blocks {
    double mean[MEANS], variance[MEANS];
};

static void render(const char *lamp, enum kind kind, const struct integrator_type *type, int threads, int passes,
                   struct blocks *blocks) {
    struct run run = {.threads = threads, .seed = 21 + kind};
    struct error error = {0};
    struct scene scene;
    struct film film;
    struct image image;
    void *state;
    load(&scene, lamp, kind, &run);
    assert_int_equal(film_init(&film, scene.sensor, &error), STATUS_OK);
    assert_int_equal(type->create(&scene, &run, &state, &error), STATUS_OK);
    for (int pass = 0; pass < passes; pass++) {
        assert_int_equal(type->render_pass(state, &film, (uint64_t)pass, &run, &error), STATUS_OK);
        film_end_pass(&film, 1);
    }
    assert_int_equal(film_image(&film, &image, &error), STATUS_OK);
    memset(blocks, 0, sizeof *blocks);
    double share = BLOCKS * BLOCKS / (double)(SIZE * SIZE);
    for (int i = 0; i < SIZE * SIZE; i++) {
        int block = i / SIZE * BLOCKS / SIZE * BLOCKS + i % SIZE * BLOCKS / SIZE;
        for (int c = 0; c < 3; c++) {
            blocks->mean[3 * block + c] += image.pixels[6 * i + c] * share;
            blocks->variance[3 * block + c] += image.pixels[6 * i + 3 + c] * share * share;
        }
    }
    type->destroy(state);
    image_fini(&image);
    film_fini(&film);
    scene_fini(&scene);
}

static double z_limit(int tests) { // two-sided, by bisection of erfc
    double each = 1 - pow(1 - level, 1.0 / tests), low = 0, high = 20;
    for (int i = 0; i < 80; i++) {
        double z = (low + high) / 2;
        *(erfc(z / sqrt(2)) > each ? &low : &high) = z;
    }
    return low;
}

static double largest_z(const char *name, const struct blocks *a, const struct blocks *reference, double noise_limit) {
    double largest = 0, noise = 0, mean = 0;
    for (int i = 0; i < MEANS; i++) mean += reference->mean[i] / MEANS;
    for (int i = 0; i < MEANS; i++) {
        double error = sqrt(a->variance[i] + reference->variance[i]);
        largest = fmax(largest, fabs(a->mean[i] - reference->mean[i]) / error);
        noise = fmax(noise, error / fmax(mean, reference->mean[i]));
    }
    print_message("%s: largest z %.2f of %.2f, largest standard error %.2f %%\n", name, largest, z_limit(MEANS),
                  100 * noise);
    assert_true(noise < noise_limit); // else the test says nothing
    return largest;
}

struct case_ {
    const char *name, *lamp;
    bool calm;
    int passes, bdpt_passes;
};

static void test_lamp(void **state) {
    const struct case_ *c = *state;
    struct blocks reference, model, unbiased;
    render(c->lamp, GEOMETRY, &bdpt_integrator, 2, c->bdpt_passes, &reference);
    render(c->lamp, MODEL, &path_integrator, 2, 64, &model);
    render(c->lamp, UNBIASED, &path_integrator, 2, c->passes, &unbiased);
    assert_true(largest_z("model", &model, &reference, 0.1) > 2 * z_limit(MEANS));
    assert_true(largest_z("unbiased", &unbiased, &reference, 0.03) < z_limit(MEANS));
}

static void test_near_lines(void **state) {
    const struct case_ *c = *state;
    struct scene scene;
    struct residual *residual;
    struct error error = {0};
    struct run run = {.threads = 1};
    load(&scene, c->lamp, UNBIASED, &run);
    assert_int_equal(residual_create(&residual, &scene, &error), STATUS_OK);
    vec3 emitter = transform_point(&scene.luminaires[0].to_world, (vec3){0.05f, 0, 0});
    assert_int_equal(residual_line_is_near(residual, 0, emitter, (vec3){0, 0, 1}), c->calm);
    assert_false(residual_line_is_near(residual, 0, vec3_add(emitter, (vec3){0.6f, 0, 0}), (vec3){0, 0, 1}));
    residual_destroy(residual);
    scene_fini(&scene);
}

static void test_threads(void **state) {
    const struct case_ *c = *state;
    struct blocks one, three;
    render(c->lamp, UNBIASED, &path_integrator, 1, 2, &one);
    render(c->lamp, UNBIASED, &path_integrator, 3, 2, &three);
    assert_memory_equal(&one, &three, sizeof one);
}

static struct case_ clear = {"clear", LAMP("0.4", "10 7.5 5", "<bsdf type='dielectric'>", ""), true, 256, 256},
                    frosted = {"frosted",
                               LAMP("0.05", "600 500 400",
                                    "<bsdf type='roughdielectric'><float name='alpha' value='0.5'/>",
                                    BALL("0.14", "0", "0", "0.15", "<bsdf type='dielectric'/>")),
                               false, 400, 400};

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_prestate(test_near_lines, &clear), cmocka_unit_test_prestate(test_near_lines, &frosted),
        cmocka_unit_test_prestate(test_threads, &clear),    cmocka_unit_test_prestate(test_lamp, &clear),
        cmocka_unit_test_prestate(test_lamp, &frosted),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
