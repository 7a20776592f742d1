// How baked lamps compose with a room. This program has its own luminaire, whose light field is known in closed form,
// in place of the baked one: two black spheres that glow, above and below a diffuse plate. So every way of composing it
// has to give the same image as the lamp's geometry itself, path traced with its emitters on (Le on the spheres; on the
// plate rho / pi E with E = pi Le (r / d)^2 cos of a sphere wholly above the horizon; nothing gets through either).
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
#include "luminaire/hull.h"
#include "luminaire/view_field.h"
#define STAND_IN_HAS_HULL
#include "luminaire_stand_in.h"
#include "write_file.h"

// --- The luminaire: proxy = unit sphere. ---

struct luminaire {
    float albedo; // of the plate
};

static const float sphere_z = 0.6f, sphere_radius = 0.25f, plate_half = 0.6f; // plate at z = 0, spheres at +-sphere_z
static const rgb sphere_radiance = {6, 4, 2};
static struct luminaire the_luminaire;
static struct luminaire *stand_in(void) { return &the_luminaire; }

void luminaire_flux(const struct luminaire *luminaire, float flux[3]) {
    (void)luminaire;
    float area = 2 * 4 * PI_F * sphere_radius * sphere_radius;
    flux[0] = PI_F * area * sphere_radiance.r;
    flux[1] = PI_F * area * sphere_radiance.g;
    flux[2] = PI_F * area * sphere_radiance.b;
}

// First surface on the line, seen from outside against w: 0 none, 1 sphere, 2 plate.
static int first_hit(const float point[3], const float w[3], vec3 *p) {
    vec3 direction = vec3_neg(vec3_from(w));
    float t_near, t_far, t_plate = INFINITY, t_sphere = INFINITY;
    for (int side = -1; side <= 1; side += 2)
        if (sphere_span(vec3_from(point), direction, (vec3){0, 0, side * sphere_z}, sphere_radius, &t_near, &t_far))
            t_sphere = fminf(t_sphere, t_near);
    if (direction.z != 0) {
        t_plate = -point[2] / direction.z;
        vec3 at = vec3_mad(direction, t_plate, vec3_from(point));
        if (fabsf(at.x) > plate_half || fabsf(at.y) > plate_half) t_plate = INFINITY;
    }
    if (isinf(t_plate) && isinf(t_sphere)) return 0;
    *p = vec3_mad(direction, fminf(t_plate, t_sphere), vec3_from(point));
    return t_sphere < t_plate ? 1 : 2;
}

void luminaire_eval(const struct luminaire *luminaire, size_t n, const float (*point)[3], const float (*w)[3],
                    float (*radiance)[3]) {
    for (size_t i = 0; i < n; i++) {
        vec3 p;
        int hit = first_hit(point[i], w[i], &p);
        float scale = hit == 1;
        if (hit == 2) {
            float d2 = p.x * p.x + p.y * p.y + sphere_z * sphere_z;
            scale = luminaire->albedo * sphere_radius * sphere_radius / d2 * sphere_z / sqrtf(d2);
        }
        radiance[i][0] = scale * sphere_radiance.r;
        radiance[i][1] = scale * sphere_radiance.g;
        radiance[i][2] = scale * sphere_radiance.b;
    }
}

void luminaire_transmittance(const struct luminaire *luminaire, size_t n, const float (*point)[3], const float (*w)[3],
                             float (*transmittance)[3]) {
    (void)luminaire;
    for (size_t i = 0; i < n; i++) {
        vec3 p;
        transmittance[i][0] = transmittance[i][1] = transmittance[i][2] = first_hit(point[i], w[i], &p) ? 0 : 1;
    }
}

// --- Its hull: part 0 the spheres, finely tessellated, part 1 the plate, which must be black. ---

enum { ROWS = 96, COLUMNS = 192 };
static struct hull *the_hull;

static void hull_add_vertex(double x, double y, double z, vec3 normal) {
    hull_set_vertex(the_hull, the_hull->vertex_count, (vec3){(float)x, (float)y, (float)z});
    hull_set_normal(the_hull, the_hull->vertex_count++, normal);
}

