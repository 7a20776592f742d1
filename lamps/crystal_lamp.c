// The lamp that speed and accuracy are measured on: 8 emitters of 4 mm, each in a clear glass shell, 238 faceted
// crystals (swags of beads, rings of drops) and a brass frame. The smaller the emitters in clear glass, the harder for
// any path tracer. Metres, y up, the centre of the lamp is the origin, everything within 0.5 m of it.
#include "writer/model.h"
#include "writer/scene_writer.h"
#include "writer/solids.h"

enum { BULBS = 8, SWAG_BEADS = 11, CUP_DROPS = 4 };

static const double ring_radius = 0.34, bulb_height = 0.085;
static const double bulb_outer = 0.026, bulb_inner = 0.0248, emitter_radius = 0.004;
static const double crown_radius = 0.13, crown_height = 0.30;

static double bulb_angle(double i) { return 2 * pi * i / BULBS; }

// The brass rings that drops hang from.
static const struct tier {
    int drops, sides;
    double ring, y, tube, radius, height;
} tiers[] = {
    {40, 8, 0.340, 0.000, 0.006, 0.0110, 0.052},  {32, 8, 0.250, -0.070, 0.004, 0.0120, 0.058},
    {24, 8, 0.170, -0.125, 0.004, 0.0130, 0.064}, {12, 6, 0.095, -0.175, 0.004, 0.0140, 0.070},
    {8, 6, 0.130, 0.300, 0.005, 0.0120, 0.056},
};

static void write_swag(struct mesh_writer *mesh, double angle) {
    static const double bead[][2] = {{0.005, 0.0085}, {0.0125, 0.0030}, {0.0125, -0.0030}, {0.005, -0.0085}};
    const struct point top = point_around(crown_radius + 0.006, crown_height - 0.004, angle);
    const struct point end = point_around(ring_radius - 0.012, 0.012, angle);
    for (int i = 0; i < SWAG_BEADS; i++) {
        double t = (i + 1.0) / (SWAG_BEADS + 1), sag = 0.20;
        struct point center = point_mix(top, end, t), along = point_sub(end, top);
        center.y -= sag * 4 * t * (1 - t) * 0.25;
        along.y -= sag * (1 - 2 * t);
        solid_gem(mesh, center, point_normalize(along), angle + i, 8, bead, COUNT(bead));
    }
}

static void write_crystals(struct mesh_writer *mesh) {
    for (int i = 0; i < BULBS; i++) write_swag(mesh, bulb_angle(i + 0.5));
    for (int i = 0; i < BULBS; i++)
        for (int j = 0; j < CUP_DROPS; j++) {
            struct point cup = point_around(ring_radius, 0.012, bulb_angle(i));
            struct point offset = point_around(0.030, 0, bulb_angle(i) + pi / 4 + 2 * pi * j / CUP_DROPS);
            solid_drop(mesh, point_add(cup, offset), 6, 0.008, 0.036, j);
        }
    for (int k = 0; k < COUNT(tiers); k++) {
        const struct tier *tier = &tiers[k];
        for (int i = 0; i < tier->drops; i++) {
            double angle = 2 * pi * (i + 0.5) / tier->drops;
            solid_drop(mesh, point_around(tier->ring, tier->y - tier->tube - 0.002, angle), tier->sides, tier->radius,
                       tier->height, angle * 3.7 + k);
        }
    }
    static const double ball[][2] = {{0.014, 0.034}, {0.030, 0.020}, {0.036, 0}, {0.030, -0.020}, {0.014, -0.034}};
    solid_gem(mesh, (struct point){0, -0.245, 0}, (struct point){0, 1, 0}, 0, 12, ball, COUNT(ball));
    solid_drop(mesh, (struct point){0, -0.288, 0}, 8, 0.016, 0.070, 0);
}

static void write_arm(struct mesh_writer *mesh, double angle) {
    enum { N = 33 };
    struct point curve[N];
    for (int i = 0; i < N; i++) {
        double t = i / (N - 1.0);
        curve[i] = point_around(0.02 + (ring_radius - 0.02) * t, 0.055 - 0.13 * sin(pi * t) * (1 - t * t), angle);
        curve[i].y -= 0.035 * t;
    }
    solid_tube(mesh, curve, N, 0.005, false);
}

