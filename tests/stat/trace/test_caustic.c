// Caustics of baked lamps by particles and by light samples in mirrors against the same paths found by path tracing
// alone. This program has its own
// luminaire, a smooth ball of light that is large enough for both, in place of a baked one. The path tracers run side
// by side on the same random numbers, so that all that is no caustic cancels and the mean difference of every block is
// tested against its own noise over the passes.
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
#include "trace/path_state.h"
#include "luminaire_stand_in.h"
#include "write_file.h"

// --- The luminaire: proxy = unit sphere; light from lines that pass its centre within light_radius. ---

struct luminaire {
    float light_radius;
};
static struct luminaire the_luminaire = {0.6f};
static struct luminaire *stand_in(void) { return &the_luminaire; }

void luminaire_flux(const struct luminaire *luminaire, float flux[3]) {
    (void)luminaire;
    flux[0] = flux[1] = flux[2] = 10;
}

void luminaire_eval(const struct luminaire *luminaire, size_t n, const float (*point)[3], const float (*w)[3],
                    float (*radiance)[3]) {
    for (size_t i = 0; i < n; i++) {
        float r = line_distance(point[i], w[i]) / luminaire->light_radius, value = r < 1 ? 4 * (1 - r * r) : 0;
        radiance[i][0] = value * (1 + 0.5f * w[i][0]);
        radiance[i][1] = value;
        radiance[i][2] = value * (1 + 0.5f * w[i][2]);
    }
}

void luminaire_transmittance(const struct luminaire *luminaire, size_t n, const float (*point)[3], const float (*w)[3],
                             float (*transmittance)[3]) {
    (void)luminaire;
    for (size_t i = 0; i < n; i++) {
        float r = fminf(line_distance(point[i], w[i]), 1);
        for (int c = 0; c < 3; c++) transmittance[i][c] = r * r * r * (1 - 0.3f * (float)c * (1 - r));
    }
}

// --- The room: a mirror, a glass ball that absorbs, a half transparent mirror, and two lamps, of which the second's
// geometry (a diffuse and a mirroring plate, a glass ball) is kept or shown. ---

enum { SIZE = 40, BLOCKS = 5 };
static const double rare = 1e-4; // of a block's radiance

#define DIFFUSE(value) "<bsdf type='diffuse'><rgb name='reflectance' value='" value "'/></bsdf>"
#define PLATE(size, turn, place, bsdf)                                                                                 \
    "<shape type='rectangle'><transform name='to_world'><scale value='" size "'/><rotate " turn "/><translate " place  \
    "/></transform>" bsdf "</shape>"
#define TWO(bsdf) "<bsdf type='twosided'>" bsdf "</bsdf>"
#define MIRROR "<bsdf type='conductor'><rgb name='specular_reflectance' value='0.9 0.8 0.7'/></bsdf>"

static const char *const room =
    "<scene version='3.0.0'><integrator type='path'><integer name='max_depth' value='%d'/></integrator>"
    "<sensor type='perspective'><float name='fov' value='65'/><transform name='to_world'>"
    "<lookat origin='0.5,-5.5,3' target='0,0,1.4' up='0,0,1'/></transform><film type='hdrfilm'>"
    "<integer name='width' value='40'/><integer name='height' value='40'/><rfilter type='tent'/></film></sensor>"
    "<emitter type='constant'><rgb name='radiance' value='0.02'/></emitter>" //
    PLATE("3", "x='1' angle='0'", "z='0'", DIFFUSE("0.6 0.5 0.4")) //
    PLATE("3", "x='1' angle='90'", "y='3' z='2'", DIFFUSE("0.5")) //
    PLATE("3", "x='1' angle='180'", "z='4'", DIFFUSE("0.7")) PLATE("1.4", "x='1' angle='80'", "y='2.4' z='2.4'", MIRROR)
        PLATE("1.2", "y='1' angle='75'", "x='-2.6' y='0.5' z='1.6'", MIRROR) //
    PLATE("1.3", "x='1' angle='8'", "x='0' y='0.6' z='0.3'",
          "<bsdf type='mask'><float name='opacity' value='0.5'/>" TWO(MIRROR) "</bsdf>") //
    "<shape type='sphere'><point name='center' x='1' y='-0.8' z='0.8'/><float name='radius' value='0.6'/>"
    "<bsdf type='dielectric'/><medium type='homogeneous' name='interior'><rgb name='sigma_t' value='0.2 0.5 0.8'/>"
    "<rgb name='albedo' value='0'/></medium></shape>"
    "<shape type='luminaire'><string name='filename' value='a.safetensors'/><transform name='to_world'>"
    "<scale value='0.7'/><translate x='-0.6' y='0.4' z='2.6'/></transform></shape>"
    "<shape type='luminaire'><string name='filename' value='b.safetensors'/><string name='geometry' value='lamp.xml'/>"
    "<string name='keep' value='%s'/><string name='appearance' value='%s'/><rgb name='dim' value='0.5 1 0.7'/>"
    "<transform name='to_world'><rotate x='1' angle='30'/><scale value='0.9'/>"
    "<translate x='1.1' y='0.6' z='2.1'/></transform></shape></scene>";

