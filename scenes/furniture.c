// The rooms' soft and turned furniture, in metres on the floor (y = 0) unless said otherwise. What is made of boxes,
// balls and cylinders stands in the rooms' XML.
#include <math.h>

#include "writer/model.h"
#include "writer/solids.h"

static double wave(double x, int seed) {
    return sin(x + 1.7 * seed) + 0.5 * sin(2.3 * x + seed) + 0.3 * sin(4.1 * x + 2.9 * seed);
}

// --- sheets: a surface over (s, t) in [0, 1]^2, its normal by differences, its texture in metres ---

static void add_sheet(struct mesh_writer *mesh, const void *form,
                      struct point (*at)(const void *form, double s, double t), int rows, int columns, double u_size,
                      double v_size) {
    const double d = 1e-4;
    int first = mesh->vertices;
    for (int i = 0; i <= rows; i++)
        for (int j = 0; j <= columns; j++) {
            double s = j / (double)columns, t = i / (double)rows;
            struct point ds = point_sub(at(form, s + d, t), at(form, s - d, t));
            struct point dt = point_sub(at(form, s, t + d), at(form, s, t - d));
            mesh_vertex_normal_uv(mesh, at(form, s, t), point_normalize(point_cross(ds, dt)), s * u_size, t * v_size);
        }
    for (int i = 0; i < rows; i++)
        for (int j = 0; j < columns; j++) {
            int a = first + i * (columns + 1) + j, b = a + columns + 1;
            mesh_triangle(mesh, a, a + 1, b + 1);
            mesh_triangle(mesh, a, b + 1, b);
        }
}

// 1 wide and 1 high, facing +z, its folds deeper towards the hem.
static struct point curtain_at(const void *form, double s, double t) {
    (void)form;
    double fold = 0.020 + 0.016 * (1 - t);
    return (struct point){s - 0.5 + 0.006 * wave(26 * s, 3), t,
                          fold * sin(2 * pi * 9 * s + 0.5 * wave(5 * s, 1) + 0.25 * sin(3 * t))};
}

static void write_curtain(struct mesh_writer *mesh) { add_sheet(mesh, NULL, curtain_at, 24, 180, 1, 1); }

// A duvet on a bed of 1.7 x 1.9: over the top at 0.55, down both sides and the foot (+z).
static struct point duvet_at(const void *form, double s, double t) {
    (void)form;
    const double half = 0.87, end = 1.62, side = s < 0.5 ? -1 : 1; // where it turns down
    double x = 2.35 * (s - 0.5), z = 2.05 * t, drop = 0, over_x = fabs(x) - half, over_z = z - end;
    double hang = fmin(6 * fmax(fmax(over_x, over_z), 0), 1);
    double crease = 0.012 * wave(6 * s + 2 * t, 2) + 0.010 * wave(9 * t - 3 * s, 5);
    if (over_x > 0) {
        drop = over_x;
        x = side * (half + 0.05 * (1 - exp(-over_x / 0.05)) + hang * 0.012 * wave(22 * t, 4));
    }
    if (over_z > 0) {
        drop = fmax(drop, over_z);
        z = end + 0.05 * (1 - exp(-over_z / 0.05)) + hang * 0.012 * wave(22 * s, 6);
    }
    double y = 0.55 + crease * (1 - hang) + 0.03 * sin(pi * s) * sin(pi * fmin(1, t)) - drop;
    return (struct point){x, y, z};
}

static void write_duvet(struct mesh_writer *mesh) { add_sheet(mesh, NULL, duvet_at, 96, 112, 4, 4); }

// --- soft boxes: a box whose edges are rounded, closed but for the seams of its texture ---

