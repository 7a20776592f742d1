// After the Cherry Blossom chandelier of Zhu et al. 2021: a rough-glass sphere shell round one small emitter, and round
// it 12 flowers of 5 tinted rough-glass petals with copper rims, which throw flower-shaped shadows. Metres, y up, about
// the origin.
#include "writer/model.h"
#include "writer/scene_writer.h"
#include "writer/solids.h"

enum { FLOWERS = 12, PETALS = 5, LENGTHS = 20, WIDTHS = 12 };

static const double emitter_radius = 0.02, shell_outer = 0.175, shell_inner = 0.163;
static const double flower_distance = 0.285, petal_length = 0.150, petal_thickness = 0.005, rim = 0.0022;

// The corners of an icosahedron, from the top.
static struct point flower_direction(int flower) {
    if (flower == 0) return (struct point){0, 1, 0};
    if (flower == FLOWERS - 1) return (struct point){0, -1, 0};
    bool upper = flower <= 5;
    return point_around(2 / sqrt(5), (upper ? 1 : -1) / sqrt(5), 2 * pi * (flower - (upper ? 0 : 0.5)) / 5);
}

struct petal {
    struct point out, right, up; // the flower's frame
    double angle;
};

static struct petal find_petal(int flower, int i) {
    struct point out = flower_direction(flower), helper = {0.23, 0.11, 0.97};
    struct point right = point_normalize(point_cross(helper, out));
    return (struct petal){out, right, point_cross(out, right), 2 * pi * (i + 0.13 * flower) / PETALS};
}

// The petal's middle surface, s in [0, 1] from the heart to the tip and t in [-1, 1] across: notched at the tip, hollow
// like a spoon and bent back over the sphere.
static struct point petal_point(const struct petal *petal, double s, double t) {
    double notch = 0.16 * pow(s, 6) * (1 - fabs(t)) * (1 - fabs(t));
    double along = petal_length * (0.16 + 0.84 * s * (1 - notch)),
           half = 0.400 * petal_length * sqrt(sin(pi * (0.06 + 0.90 * s)));
    half = fmin(half, along * tan(0.92 * pi / PETALS));
    double across = half * t, radius = hypot(along, across), angle = petal->angle + atan2(across, along);
    double lift = 0.10 * petal_length * (t * t * half / (0.4 * petal_length) - 0.3) + 0.02 * sin(pi * s);
    double bend = radius / flower_distance;
    struct point tangent = point_add(point_scale(petal->right, cos(angle)), point_scale(petal->up, sin(angle)));
    return point_scale(point_add(point_scale(petal->out, cos(bend)), point_scale(tangent, sin(bend))),
                       flower_distance + lift);
}

// Closed: the same grid on both sides, which meet all round because the thickness is none at the outline.
static void add_petal(struct mesh_writer *mesh, const struct petal *petal) {
    int first = mesh->vertices, side = (LENGTHS + 1) * (WIDTHS + 1);
    for (int k = 0; k < 2; k++)
        for (int i = 0; i <= LENGTHS; i++)
            for (int j = 0; j <= WIDTHS; j++) {
                double s = i / (double)LENGTHS, t = 2.0 * j / WIDTHS - 1;
                bool outline = i == 0 || i == LENGTHS || j == 0 || j == WIDTHS;
                struct point p = petal_point(petal, s, t);
                double offset = outline ? 0 : (k ? -0.5 : 0.5) * petal_thickness;
                mesh_vertex(mesh, point_add(p, point_scale(petal->out, offset)));
            }
    for (int k = 0; k < 2; k++)
        for (int i = 0; i < LENGTHS; i++)
            for (int j = 0; j < WIDTHS; j++) {
                int a = first + k * side + i * (WIDTHS + 1) + j, b = a + WIDTHS + 1;
                mesh_triangle(mesh, a, k ? a + 1 : b, k ? b : a + 1);
                mesh_triangle(mesh, b, k ? a + 1 : b + 1, k ? b + 1 : a + 1);
            }
}

static void add_rim(struct mesh_writer *mesh, const struct petal *petal) {
    struct point curve[2 * (LENGTHS + WIDTHS)];
    int n = 0;
    for (int i = 0; i < LENGTHS; i++) curve[n++] = petal_point(petal, i / (double)LENGTHS, -1);
    for (int j = 0; j < WIDTHS; j++) curve[n++] = petal_point(petal, 1, 2.0 * j / WIDTHS - 1);
    for (int i = LENGTHS; i > 0; i--) curve[n++] = petal_point(petal, i / (double)LENGTHS, 1);
    for (int j = WIDTHS; j > 0; j--) curve[n++] = petal_point(petal, 0, 2.0 * j / WIDTHS - 1);
    solid_tube(mesh, curve, n, rim, true);
}

static void write_petals(struct mesh_writer *mesh) {
    for (int i = 0; i < FLOWERS * PETALS; i++) {
        struct petal petal = find_petal(i / PETALS, i % PETALS);
        add_petal(mesh, &petal);
    }
}

static void write_rims(struct mesh_writer *mesh) {
    for (int i = 0; i < FLOWERS * PETALS; i++) {
        struct petal petal = find_petal(i / PETALS, i % PETALS);
        add_rim(mesh, &petal);
    }
    for (int i = 0; i < FLOWERS; i++) { // each flower's stalk
        struct point out = flower_direction(i);
        struct point stalk[2] = {point_scale(out, shell_outer + 0.001), point_scale(out, flower_distance + 0.004)};
        solid_tube(mesh, stalk, 2, 0.004, false);
    }
}

static void write_scene(FILE *file) {
    scene_begin(file, "The cherry blossom lamp, written by make_blossom_lamp: metres, y up.",
                (struct point){0, -0.2, 1.5}, (struct point){0, 0, 0}, 35);
    scene_rough_glass(file, "shell", 0.05, "1, 1, 1");
    scene_rough_glass(file, "petal", 0.4, "1, 0.80, 0.88");
    scene_metal(file, "copper", 0.1, "0.216, 0.869, 1.212", "3.673, 2.580, 2.432");
    scene_mesh(file, "petals", "petals.obj", false, "<ref id=\"petal\"/>");
    scene_mesh(file, "rims", "rims.ply", false, "<bsdf type=\"twosided\"><ref id=\"copper\"/></bsdf>");
    scene_sphere(file, (struct point){0, 0, 0}, shell_outer, "<ref id=\"shell\"/>");
    scene_sphere(file, (struct point){0, 0, 0}, shell_inner,
                 "<boolean name=\"flip_normals\" value=\"true\"/><ref id=\"shell\"/>");
    for (int i = 0; i < FLOWERS; i++)
        scene_sphere(file, point_scale(flower_direction(i), flower_distance + 0.004), 0.010,
                     "<bsdf type=\"twosided\"><ref id=\"copper\"/></bsdf>");
    scene_sphere(file, (struct point){0, 0, 0}, emitter_radius,
                 "<emitter type=\"area\"><rgb name=\"radiance\" value=\"9000, 7600, 6000\"/></emitter>");
    scene_end(file);
}

const struct model model = {"make_blossom_lamp", (const struct model_file[]){{"blossom_lamp.xml", .text = write_scene},
                                                                             {"petals.obj", .mesh = write_petals},
                                                                             {"rims.ply", .mesh = write_rims},
                                                                             {0}}};
