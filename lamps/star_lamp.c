// After the Moravian star of Zhu et al. 2021: 26 hollow pyramids of rough glass, 18 square and 8 triangular, on the
// faces of a rhombicuboctahedron; one emitter in the middle, so that every path crosses rough glass. Leaded edges. The
// proxy is the star itself, a little larger: sconce bake star_lamp.xml --proxy star_proxy.obj. Metres, y up, about the
// origin.
#include <stdlib.h>
#include <string.h>

#include "writer/model.h"
#include "writer/scene_writer.h"
#include "writer/solids.h"

enum { CORNERS = 24, MOST_EDGES = 4 };

static const double core = 0.075; // half the width of the solid that the pyramids stand on
static const double square_tip = 0.40, triangle_tip = 0.34,
                    wall = 0.05; // the wall as a share of the distance to the middle
static const double emitter_radius = 0.02, lead = 0.0009;

// Corner (x, y, z) of the rhombicuboctahedron: one coordinate is 1 + sqrt 2 times the others'.
static struct point corner(int large, int signs) {
    double v[3];
    for (int i = 0; i < 3; i++) v[i] = core * (i == large ? 1 : sqrt(2) - 1) * (signs >> i & 1 ? -1 : 1);
    return (struct point){v[0], v[1], v[2]};
}

struct face {
    struct point corners[MOST_EDGES], tip;
    int edges;
};

// The corners farthest along the direction, in order round it.
static struct face find_face(struct point direction, int edges, double tip) {
    struct face face = {.edges = edges, .tip = point_scale(direction, tip)};
    struct point side = point_normalize(point_cross(direction, (struct point){0.31, 0.62, 0.72}));
    struct point up = point_cross(direction, side);
    double angles[MOST_EDGES], farthest = 0;
    for (int pass = 0, n = 0; pass < 2; pass++)
        for (int c = 0; c < CORNERS; c++) {
            struct point p = corner(c % 3, c / 3);
            double along = point_dot(p, direction), angle = atan2(point_dot(p, up), point_dot(p, side));
            if (pass == 0) farthest = fmax(farthest, along);
            if (pass == 0 || along < farthest - 1e-6) continue;
            int i = n++;
            for (; i > 0 && angles[i - 1] > angle; i--) {
                angles[i] = angles[i - 1];
                face.corners[i] = face.corners[i - 1];
            }
            angles[i] = angle;
            face.corners[i] = p;
        }
    return face;
}

static void for_faces(struct mesh_writer *mesh, void (*add)(struct mesh_writer *mesh, const struct face *face)) {
    for (int i = 0; i < 27; i++) {
        struct point d = {i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1};
        int axes = (d.x != 0) + (d.y != 0) + (d.z != 0);
        if (axes == 0) continue;
        struct face face = find_face(point_normalize(d), axes == 3 ? 3 : 4, axes == 3 ? triangle_tip : square_tip);
        add(mesh, &face);
    }
}

static void add_pyramid(struct mesh_writer *mesh, const struct face *face, double size, bool inwards) {
    for (int i = 0; i < face->edges; i++) {
        int first = mesh->vertices;
        mesh_vertex(mesh, point_scale(face->corners[i], size));
        mesh_vertex(mesh, point_scale(face->corners[(i + 1) % face->edges], size));
        mesh_vertex(mesh, point_scale(face->tip, size));
        mesh_triangle(mesh, first, first + (inwards ? 2 : 1), first + (inwards ? 1 : 2));
    }
}

static void add_glass(struct mesh_writer *mesh, const struct face *face) {
    add_pyramid(mesh, face, 1, false);
    add_pyramid(mesh, face, 1 - wall, true);
}

static void add_proxy(struct mesh_writer *mesh, const struct face *face) { add_pyramid(mesh, face, 1.06, false); }

static void add_lead(struct mesh_writer *mesh, const struct face *face) {
    for (int i = 0; i < face->edges; i++) {
        solid_tube(mesh, (struct point[]){face->corners[i], point_scale(face->tip, 0.995)}, 2, lead, false);
        solid_tube(mesh, (struct point[]){face->corners[i], face->corners[(i + 1) % face->edges]}, 2, lead, false);
    }
}

static void write_glass(struct mesh_writer *mesh) { for_faces(mesh, add_glass); }
static void write_proxy(struct mesh_writer *mesh) { for_faces(mesh, add_proxy); }
static void write_lead(struct mesh_writer *mesh) { for_faces(mesh, add_lead); }

static void write_scene(FILE *file) {
    scene_begin(file, "The Moravian star, written by make_star_lamp: metres, y up.", (struct point){0.3, 0.25, 1.5},
                (struct point){0, 0, 0}, 35);
    scene_rough_glass(file, "frosted", 0.25, "1, 0.97, 0.90");
    scene_metal(file, "lead", 0.2, "1.95, 1.95, 1.75", "3.5, 3.4, 3.2");
    scene_mesh(file, "glass", "glass.obj", true, "<ref id=\"frosted\"/>");
    scene_mesh(file, "edges", "edges.obj", false, "<bsdf type=\"twosided\"><ref id=\"lead\"/></bsdf>");
    scene_sphere(file, (struct point){0, 0, 0}, emitter_radius,
                 "<emitter type=\"area\"><rgb name=\"radiance\" value=\"27000, 23000, 17500\"/></emitter>");
    scene_end(file);
}

const struct model model = {"make_star_lamp", (const struct model_file[]){{"star_lamp.xml", .text = write_scene},
                                                                          {"glass.obj", .mesh = write_glass},
                                                                          {"edges.obj", .mesh = write_lead},
                                                                          {"star_proxy.obj", .mesh = write_proxy},
                                                                          {0}}};
