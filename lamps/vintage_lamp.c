// After the vintage crystal chandelier of Zhu et al. 2021: 12 flame-shaped bulbs of clear glass, 144 fluted rough-glass
// crystals (118 000 triangles), a gold frame and a brass band, which `keep = opaque` leaves as geometry. Metres, y up,
// about the origin.
#include "writer/model.h"
#include "writer/scene_writer.h"
#include "writer/solids.h"

enum { BULBS = 12, PROFILE = 20, CRYSTAL_SIDES = 24, CRYSTAL_RINGS = 17 };

static const double bulb_ring = 0.255, bulb_foot = 0.075, bulb_height = 0.085, bulb_radius = 0.019, bulb_wall = 0.0014;

static const struct tier {
    int crystals;
    double ring, y, radius, height;
} tiers[] = {{48, 0.345, -0.052, 0.0135, 0.075},
             {36, 0.255, -0.085, 0.0140, 0.085},
             {24, 0.165, -0.125, 0.0145, 0.095},
             {12, 0.080, -0.165, 0.0150, 0.105},
             {24, 0.150, 0.285, 0.0110, 0.065}};

// A flame's outline, from the tip down, at a distance inside the bulb's surface.
static void flame_profile(double profile[PROFILE + 1][2], double inside) {
    for (int i = 0; i <= PROFILE; i++) {
        double t = 1 - i / (double)PROFILE, shape = pow(sin(pi * pow(t, 0.62)), 0.85);
        double scale = (bulb_radius - inside) / bulb_radius;
        profile[i][0] = i == 0 || i == PROFILE ? 0 : (bulb_radius - inside) * shape;
        profile[i][1] = 0.40 * bulb_height + (t - 0.40) * bulb_height * scale;
    }
}

static struct point foot(int bulb) { return point_around(bulb_ring, bulb_foot, 2 * pi * (bulb + 0.5) / BULBS); }

static void write_bulbs(struct mesh_writer *mesh) {
    double outer[PROFILE + 1][2], inner[PROFILE + 1][2], upwards[PROFILE + 1][2];
    flame_profile(outer, 0);
    flame_profile(inner, bulb_wall);
    for (int i = 0; i <= PROFILE; i++)
        for (int k = 0; k < 2; k++) upwards[i][k] = inner[PROFILE - i][k];
    for (int i = 0; i < BULBS; i++) {
        solid_turned(mesh, foot(i), outer, PROFILE + 1, 32);
        solid_turned(mesh, foot(i), upwards, PROFILE + 1, 32);
    }
}

static void write_flames(struct mesh_writer *mesh) {
    double flame[PROFILE + 1][2];
    flame_profile(flame, 0.014);
    for (int i = 0; i < BULBS; i++) solid_turned(mesh, foot(i), flame, PROFILE + 1, 16);
}

static void add_crystal(struct mesh_writer *mesh, struct point hook, double radius, double height, double turn) {
    int first = mesh->vertices + 1, last = first + (CRYSTAL_RINGS - 1) * CRYSTAL_SIDES;
    mesh_vertex(mesh, hook);
    for (int i = 1; i <= CRYSTAL_RINGS; i++)
        for (int j = 0; j < CRYSTAL_SIDES; j++) {
            double t = i / (CRYSTAL_RINGS + 1.0), angle = 2 * pi * j / CRYSTAL_SIDES;
            double r = radius * sin(pi * pow(t, 1.7)) * (1 + 0.10 * cos(6 * angle));
            mesh_vertex(mesh, point_add(hook, point_around(r, -height * t, angle + turn)));
        }
    mesh_vertex(mesh, point_add(hook, (struct point){0, -height, 0}));
    for (int j = 0; j < CRYSTAL_SIDES; j++) {
        int k = (j + 1) % CRYSTAL_SIDES;
        mesh_triangle(mesh, first - 1, first + k, first + j);
        mesh_triangle(mesh, last + CRYSTAL_SIDES, last + j, last + k);
    }
    solid_grid(mesh, first, CRYSTAL_RINGS, CRYSTAL_SIDES, false);
}

static void write_crystals(struct mesh_writer *mesh) {
    for (int k = 0; k < COUNT(tiers); k++)
        for (int i = 0; i < tiers[k].crystals; i++) {
            double angle = 2 * pi * (i + 0.5) / tiers[k].crystals;
            add_crystal(mesh, point_around(tiers[k].ring, tiers[k].y, angle), tiers[k].radius, tiers[k].height, angle);
        }
}