static void write_brass(struct mesh_writer *mesh) {
    static const double column[][2] = {
        {0.0001, 0.44}, {0.010, 0.435}, {0.010, 0.40},  {0.022, 0.385},  {0.028, 0.365},  {0.022, 0.345},
        {0.010, 0.33},  {0.010, 0.24},  {0.020, 0.22},  {0.034, 0.18},   {0.038, 0.15},   {0.030, 0.11},
        {0.014, 0.085}, {0.030, 0.065}, {0.036, 0.050}, {0.030, 0.035},  {0.012, 0.015},  {0.010, -0.10},
        {0.024, -0.12}, {0.028, -0.14}, {0.020, -0.16}, {0.008, -0.175}, {0.008, -0.205}, {0.0001, -0.208}};
    static const double cup[][2] = {{0.0125, 0.022}, {0.0150, 0.024}, {0.0165, 0.018}, {0.012, 0.008},
                                    {0.007, 0.002},  {0.007, -0.012}, {0.0001, -0.016}};
    solid_lathe(mesh, (struct point){0, 0, 0}, column, COUNT(column));
    for (int k = 0; k < COUNT(tiers); k++) solid_ring(mesh, tiers[k].ring, tiers[k].y, tiers[k].tube);
    for (int i = 0; i < BULBS; i++) {
        write_arm(mesh, bulb_angle(i));
        solid_lathe(mesh, point_around(ring_radius, bulb_height - 0.046, bulb_angle(i)), cup, COUNT(cup));
        struct point strut[2] = {point_around(0.024, 0.365, bulb_angle(i)),
                                 point_around(crown_radius, crown_height, bulb_angle(i))};
        solid_tube(mesh, strut, 2, 0.003, false);
        for (int k = 0; k < 3; k++) { // the lower rings hang from each other
            struct point link[2] = {point_around(tiers[k].ring, tiers[k].y, bulb_angle(i)),
                                    point_around(tiers[k + 1].ring, tiers[k + 1].y, bulb_angle(i))};
            solid_tube(mesh, link, 2, 0.002, false);
        }
    }
}

static void write_scene(FILE *file) {
    scene_begin(file, "The crystal lamp, written by make_crystal_lamp: metres, y up.", (struct point){0, -0.35, 1.6},
                (struct point){0, 0.05, 0}, 35);
    scene_dielectric(file, "shell_outside", 1.5, 1.0);
    scene_dielectric(file, "shell_inside", 1.0, 1.5);
    scene_dielectric(file, "crystal", 1.6, 1.0);
    scene_brass(file, "brass", 0.1);
    scene_mesh(file, "crystals", "crystals.obj", true, "<ref id=\"crystal\"/>");
    scene_mesh(file, "frame", "brass.obj", false, "<bsdf type=\"twosided\"><ref id=\"brass\"/></bsdf>");
    for (int i = 0; i < BULBS; i++) {
        struct point center = point_around(ring_radius, bulb_height, bulb_angle(i));
        char emitter[160]; // of two groups: left and right
        snprintf(
            emitter, sizeof emitter,
            "<emitter type=\"area\" id=\"%s.%03d\"><rgb name=\"radiance\" value=\"28000, 22400, 16400\"/></emitter>",
            center.x < 0 ? "left" : "right", i + 1);
        scene_sphere(file, center, emitter_radius, emitter);
        scene_sphere(file, center, bulb_inner, "<ref id=\"shell_inside\"/>");
        scene_sphere(file, center, bulb_outer, "<ref id=\"shell_outside\"/>");
    }
    scene_end(file);
}

const struct model model = {"make_crystal_lamp", (const struct model_file[]){{"crystal_lamp.xml", .text = write_scene},
                                                                             {"crystals.obj", .mesh = write_crystals},
                                                                             {"brass.obj", .mesh = write_brass},
                                                                             {0}}};
