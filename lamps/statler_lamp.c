// After the Statler chandelier of Zhu et al. 2021: 51 smooth glass tubes (IOR 1.3), closed below like test tubes, hang
// from a metal cylinder; a small emitter hides in a socket at the top of each. Metres, y up, about the origin.
#include "writer/model.h"
#include "writer/scene_writer.h"
#include "writer/solids.h"

enum { TUBES = 51, ROUND = 8 };

static const double base_bottom = 0.26, tube_outer = 0.019, tube_inner = 0.0165, emitter_radius = 0.005;

static const struct circle {
    int tubes;
    double radius, length;
} circles[] = {{1, 0, 0.56}, {8, 0.085, 0.50}, {16, 0.165, 0.53}, {26, 0.245, 0.50}};

struct tube {
    struct point top;
    double length;
};

static void place_tubes(struct tube tubes[TUBES]) {
    int n = 0;
    for (int c = 0; c < COUNT(circles); c++)
        for (int i = 0; i < circles[c].tubes; i++) {
            double angle = 2 * pi * (i + 0.5 * (c & 1)) / circles[c].tubes;
            tubes[n++] = (struct tube){point_around(circles[c].radius, base_bottom - 0.012, angle),
                                       circles[c].length + 0.04 * (i % 2)};
        }
}

static void write_tubes(struct mesh_writer *mesh) {
    struct tube tubes[TUBES];
    place_tubes(tubes);
    for (int t = 0; t < TUBES; t++) {
        double profile[2 * ROUND + 4][2], middle = -tubes[t].length + tube_outer; // of both round ends
        for (int i = 0; i <= ROUND; i++) {
            double *inner = profile[i], *outer = profile[2 * ROUND + 3 - i], angle = 0.5 * pi * i / ROUND;
            inner[0] = i ? tube_inner * sin(angle) : 0;
            inner[1] = middle - tube_inner * cos(angle);
            outer[0] = i ? tube_outer * sin(angle) : 0;
            outer[1] = middle - tube_outer * cos(angle);
        }
        profile[ROUND + 1][0] = tube_inner;
        profile[ROUND + 2][0] = tube_outer;
        profile[ROUND + 1][1] = profile[ROUND + 2][1] = 0;
        solid_turned(mesh, tubes[t].top, profile, COUNT(profile), 32);
    }
}

static void write_metal(struct mesh_writer *mesh) {
    static const double base[][2] = {{0, 0.370},     {0.060, 0.370}, {0.060, 0.355}, {0.285, 0.355},
                                     {0.290, 0.350}, {0.290, 0.265}, {0.285, 0.26},  {0, 0.26}};
    static const double socket[][2] = {{0.0215, 0.0125}, {0.0215, -0.024}};
    struct tube tubes[TUBES];
    place_tubes(tubes);
    solid_turned(mesh, (struct point){0, 0, 0}, base, COUNT(base), 128);
    for (int t = 0; t < TUBES; t++) solid_turned(mesh, tubes[t].top, socket, COUNT(socket), 24);
}

static void write_scene(FILE *file) {
    struct tube tubes[TUBES];
    place_tubes(tubes);
    scene_begin(file, "The Statler lamp, written by make_statler_lamp: metres, y up.", (struct point){0, -0.35, 1.7},
                (struct point){0, 0, 0}, 35);
    scene_dielectric(file, "glass", 1.3, 1.0);
    scene_metal(file, "nickel", 0.15, "1.986, 1.794, 1.654", "3.748, 3.229, 2.780");
    scene_mesh(file, "tubes", "tubes.ply", false, "<ref id=\"glass\"/>");
    scene_mesh(file, "base", "metal.obj", false, "<bsdf type=\"twosided\"><ref id=\"nickel\"/></bsdf>");
    for (int t = 0; t < TUBES; t++)
        scene_sphere(file, point_add(tubes[t].top, (struct point){0, -0.012, 0}), emitter_radius,
                     "<emitter type=\"area\"><rgb name=\"radiance\" value=\"4400, 3700, 2900\"/></emitter>");
    scene_end(file);
}

const struct model model = {"make_statler_lamp", (const struct model_file[]){{"statler_lamp.xml", .text = write_scene},
                                                                             {"tubes.ply", .mesh = write_tubes},
                                                                             {"metal.obj", .mesh = write_metal},
                                                                             {0}}};