static void hull_add_triangle(size_t a, size_t b, size_t c) {
    uint16_t *v = the_hull->triangles[the_hull->triangle_count++];
    v[0] = (uint16_t)a, v[1] = (uint16_t)b, v[2] = (uint16_t)c;
}

static int make_hull(void **state) {
    (void)state;
    struct error error;
    if (hull_allocate(&the_hull, 2 * (ROWS + 1) * COLUMNS + 4, 4 * ROWS * COLUMNS + 2, &error)) return -1;
    the_hull->vertex_count = the_hull->triangle_count = 0;
    for (int a = 0; a < 3; a++) the_hull->lower[a] = -1, the_hull->step[a] = 2.0f / HULL_MAX_CODE;
    for (int side = -1; side <= 1; side += 2) {
        size_t first = the_hull->vertex_count;
        double radius = (double)sphere_radius * 1.0002; // of equal cross-section
        for (int i = 0; i <= ROWS; i++)
            for (int j = 0; j < COLUMNS; j++) {
                double theta = M_PI * i / ROWS, phi = 2 * M_PI * j / COLUMNS;
                double x = sin(theta) * cos(phi), y = sin(theta) * sin(phi), z = cos(theta);
                hull_add_vertex(radius * x, radius * y, radius * z + side * (double)sphere_z,
                                (vec3){(float)x, (float)y, (float)z});
            }
        for (size_t i = 0; i < ROWS; i++)
            for (size_t j = 0; j < COLUMNS; j++) {
                size_t a = first + i * COLUMNS + j, b = first + i * COLUMNS + (j + 1) % COLUMNS;
                hull_add_triangle(a, a + COLUMNS, b + COLUMNS);
                hull_add_triangle(a, b + COLUMNS, b);
            }
    }
    size_t spheres = the_hull->triangle_count, corner = the_hull->vertex_count;
    for (int i = 0; i < 4; i++)
        hull_add_vertex((i & 1 ? 1 : -1) * (double)plate_half, (i & 2 ? 1 : -1) * (double)plate_half, 0,
                        (vec3){0, 0, 1});
    hull_add_triangle(corner, corner + 1, corner + 3);
    hull_add_triangle(corner, corner + 3, corner + 2);
    the_hull->parts[0] = (struct hull_part){.kind = HULL_OPAQUE, .smooth = true, .count = (uint32_t)spheres};
    the_hull->parts[1] = (struct hull_part){.kind = HULL_OPAQUE, .first = (uint32_t)spheres, .count = 2};
    the_hull->part_count = 2;
    return hull_check(the_hull, (float[3]){0, 0, 0}, 1, &error);
}

static int drop_hull(void **state) {
    (void)state;
    hull_destroy(the_hull);
    return 0;
}

const struct hull *luminaire_hull(const struct luminaire *luminaire) {
    (void)luminaire;
    return the_hull;
}

void luminaire_view(const struct luminaire *luminaire, size_t n, const struct view_point *points,
                    float (*radiance)[3]) {
    (void)luminaire;
    for (size_t i = 0; i < n; i++) {
        float scale = points[i].part == 0;
        radiance[i][0] = scale * sphere_radiance.r;
        radiance[i][1] = scale * sphere_radiance.g;
        radiance[i][2] = scale * sphere_radiance.b;
    }
}

// --- The room, with the lamp's geometry in it. ---

enum { SIZE = 48, BLOCKS = 6 };

#define DIFFUSE(value) "<bsdf type='diffuse'><rgb name='reflectance' value='" value "'/></bsdf>"