static void add_soft_box(struct mesh_writer *mesh, struct point center, struct point half, double round, double puff) {
    enum { N = 14 };
    for (int face = 0; face < 6; face++) {
        int first = mesh->vertices, axis = face / 2, sign = face % 2 ? 1 : -1;
        const double size[3] = {half.x, half.y, half.z};
        for (int i = 0; i <= N; i++)
            for (int j = 0; j <= N; j++) {
                double q[3], inner[3], a = sin(0.5 * pi * (2.0 * j / N - 1)), b = sin(0.5 * pi * (2.0 * i / N - 1));
                q[axis] = sign;
                q[(axis + 1) % 3] = a * sign;
                q[(axis + 2) % 3] = b;
                for (int k = 0; k < 3; k++) {
                    q[k] *= size[k];
                    inner[k] = fmin(fmax(q[k], round - size[k]), size[k] - round);
                }
                struct point in = {inner[0], inner[1], inner[2]};
                struct point normal = point_normalize(point_sub((struct point){q[0], q[1], q[2]}, in));
                struct point p = point_add(point_add(center, in), point_scale(normal, round));
                double bulge = puff * (1 - a * a) * (1 - b * b);
                p = point_add(p, point_scale(normal, bulge));
                mesh_vertex_normal_uv(mesh, p, normal, q[(axis + 1) % 3] * 2, q[(axis + 2) % 3] * 2);
            }
        for (int i = 0; i < N; i++)
            for (int j = 0; j < N; j++) {
                int a = first + i * (N + 1) + j, b = a + N + 1;
                mesh_triangle(mesh, a, a + 1, b + 1);
                mesh_triangle(mesh, a, b + 1, b);
            }
    }
}

// A seat of `places` cushions, 0.7 wide each, facing +z, its middle at the origin.
static void add_seats(struct mesh_writer *mesh, int places) {
    double half = 0.35 * places;
    add_soft_box(mesh, (struct point){0, 0.23, 0}, (struct point){half + 0.18, 0.13, 0.44}, 0.03, 0);
    add_soft_box(mesh, (struct point){0, 0.52, -0.40}, (struct point){half + 0.18, 0.32, 0.09}, 0.07, 0);
    for (int side = -1; side <= 1; side += 2)
        add_soft_box(mesh, (struct point){side * (half + 0.09), 0.38, 0.0}, (struct point){0.09, 0.24, 0.45}, 0.06,
                     0.005);
    for (int i = 0; i < places; i++) {
        double x = 0.70 * (i + 0.5) - half;
        add_soft_box(mesh, (struct point){x, 0.43, 0.08}, (struct point){0.345, 0.085, 0.38}, 0.055, 0.02);
        add_soft_box(mesh, (struct point){x, 0.67, -0.25}, (struct point){0.335, 0.20, 0.085}, 0.07, 0.03);
    }
}

static void write_sofa(struct mesh_writer *mesh) { add_seats(mesh, 3); }
static void write_armchair(struct mesh_writer *mesh) { add_seats(mesh, 1); }

// 0.5 x 0.5, its middle at the origin, facing +z, with pinched corners.
static struct point cushion_at(const void *side, double s, double t) {
    double x = 2 * s - 1, y = 2 * t - 1, thick = (1 - x * x) * (1 - y * y);
    double pinch = 1 - 0.10 * (1 - x * x) * y * y - 0.10 * (1 - y * y) * x * x;
    double z = 0.085 * pow(fmax(thick, 0), 0.42) * *(const double *)side;
    return (struct point){0.25 * x * pinch * (*(const double *)side), 0.25 * y * pinch, z};
}

static void write_cushion(struct mesh_writer *mesh) {
    for (int side = -1; side <= 1; side += 2) add_sheet(mesh, &(double){side}, cushion_at, 28, 28, 1, 1);
}

// --- turned ---

static void write_vase(struct mesh_writer *mesh) {
    static const double vase[][2] = {{0.050, 0.330}, {0.056, 0.340}, {0.060, 0.330}, {0.044, 0.270},
                                     {0.050, 0.230}, {0.085, 0.170}, {0.105, 0.110}, {0.098, 0.060},
                                     {0.066, 0.015}, {0.055, 0.000}, {0, 0}};
    solid_turned(mesh, (struct point){0, 0, 0}, vase, COUNT(vase), 48);
}

static void write_pot(struct mesh_writer *mesh) {
    static const double pot[][2] = {{0, 0.33},    {0.165, 0.33}, {0.17, 0.36}, {0.19, 0.36},
                                    {0.19, 0.33}, {0.175, 0.30}, {0.13, 0},    {0, 0}};
    solid_turned(mesh, (struct point){0, 0, 0}, pot, COUNT(pot), 48);
}

static void write_bowl(struct mesh_writer *mesh) {
    static const double bowl[][2] = {{0, 0.020},     {0.060, 0.024}, {0.120, 0.050}, {0.160, 0.095}, {0.166, 0.100},
                                     {0.170, 0.095}, {0.130, 0.042}, {0.070, 0.012}, {0.060, 0.000}, {0, 0}};
    solid_turned(mesh, (struct point){0, 0, 0}, bowl, COUNT(bowl), 64);
}

