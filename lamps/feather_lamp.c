// After the white feather lamp of Zhu et al. 2021: two bulbs in a clear glass ellipsoid shell under 2000 opaque
// feathers, whose barbs are cut out: 1.1 million triangles. Metres, y up, about the origin.
#include <stdint.h>

#include "writer/model.h"
#include "writer/scene_writer.h"
#include "writer/solids.h"

enum { FEATHERS = 2000, SPINE = 20, BARBS = 90 }; // BARBS on each side of a feather

static const double shell_width = 0.150, shell_height = 0.110, shell_wall = 0.004;
static const double root_width = 0.185, root_height = 0.145; // the ellipsoid that the feathers grow from

// A number in [0, 1) that depends on the two only (Wellons' integer hash).
static double hash(int feather, int which) {
    uint32_t h = (uint32_t)feather * 64u + (uint32_t)which;
    h = (h ^ h >> 16) * 0x7feb352du;
    h = (h ^ h >> 15) * 0x846ca68bu;
    return (double)(h ^ h >> 16) / 4294967296.0;
}

struct feather {
    struct point root, out, along, across; // out: away from the lamp; along: the way it lies
    double length, width, rise, curl;
};

static struct feather make_feather(int i) {
    // Spread evenly over the ellipsoid but for an opening at the top, where the cord enters (Fibonacci spiral).
    double y = 0.93 - 1.93 * (i + 0.5) / FEATHERS, angle = i * pi * (3 - sqrt(5)), r = sqrt(1 - y * y);
    struct point unit = point_around(r, y, angle);
    struct feather feather = {
        .root = {unit.x * root_width, unit.y * root_height, unit.z * root_width},
        .out = point_normalize((struct point){unit.x / root_width, unit.y / root_height, unit.z / root_width}),
        .length = 0.080 + 0.040 * hash(i, 0),
        .width = 0.015 + 0.008 * hash(i, 1),
        .rise = 0.35 + 0.40 * hash(i, 2),
        .curl = 0.5 + 0.7 * hash(i, 3),
    };
    // Hanging down along the ellipsoid, each a little askew.
    double skew = (hash(i, 4) - 0.5) * 1.6;
    struct point side = point_normalize(point_cross((struct point){0.02, 1, 0.01}, feather.out));
    struct point down = point_cross(side, feather.out);
    down = down.y > 0 ? point_scale(down, -1) : down;
    feather.along = point_normalize(point_add(point_scale(down, cos(skew)), point_scale(side, sin(skew))));
    feather.across = point_cross(feather.out, feather.along);
    return feather;
}

// The feather's surface, s in [0, 1] along its shaft, `across` in metres: it rises, then curls out and away.
static struct point feather_point(const struct feather *feather, double s, double across) {
    double turn = feather->rise + feather->curl * (s - 0.6), at = s * feather->length;
    double bow = 8 * across * across; // hollow below
    struct point p = point_add(feather->root, point_scale(feather->along, at * cos(turn)));
    p = point_add(p, point_scale(feather->out, at * sin(turn) - bow));
    return point_add(p, point_scale(feather->across, across));
}

static double feather_half_width(const struct feather *feather, double s) {
    return feather->width * sqrt(s) * pow(1 - s, 0.35) * 1.35;
}

static void add_feather(struct mesh_writer *mesh, const struct feather *feather) {
    int first = mesh->vertices;
    for (int i = 0; i <= SPINE; i++) {
        double s = i / (double)SPINE, half = 0.0006 * (1.1 - s);
        mesh_vertex(mesh, feather_point(feather, s, -half));
        mesh_vertex(mesh, feather_point(feather, s, half));
    }
    for (int i = 0; i < SPINE; i++) {
        int a = first + 2 * i;
        mesh_triangle(mesh, a, a + 1, a + 3);
        mesh_triangle(mesh, a, a + 3, a + 2);
    }
    // A barb sweeps forward from the shaft: two roots, two points half-way, a tip; gaps between the barbs let light by.
    for (int side = -1; side <= 1; side += 2)
        for (int b = 0; b < BARBS; b++) {
            double s = 0.06 + 0.90 * b / BARBS, thick = 0.45 * 0.90 / BARBS, half = feather_half_width(feather, s);
            double sweep = 0.10 + 0.06 * (1 - s);
            int v = mesh->vertices;
            mesh_vertex(mesh, feather_point(feather, s, 0));
            mesh_vertex(mesh, feather_point(feather, s + thick, 0));
            mesh_vertex(mesh, feather_point(feather, s + 0.4 * sweep, side * 0.55 * half));
            mesh_vertex(mesh, feather_point(feather, s + 0.4 * sweep + thick, side * 0.55 * half));
            mesh_vertex(mesh, feather_point(feather, fmin(s + sweep + 0.5 * thick, 1.02), side * half));
            mesh_triangle(mesh, v, v + 1, v + 3);
            mesh_triangle(mesh, v, v + 3, v + 2);
            mesh_triangle(mesh, v + 2, v + 3, v + 4);
        }
}

static void write_feathers(struct mesh_writer *mesh) {
    for (int i = 0; i < FEATHERS; i++) {
        struct feather feather = make_feather(i);
        add_feather(mesh, &feather);
    }
}

// Two ellipsoids; the inner one faces inwards.
static void write_shell(struct mesh_writer *mesh) {
    enum { ROWS = 48 };
    for (int k = 0; k < 2; k++) {
        double profile[ROWS + 1][2], width = shell_width - k * shell_wall, height = shell_height - k * shell_wall;
        for (int i = 0; i <= ROWS; i++) {
            double angle = pi * (k ? ROWS - i : i) / ROWS;
            profile[i][0] = i == 0 || i == ROWS ? 0 : width * sin(angle);
            profile[i][1] = height * cos(angle);
        }
        solid_turned(mesh, (struct point){0, 0, 0}, profile, ROWS + 1, 64);
    }
}

static void write_scene(FILE *file) {
    scene_begin(file, "The white feather lamp, written by make_feather_lamp: metres, y up.",
                (struct point){0, -0.15, 1.4}, (struct point){0, -0.03, 0}, 35);
    scene_dielectric(file, "glass", 1.5, 1.0);
    scene_mesh(file, "shell", "shell.obj", false, "<ref id=\"glass\"/>");
    scene_mesh(file, "feathers", "feathers.ply", true,
               "<bsdf type=\"twosided\"><bsdf type=\"diffuse\"><rgb name=\"reflectance\" value=\"0.86, 0.85, "
               "0.82\"/></bsdf></bsdf>");
    for (int i = 0; i < 2; i++)
        scene_sphere(file, (struct point){i ? 0.05 : -0.05, 0.01, 0}, 0.016,
                     "<emitter type=\"area\"><rgb name=\"radiance\" value=\"9000, 7300, 5300\"/></emitter>");
    scene_end(file);
}

const struct model model = {"make_feather_lamp", (const struct model_file[]){{"feather_lamp.xml", .text = write_scene},
                                                                             {"shell.obj", .mesh = write_shell},
                                                                             {"feathers.ply", .mesh = write_feathers},
                                                                             {0}}};