static const char *const room =
    "<scene version='3.0.0'><integrator type='path'><integer name='max_depth' value='6'/></integrator>"
    "<sensor type='perspective'><float name='fov' value='50'/><transform name='to_world'>"
    "<lookat origin='3,-4,3' target='0,0,1' up='0,0,1'/></transform><film type='hdrfilm'><integer name='width' "
    "value='48'/>"
    "<integer name='height' value='48'/><rfilter type='box'/></film></sensor>"
    "<emitter type='constant'><rgb name='radiance' value='0.3 0.5 0.7'/></emitter>"
    "<shape type='rectangle'><transform name='to_world'><scale x='4' y='4' z='1'/></transform>" DIFFUSE(
        "0.6") "</shape>"
               "<shape type='rectangle'><transform name='to_world'><scale x='4' y='4' z='1'/><rotate x='1' angle='90'/>"
               "<translate y='2'/></transform><bsdf type='roughconductor'><float name='alpha' "
               "value='0.2'/></bsdf></shape>"
               "<shape type='sphere'><point name='center' x='-1' y='-0.5' z='3.2'/><float name='radius' "
               "value='0.2'/>" DIFFUSE(
                   "0") "<emitter type='area'><rgb name='radiance' value='25'/></emitter></shape>"
                        // within the proxy but outside the lamp, all of which lies ahead of it on chords through the
                        // proxy
                        "<shape type='sphere'><point name='center' x='0.8' y='-0.5' z='1.25'/><float name='radius' "
                        "value='0.12'/>" DIFFUSE("0.8") "</shape>"
                                                        "%s</scene>";

#define BULB(z)                                                                                                        \
    "<shape type='sphere'><transform name='to_world'><scale value='0.25'/><translate z='" z                            \
    "'/></transform>" DIFFUSE("0") "<emitter type='area'><rgb name='radiance' value='6 4 2'/></emitter></shape>"

static const char *const lamp = "<scene version='3.0.0'>" BULB("0.6")
    BULB("-0.6") "<shape type='rectangle'><transform name='to_world'><scale x='0.6' y='0.6' z='1'/></transform><bsdf "
                 "type='twosided'>"
                 "<bsdf type='diffuse'><rgb name='reflectance' value='%g'/></bsdf></bsdf></shape></scene>";

static const char *const placed_lamp = "<shape type='luminaire'><string name='filename' value='%s'/>%s<transform "
                                       "name='to_world'><rotate x='1' angle='25'/>"
                                       "<scale value='0.8'/><translate x='0.3' y='-0.2' z='1.5'/></transform></shape>";

struct blocks {
    double mean[BLOCKS * BLOCKS][3], variance[BLOCKS * BLOCKS][3], total[3];
};

struct composition {
    bool baked;
    const char *keep, *appearance;
};

static void load(struct scene *scene, struct composition composition, float albedo, const struct run *run) {
    char folder[] = "/tmp/sconce_test_lamp_XXXXXX", lamp_path[100], room_path[100], options[400] = "", lamp_text[1000];
    assert_non_null(mkdtemp(folder));
    snprintf(lamp_path, sizeof lamp_path, "%s/lamp.xml", folder);
    snprintf(room_path, sizeof room_path, "%s/room.xml", folder);
    write_file(lamp_path, lamp, albedo);
    if (composition.baked)
        snprintf(options, sizeof options,
                 "<string name='keep' value='%s'/><string name='appearance' value='%s'/>"
                 "<string name='geometry' value='lamp.xml'/>",
                 composition.keep, composition.appearance);
    snprintf(lamp_text, sizeof lamp_text, placed_lamp, composition.baked ? "baked.safetensors" : "lamp.xml", options);
    write_file(room_path, room, lamp_text);
    the_luminaire.albedo = albedo;
    struct error error = {0};
    enum status status = scene_load(scene, room_path, &(struct scene_options){.threads = 1}, run, &error);
    unlink(lamp_path);
    unlink(room_path);
    rmdir(folder);
    if (status != STATUS_OK) fail_msg("%s", error.text);
    assert_int_equal(scene->luminaire_count, composition.baked);
}