static const char *const lamp =
    "<scene version='3.0.0'>" PLATE("0.4", "x='1' angle='70'", "z='-0.4'", TWO(DIFFUSE("0.6")))
        PLATE("0.4", "y='1' angle='20'", "x='-0.2' z='0.5'",
              TWO(MIRROR)) "<shape type='sphere'><point name='center' x='0.4' y='-0.3' z='0'/><float name='radius' "
                           "value='0.3'/>"
                           "<bsdf type='dielectric'/></shape>"
                           "<shape type='sphere'><point name='center' x='-0.5' y='0' z='-0.2'/><float name='radius' "
                           "value='0.1'/>" DIFFUSE(
                               "0.2") "<emitter type='area'><rgb name='radiance' value='3'/></emitter></shape></scene>";

struct composition {
    const char *keep, *appearance;
    int max_depth, passes;
};

static void load(struct scene *scene, const struct composition *composition, const struct run *run) {
    char folder[] = "/tmp/sconce_test_caustic_XXXXXX", lamp_path[100], room_path[100];
    assert_non_null(mkdtemp(folder));
    snprintf(lamp_path, sizeof lamp_path, "%s/lamp.xml", folder);
    snprintf(room_path, sizeof room_path, "%s/room.xml", folder);
    write_file(lamp_path, "%s", lamp);
    write_file(room_path, room, composition->max_depth, composition->keep, composition->appearance);
    struct error error = {0};
    enum status status = scene_load(scene, room_path, &(struct scene_options){.threads = 1}, run, &error);
    unlink(lamp_path);
    unlink(room_path);
    rmdir(folder);
    if (status != STATUS_OK) fail_msg("%s", error.text);
    assert_int_equal(scene->luminaire_count, 2);
}

struct side { // one path tracer
    void *state;
    struct film film;
};

static void side_init(struct side *side, const struct scene *scene, const struct run *run,
                      enum path_strategy strategy) {
    struct error error = {0};
    assert_int_equal(film_init(&side->film, scene->sensor, &error), STATUS_OK);
    assert_int_equal(path_create(scene, run, strategy, &side->state, &error), STATUS_OK);
}

static void side_fini(struct side *side) {
    assert_int_equal(path_dropped(side->state), 0);
    film_fini(&side->film);
    path_integrator.destroy(side->state);
}

static void side_pass(struct side *side, const struct run *run, int pass) {
    struct error error = {0};
    film_end_pass(&side->film, 1); // clears the last one
    assert_int_equal(path_integrator.render_pass(side->state, &side->film, (uint64_t)pass, run, &error), STATUS_OK);
}

static double block_mean(const struct film *film, int block, int channel) {
    double sum = 0;
    int side = SIZE / BLOCKS;
    for (int y = 0; y < side; y++)
        for (int x = 0; x < side; x++)
            sum += film->pass[3 * ((block / BLOCKS * side + y) * SIZE + block % BLOCKS * side + x) + channel];
    return sum / (side * side);
}