static void write_gold(struct mesh_writer *mesh) {
    enum { N = 25 };
    static const double column[][2] = {{0, 0.45},      {0.012, 0.445}, {0.012, 0.40},  {0.030, 0.38},  {0.036, 0.355},
                                       {0.030, 0.33},  {0.012, 0.31},  {0.010, 0.20},  {0.024, 0.17},  {0.040, 0.12},
                                       {0.044, 0.09},  {0.036, 0.055}, {0.016, 0.02},  {0.014, -0.06}, {0.030, -0.09},
                                       {0.034, -0.11}, {0.024, -0.14}, {0.010, -0.17}, {0.012, -0.20}, {0, -0.22}};
    static const double cup[][2] = {{0.0135, 0.014}, {0.0165, 0.016}, {0.0175, 0.010}, {0.011, -0.004},
                                    {0.007, -0.010}, {0.007, -0.055}, {0.015, -0.064}, {0, -0.072}};
    solid_turned(mesh, (struct point){0, 0, 0}, column, COUNT(column), 48);
    for (int k = 0; k < COUNT(tiers); k++) solid_ring(mesh, tiers[k].ring, tiers[k].y + 0.006, 0.004);
    for (int i = 0; i < BULBS; i++) {
        double angle = 2 * pi * (i + 0.5) / BULBS;
        solid_turned(mesh, foot(i), cup, COUNT(cup), 24);
        struct point arm[N], chain[N];
        for (int j = 0; j < N; j++) {
            double t = j / (N - 1.0);
            arm[j] = point_around(0.02 + (bulb_ring - 0.02) * t, 0.04 - 0.10 * sin(pi * t) * (1 - 0.4 * t) - 0.03 * t,
                                  angle);
            chain[j] = point_around(0.150 + 0.19 * t, 0.288 - 0.272 * t - 0.11 * sin(pi * t), angle - pi / BULBS);
        }
        solid_tube(mesh, arm, N, 0.0045, false);
        solid_tube(mesh, chain, N, 0.003, false);
        solid_tube(mesh, (struct point[]){point_around(0.03, 0.36, angle), point_around(0.150, 0.291, angle)}, 2, 0.003,
                   false);
        for (int k = 0; k < 3; k++)
            solid_tube(mesh,
                       (struct point[]){point_around(tiers[k].ring, tiers[k].y + 0.006, angle - pi / BULBS),
                                        point_around(tiers[k + 1].ring, tiers[k + 1].y + 0.006, angle - pi / BULBS)},
                       2, 0.002, false);
    }
}

static void write_band(struct mesh_writer *mesh) {
    static const double band[][2] = {{0.340, 0.030},  {0.352, 0.030},  {0.356, 0.024},  {0.350, 0.016}, {0.350, -0.026},
                                     {0.356, -0.034}, {0.352, -0.040}, {0.340, -0.040}, {0.340, 0.030}};
    solid_turned(mesh, (struct point){0, 0, 0}, band, COUNT(band), 192);
}

static void write_scene(FILE *file) {
    scene_begin(file, "The vintage crystal lamp, written by make_vintage_lamp: metres, y up.",
                (struct point){0, -0.35, 1.6}, (struct point){0, 0.05, 0}, 35);
    scene_dielectric(file, "clear", 1.5, 1.0);
    scene_rough_glass(file, "crystal", 0.08, "1, 1, 1");
    scene_metal(file, "gold", 0.1, "0.143, 0.375, 1.442", "3.983, 2.386, 1.603");
    scene_brass(file, "brass", 0.2);
    scene_mesh(file, "bulbs", "bulbs.obj", false, "<ref id=\"clear\"/>");
    scene_mesh(file, "flames", "flames.obj", false,
               "<emitter type=\"area\"><rgb name=\"radiance\" value=\"6000, 4700, 3200\"/></emitter>");
    scene_mesh(file, "crystals", "crystals.ply", false, "<ref id=\"crystal\"/>");
    scene_mesh(file, "frame", "gold.obj", false, "<bsdf type=\"twosided\"><ref id=\"gold\"/></bsdf>");
    scene_mesh(file, "band", "band.obj", false, "<bsdf type=\"twosided\"><ref id=\"brass\"/></bsdf>");
    scene_end(file);
}

const struct model model = {"make_vintage_lamp", (const struct model_file[]){{"vintage_lamp.xml", .text = write_scene},
                                                                             {"bulbs.obj", .mesh = write_bulbs},
                                                                             {"flames.obj", .mesh = write_flames},
                                                                             {"crystals.ply", .mesh = write_crystals},
                                                                             {"gold.obj", .mesh = write_gold},
                                                                             {"band.obj", .mesh = write_band},
                                                                             {0}}};