static void render(struct composition composition, float albedo, enum path_strategy strategy, int passes,
                   struct blocks *blocks) {
    struct scene scene;
    struct error error = {0};
    struct run run = {.threads = 2, .seed = 11 + composition.baked};
    load(&scene, composition, albedo, &run);
    void *state;
    struct film film;
    struct image image;
    assert_int_equal(film_init(&film, scene.sensor, &error), STATUS_OK);
    assert_int_equal(path_create(&scene, &run, strategy, &state, &error), STATUS_OK);
    for (int pass = 0; pass < passes; pass++) {
        assert_int_equal(path_integrator.render_pass(state, &film, pass, &run, &error), STATUS_OK);
        film_end_pass(&film, 1);
    }
    assert_int_equal(path_dropped(state), 0);
    assert_int_equal(film_image(&film, &image, &error), STATUS_OK);
    memset(blocks, 0, sizeof *blocks);
    double share = BLOCKS * BLOCKS / (double)(SIZE * SIZE);
    for (int y = 0; y < SIZE; y++) {
        for (int x = 0; x < SIZE; x++) {
            int block = y * BLOCKS / SIZE * BLOCKS + x * BLOCKS / SIZE;
            const float *pixel = image.pixels + 6 * (y * SIZE + x);
            for (int c = 0; c < 3; c++) {
                blocks->mean[block][c] += pixel[c] * share;
                blocks->variance[block][c] += pixel[3 + c] * share * share;
                blocks->total[c] += pixel[c] / (SIZE * SIZE);
            }
        }
    }
    image_fini(&image);
    film_fini(&film);
    path_integrator.destroy(state);
    scene_fini(&scene);
}

// Every block of the image within its noise; 36 blocks and a family of cases, hence five standard errors.
static void compare(const char *name, const struct blocks *a, const struct blocks *b) {
    for (int i = 0; i < BLOCKS * BLOCKS; i++) {
        for (int c = 0; c < 3; c++) {
            double error = sqrt(a->variance[i][c] + b->variance[i][c]);
            if (fabs(a->mean[i][c] - b->mean[i][c]) > 5 * error + 2e-3 * b->mean[i][c])
                fail_msg("%s: block %d, channel %d: %g, reference %g, noise %g", name, i, c, a->mean[i][c],
                         b->mean[i][c], error);
        }
    }
    for (int c = 0; c < 3; c++)
        if (fabs(a->total[c] / b->total[c] - 1) > 0.01)
            fail_msg("%s: total %g, reference %g", name, a->total[c], b->total[c]);
}

static const struct composition geometry = {false, "", ""};

// With a black plate nothing of the room's light comes back from the lamp: every composition is exact.
static void test_black_lamp(void **unused) {
    (void)unused;
    static const struct composition cases[] = {
        {true, "none", "neural"},   {true, "none", "surface"},    {true, "none", "geometry"},
        {true, "opaque", "neural"}, {true, "opaque", "geometry"},
    };
    struct blocks reference, blocks;
    render(geometry, 0, PATH_MIS, 128, &reference);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char name[100];
        snprintf(name, sizeof name, "black plate, keep %s, appearance %s", cases[i].keep, cases[i].appearance);
        render(cases[i], 0, PATH_MIS, 128, &blocks);
        compare(name, &blocks, &reference);
    }
}

// With all geometry kept, the room's light on the lamp and the lamp's own are both complete, however it is seen.
static void test_kept_geometry(void **unused) {
    (void)unused;
    static const struct {
        struct composition composition;
        enum path_strategy strategy;
        int passes;
    } cases[] = {
        {{true, "all", "geometry"}, PATH_MIS, 128},         {{true, "all", "neural"}, PATH_MIS, 128},
        {{true, "all", "geometry"}, PATH_LIGHTS_ONLY, 128}, {{true, "all", "neural"}, PATH_LIGHTS_ONLY, 128},
        {{true, "all", "neural"}, PATH_BSDF_ONLY, 256},
    };
    struct blocks reference, blocks;
    render(geometry, 0.7f, PATH_MIS, 256, &reference);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char name[100];
        snprintf(name, sizeof name, "keep all, appearance %s, strategy %d", cases[i].composition.appearance,
                 cases[i].strategy);
        render(cases[i].composition, 0.7f, cases[i].strategy, cases[i].passes, &blocks);
        compare(name, &blocks, &reference);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_black_lamp), cmocka_unit_test(test_kept_geometry)};
    return cmocka_run_group_tests(tests, make_hull, drop_hull);
}
