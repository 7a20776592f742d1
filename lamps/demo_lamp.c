// The project's own demonstration lamp: a chandelier of 8 bulbs (an emitting sphere of 8 mm in a clear glass
// shell), 153 faceted crystals and a brass frame. Units are metres, y is up, the centre of the lamp is the origin,
// everything lies within 0.5 m of it.
#include "writer/model.h"
#include "writer/scene_writer.h"
#include "writer/solids.h"

enum { BULBS = 8 };

static const double ring_radius = 0.36, bulb_height = 0.075;
static const double bulb_outer = 0.030, bulb_inner = 0.0285, emitter_radius = 0.008;

// An S-shaped arm from the column to the bulb's cup.
static void write_arm(struct mesh_writer *mesh, double angle) {
    enum { N = 33 };
    struct point curve[N];
    for (int i = 0; i < N; i++) {
        double t = i / (double)(N - 1), radius = 0.02 + (ring_radius - 0.02) * t;
        curve[i] = point_around(radius, 0.10 - 0.10 * sin(1.5 * pi * t) * (1 - t) - 0.095 * t * t, angle);
    }
    solid_tube(mesh, curve, N, 0.005, false);
}

static void write_brass(struct mesh_writer *mesh) {
    static const double column[][2] = {{0.0001, 0.46},  {0.012, 0.455}, {0.012, 0.36},  {0.030, 0.345}, {0.038, 0.32},
                                       {0.030, 0.295},  {0.012, 0.28},  {0.012, 0.22},  {0.022, 0.19},  {0.045, 0.15},
                                       {0.052, 0.12},   {0.045, 0.09},  {0.020, 0.05},  {0.014, 0.02},  {0.014, -0.05},
                                       {0.030, -0.08},  {0.038, -0.1},  {0.030, -0.12}, {0.012, -0.14}, {0.006, -0.19},
                                       {0.0001, -0.195}};
    static const double cup[][2] = {{0.0145, 0.026}, {0.0165, 0.027}, {0.0175, 0.020}, {0.014, 0.010},
                                    {0.008, 0.004},  {0.008, -0.012}, {0.0001, -0.016}};
    solid_lathe(mesh, (struct point){0, 0, 0}, column, COUNT(column));
    solid_ring(mesh, ring_radius, -0.002, 0.006);
    solid_ring(mesh, 0.20, 0.245, 0.004);
    for (int i = 0; i < BULBS; i++) {
        double angle = 2 * pi * i / BULBS;
        write_arm(mesh, angle);
        solid_lathe(mesh, point_around(ring_radius, 0.018, angle), cup, COUNT(cup));
        struct point strut[2] = {point_around(0.030, 0.32, angle), point_around(0.20, 0.245, angle)};
        solid_tube(mesh, strut, 2, 0.003, false);
    }
}

static void write_crystals(struct mesh_writer *mesh) {
    static const struct {
        int count, sides;
        double ring, y, radius, height;
    } rows[] = {
        {48, 8, 0.360, -0.020, 0.0125, 0.050}, {36, 8, 0.285, -0.050, 0.0140, 0.058},
        {28, 6, 0.205, -0.090, 0.0150, 0.066}, {16, 6, 0.120, -0.130, 0.0165, 0.078},
        {1, 12, 0.000, -0.210, 0.0400, 0.110}, {24, 8, 0.200, 0.230, 0.0120, 0.060},
    };
    for (int r = 0; r < COUNT(rows); r++)
        for (int i = 0; i < rows[r].count; i++) {
            double angle = 2 * pi * (i + 0.5) / rows[r].count;
            solid_drop(mesh, point_around(rows[r].ring, rows[r].y, angle), rows[r].sides, rows[r].radius,
                       rows[r].height, angle * 3.7 + r);
        }
}

static void write_scene(FILE *file) {
    scene_begin(file, "The demonstration lamp, written by make_demo_lamp: metres, y up.", (struct point){0, -0.35, 1.7},
                (struct point){0, 0.06, 0}, 35);
    scene_dielectric(file, "shell_outside", 1.5, 1.0);
    scene_dielectric(file, "shell_inside", 1.0, 1.5);
    scene_dielectric(file, "crystal", 1.6, 1.0);
    scene_brass(file, "brass", 0.12);
    scene_mesh(file, "crystals", "crystals.obj", true, "<ref id=\"crystal\"/>");
    scene_mesh(file, "frame", "brass.obj", false, "<bsdf type=\"twosided\"><ref id=\"brass\"/></bsdf>");
    for (int i = 0; i < BULBS; i++) {
        struct point center = point_around(ring_radius, bulb_height, 2 * pi * i / BULBS);
        scene_sphere(file, center, emitter_radius,
                     "<emitter type=\"area\"><rgb name=\"radiance\" value=\"7000, 5600, 4100\"/></emitter>");
        scene_sphere(file, center, bulb_inner, "<ref id=\"shell_inside\"/>");
        scene_sphere(file, center, bulb_outer, "<ref id=\"shell_outside\"/>");
    }
    scene_end(file);
}

const struct model model = {"make_demo_lamp", (const struct model_file[]){{"demo_lamp.xml", .text = write_scene},
                                                                          {"crystals.obj", .mesh = write_crystals},
                                                                          {"brass.obj", .mesh = write_brass},
                                                                          {0}}};