// --- a plant's leaves, from 0.3 above the floor to 1.5 ---

struct leaf {
    double angle, length, lean, height, width;
};

static struct point leaf_at(const void *form, double s, double t) {
    const struct leaf *leaf = form;
    double bend = leaf->lean + 1.1 * t * t, across = (s - 0.5) * leaf->width * sin(pi * fmin(fmax(t, 0.02), 0.98));
    double out = 0.02 + leaf->length * t * sin(bend), up = leaf->height + leaf->length * t * cos(bend);
    struct point p = point_around(out, up + 1.5 * across * across / leaf->width, leaf->angle);
    return point_add(p, point_scale(point_around(1, 0, leaf->angle + pi / 2), across));
}

static void write_leaves(struct mesh_writer *mesh) {
    for (int i = 0; i < 44; i++) {
        double t = i / 43.0, chance = texture_hash(i, 17);
        struct leaf leaf = {.angle = 2.39996 * i,
                            .length = 0.75 - 0.25 * t + 0.25 * chance,
                            .lean = 0.9 - 0.75 * t,
                            .height = 0.32 + 0.40 * t,
                            .width = 0.10 + 0.05 * chance};
        add_sheet(mesh, &leaf, leaf_at, 14, 4, 1, 1);
    }
}

// --- a dining chair, facing +z, and a row of books, 0.8 long, from the left end at the origin ---

static void write_chair(struct mesh_writer *mesh) {
    for (int side = -1; side <= 1; side += 2) {
        add_soft_box(mesh, (struct point){side * 0.19, 0.22, 0.19}, (struct point){0.018, 0.22, 0.018}, 0.006, 0);
        add_soft_box(mesh, (struct point){side * 0.19, 0.45, -0.19}, (struct point){0.018, 0.45, 0.018}, 0.006, 0);
    }
    add_soft_box(mesh, (struct point){0, 0.44, 0}, (struct point){0.22, 0.022, 0.22}, 0.015, 0.004);
    for (int bar = 0; bar < 3; bar++)
        add_soft_box(mesh, (struct point){0, 0.60 + 0.12 * bar, -0.19}, (struct point){0.175, 0.03, 0.010}, 0.006, 0);
}

static void write_books(struct mesh_writer *mesh) {
    double x = 0;
    for (int i = 0; i < 18 && x < 0.78; i++) {
        double thick = 0.022 + 0.026 * texture_hash(i, 1), high = 0.19 + 0.08 * texture_hash(i, 2),
               deep = 0.13 + 0.04 * texture_hash(i, 3);
        double u = (floor(15.999 * texture_hash(i, 4)) + 0.5) / 16;
        const struct point corners[8] = {
            {x, 0, 0},     {x + thick, 0, 0},     {x + thick, high, 0},     {x, high, 0},
            {x, 0, -deep}, {x + thick, 0, -deep}, {x + thick, high, -deep}, {x, high, -deep}};
        static const int faces[5][4] = {{0, 1, 2, 3}, {1, 5, 6, 2}, {4, 0, 3, 7}, {3, 2, 6, 7}, {5, 4, 7, 6}};
        static const struct point normals[5] = {{0, 0, 1}, {1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, 0, -1}};
        for (int f = 0; f < 5; f++) {
            int first = mesh->vertices;
            for (int k = 0; k < 4; k++) {
                struct point p = corners[faces[f][k]];
                mesh_vertex_normal_uv(mesh, p, normals[f], u, f ? 0.5 : p.y / high);
            }
            mesh_triangle(mesh, first, first + 1, first + 2);
            mesh_triangle(mesh, first, first + 2, first + 3);
        }
        x += thick + 0.001;
    }
}

const struct model model = {"make_furniture", (const struct model_file[]){{"curtain.obj", .mesh = write_curtain},
                                                                          {"duvet.obj", .mesh = write_duvet},
                                                                          {"sofa.obj", .mesh = write_sofa},
                                                                          {"armchair.obj", .mesh = write_armchair},
                                                                          {"cushion.obj", .mesh = write_cushion},
                                                                          {"vase.obj", .mesh = write_vase},
                                                                          {"pot.obj", .mesh = write_pot},
                                                                          {"bowl.obj", .mesh = write_bowl},
                                                                          {"leaves.obj", .mesh = write_leaves},
                                                                          {"chair.obj", .mesh = write_chair},
                                                                          {"books.obj", .mesh = write_books},
                                                                          {0}}};