static void compare(const struct composition *composition) {
    struct scene scene;
    struct run run = {.threads = 2, .seed = 5};
    struct side particles, alone;
    static double sum[BLOCKS * BLOCKS][3], square[BLOCKS * BLOCKS][3];
    memset(sum, 0, sizeof sum);
    memset(square, 0, sizeof square);
    double total = 0, difference = 0, variance = 0, worst = 0, n = composition->passes;
    load(&scene, composition, &run);
    side_init(&particles, &scene, &run, PATH_MIS);
    side_init(&alone, &scene, &run, PATH_MIS_ALONE);
    for (int pass = 0; pass < composition->passes; pass++) {
        side_pass(&particles, &run, pass);
        side_pass(&alone, &run, pass);
        for (int block = 0; block < BLOCKS * BLOCKS; block++) {
            for (int c = 0; c < 3; c++) {
                double a = block_mean(&particles.film, block, c), b = block_mean(&alone.film, block, c);
                sum[block][c] += a - b;
                square[block][c] += (a - b) * (a - b);
                total += b;
            }
        }
    }
    for (int block = 0; block < BLOCKS * BLOCKS; block++) {
        for (int c = 0; c < 3; c++) {
            double mean = sum[block][c] / n, error2 = (square[block][c] / n - mean * mean) / (n - 1);
            // Chance finds of path tracing are rare where caustics are faint: no normal distribution there.
            double excess = fabs(mean) / (sqrt(error2) + rare);
            if (excess > worst) worst = excess;
            difference += mean;
            variance += error2;
        }
    }
    printf("keep %s, appearance %s, depth %d: difference %.3f %% +- %.3f %%, worst block %.2f errors\n",
           composition->keep, composition->appearance, composition->max_depth, 100 * difference * n / total,
           100 * sqrt(variance) * n / total, worst);
    side_fini(&particles);
    side_fini(&alone);
    scene_fini(&scene);
    assert_true(variance > 0); // there are caustics
    assert_true(sqrt(variance) * n / total < 0.005); // and the test sees them
    assert_true(fabs(worst) < 4.5); // 75 tests in a case
    assert_true(fabs(difference) < 3.8 * sqrt(3 * variance)); // the channels' noise is one
}

static void test_same_image(void **unused) {
    (void)unused;
    static const struct composition cases[] = {{"none", "neural", 3, 160},
                                               {"none", "geometry", 6, 160},
                                               {"opaque", "geometry", 5, 160},
                                               {"all", "neural", 7, 160}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) compare(&cases[i]);
}

static void test_threads(void **unused) {
    (void)unused;
    static const struct composition composition = {"opaque", "geometry", -1, 0};
    struct scene scene;
    struct run one = {.threads = 1, .seed = 3}, three = {.threads = 3, .seed = 3};
    struct side a, b;
    load(&scene, &composition, &one);
    side_init(&a, &scene, &one, PATH_MIS);
    side_init(&b, &scene, &three, PATH_MIS);
    for (int pass = 0; pass < 3; pass++) {
        side_pass(&a, &one, pass);
        side_pass(&b, &three, pass);
        assert_memory_equal(a.film.pass, b.film.pass, 3 * SIZE * SIZE * sizeof(float));
    }
    side_fini(&a);
    side_fini(&b);
    scene_fini(&scene);
}

// What particles bring is told to the pixels that share it, but for what falls on surfaces that their paths have
// missed.
static void test_shared(void **unused) {
    (void)unused;
    enum { passes = 16 };
    static const struct composition composition = {"none", "neural", -1, 0};
    struct scene scene;
    struct run run = {.threads = 2, .seed = 3};
    struct side side;
    struct film film;
    struct caustic *caustic;
    struct error error = {0};
    size_t dropped = 0;
    double told = 0, all = 0;
    load(&scene, &composition, &run);
    scene.share_light = true;
    side_init(&side, &scene, &run, PATH_MIS);
    assert_int_equal(film_init(&film, scene.sensor, &error), STATUS_OK);
    assert_int_equal(caustic_create(&caustic, &scene, NULL, &run, &error), STATUS_OK);
    for (int pass = 0; pass < passes; pass++) {
        side_pass(&side, &run, pass);
        assert_int_equal(caustic_render(caustic, &film, NULL, (uint64_t)pass, &run, &dropped, &error), STATUS_OK);
    }
    const struct shared_light *shared = ((const struct path_tracer *)side.state)->shared;
    for (size_t i = 0; i < SIZE * SIZE; i++) {
        all += (double)film.pass[3 * i + 1];
        for (int k = 0; k < SHARED_LAYERS; k++)
            for (int part = SHARED_CAUSTIC; part < SHARED_CAUSTIC + SHARED_WEIGHTS; part++)
                told += (double)shared->layers[k][i].parts[part].product[1];
    }
    printf("%.1f %% of the caustics are told\n", 100 * told / all);
    assert_true(told > 0.9 * all && told < 1.0001 * all);
    caustic_destroy(caustic);
    film_fini(&film);
    side_fini(&side);
    scene_fini(&scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_same_image), cmocka_unit_test(test_threads),
                                       cmocka_unit_test(test_shared)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
