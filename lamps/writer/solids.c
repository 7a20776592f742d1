#include "solids.h"

enum { TUBE_SIDES = 16, LATHE_SIDES = 32, RING_POINTS = 128 };

void solid_grid(struct mesh_writer *mesh, int first, int rows, int columns, bool closed) {
    for (int i = 0; i < (closed ? rows : rows - 1); i++)
        for (int j = 0; j < columns; j++) {
            int below = (i + 1) % rows, next = (j + 1) % columns;
            int a = first + i * columns + j, b = first + i * columns + next;
            int c = first + below * columns + next, d = first + below * columns + j;
            mesh_triangle(mesh, a, b, c);
            mesh_triangle(mesh, a, c, d);
        }
}

void solid_tube(struct mesh_writer *mesh, const struct point *curve, int n, double radius, bool closed) {
    int first = mesh->vertices;
    for (int i = 0; i < n; i++) {
        int before = closed ? (i + n - 1) % n : i > 0 ? i - 1 : 0, after = closed ? (i + 1) % n : i + 1 < n ? i + 1 : i;
        struct point along = point_normalize(point_sub(curve[after], curve[before]));
        struct point side = fabs(along.y) < 0.9 ? (struct point){0, 1, 0} : (struct point){1, 0, 0};
        struct point s = point_normalize(point_cross(along, side)), t = point_cross(s, along);
        for (int j = 0; j < TUBE_SIDES; j++) {
            double angle = 2 * pi * j / TUBE_SIDES;
            struct point normal = point_add(point_scale(s, cos(angle)), point_scale(t, sin(angle)));
            mesh_vertex_normal(mesh, point_add(curve[i], point_scale(normal, radius)), normal);
        }
    }
    solid_grid(mesh, first, n, TUBE_SIDES, closed);
}

void solid_ring(struct mesh_writer *mesh, double radius, double y, double thickness) {
    struct point curve[RING_POINTS];
    for (int i = 0; i < RING_POINTS; i++) curve[i] = point_around(radius, y, 2 * pi * i / RING_POINTS);
    solid_tube(mesh, curve, RING_POINTS, thickness, true);
}

void solid_lathe(struct mesh_writer *mesh, struct point base, const double (*profile)[2], int n) {
    int first = mesh->vertices;
    for (int i = 0; i < n; i++) {
        int before = i > 0 ? i - 1 : 0, after = i + 1 < n ? i + 1 : i;
        double dr = profile[after][0] - profile[before][0], dy = profile[after][1] - profile[before][1];
        for (int j = 0; j < LATHE_SIDES; j++) {
            double angle = 2 * pi * j / LATHE_SIDES;
            struct point normal = point_normalize((struct point){-dy * cos(angle), dr, -dy * sin(angle)});
            mesh_vertex_normal(mesh, point_add(base, point_around(profile[i][0], profile[i][1], angle)), normal);
        }
    }
    solid_grid(mesh, first, n, LATHE_SIDES, false);
}

// The normal (radius, y) of the profile's segment i, which an end of segment `other` shares unless there is an edge.
static void add_normal(const double (*profile)[2], int i, int other, int n, double normal[2]) {
    double sum[2] = {0, 0}, own[2] = {0, 0};
    for (int k = 0; k < 2; k++) {
        int segment = k ? other : i;
        if (segment < 0 || segment + 1 >= n) continue;
        double dr = profile[segment + 1][0] - profile[segment][0], dy = profile[segment + 1][1] - profile[segment][1];
        double length = hypot(dr, dy), at[2] = {-dy / length, dr / length};
        if (k == 0) own[0] = at[0], own[1] = at[1];
        if (at[0] * own[0] + at[1] * own[1] > cos(40 * pi / 180)) sum[0] += at[0], sum[1] += at[1];
    }
    normal[0] = sum[0] / hypot(sum[0], sum[1]);
    normal[1] = sum[1] / hypot(sum[0], sum[1]);
}

void solid_turned(struct mesh_writer *mesh, struct point base, const double (*profile)[2], int n, int sides) {
    for (int i = 0; i + 1 < n; i++) {
        int first = mesh->vertices;
        for (int end = 0; end < 2; end++) {
            double normal[2];
            add_normal(profile, i, end ? i + 1 : i - 1, n, normal);
            for (int j = 0; j < sides; j++) {
                double angle = 2 * pi * j / sides;
                mesh_vertex_normal(mesh, point_add(base, point_around(profile[i + end][0], profile[i + end][1], angle)),
                                   point_around(normal[0], normal[1], angle));
            }
        }
        for (int j = 0; j < sides; j++) {
            int a = first + j, b = first + (j + 1) % sides;
            if (profile[i][0] > 0) mesh_triangle(mesh, a, b, b + sides);
            if (profile[i + 1][0] > 0) mesh_triangle(mesh, a, b + sides, a + sides);
        }
    }
}

void solid_gem(struct mesh_writer *mesh, struct point origin, struct point axis, double turn, int sides,
               const double (*profile)[2], int n) {
    struct point helper = fabs(axis.z) < 0.9 ? (struct point){0, 0, 1} : (struct point){1, 0, 0};
    struct point s = point_normalize(point_cross(axis, helper)), t = point_cross(s, axis);
    int ring = mesh->vertices;
    for (int i = 0; i < n; i++) {
        double radius = profile[i][0];
        struct point center = point_add(origin, point_scale(axis, profile[i][1]));
        if (radius == 0) mesh_vertex(mesh, center);
        for (int j = 0; radius > 0 && j < sides; j++) {
            double angle = turn + 2 * pi * j / sides;
            struct point out = point_add(point_scale(s, radius * cos(angle)), point_scale(t, radius * sin(angle)));
            mesh_vertex(mesh, point_add(center, out));
        }
    }
    for (int j = 1; profile[0][0] > 0 && j + 1 < sides; j++) mesh_triangle(mesh, ring, ring + j + 1, ring + j);
    for (int i = 0; i + 1 < n; i++) {
        bool upper = profile[i][0] > 0, lower = profile[i + 1][0] > 0;
        int next = ring + (upper ? sides : 1);
        for (int j = 0; j < sides; j++) {
            int k = (j + 1) % sides;
            if (upper) mesh_triangle(mesh, ring + j, ring + k, lower ? next + k : next);
            if (lower) mesh_triangle(mesh, upper ? ring + j : ring, next + k, next + j);
        }
        ring = next;
    }
    for (int j = 1; profile[n - 1][0] > 0 && j + 1 < sides; j++) mesh_triangle(mesh, ring, ring + j, ring + j + 1);
}

void solid_drop(struct mesh_writer *mesh, struct point hook, int sides, double radius, double height, double turn) {
    const double profile[][2] = {
        {0.35 * radius, 0}, {0.85 * radius, -0.16 * height}, {radius, -0.36 * height}, {0, -height}};
    solid_gem(mesh, hook, (struct point){0, 1, 0}, turn, sides, profile, COUNT(profile));
}
