// Writes the project's own demonstration lamp: a chandelier of 8 bulbs (an emitting sphere of 8 mm in a clear glass
// shell), 153 faceted crystals and a brass frame, as Mitsuba 3 XML with two OBJ meshes. Units are metres, y is up, the
// centre of the lamp is the origin, everything lies within 0.5 m of it. The output is the same on every run.
//   make_demo_lamp FOLDER   ->   FOLDER/demo_lamp.xml, crystals.obj, brass.obj
#include <errno.h>
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

enum { BULBS = 8, TUBE_SIDES = 16, LATHE_SIDES = 32 };

static const double pi = 3.14159265358979323846;
static const double ring_radius = 0.36, bulb_height = 0.075;
static const double bulb_outer = 0.030, bulb_inner = 0.0285, emitter_radius = 0.008;

struct point {
    double x, y, z;
};

struct obj {
    FILE *file;
    int vertices; // written so far; OBJ counts from 1
};

static struct point add(struct point a, struct point b) { return (struct point){a.x + b.x, a.y + b.y, a.z + b.z}; }
static struct point scale(struct point a, double s) { return (struct point){a.x * s, a.y * s, a.z * s}; }
static struct point cross(struct point a, struct point b) {
    return (struct point){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
static struct point normalize(struct point a) { return scale(a, 1 / sqrt(a.x * a.x + a.y * a.y + a.z * a.z)); }
static struct point around(double radius, double y, double angle) {
    return (struct point){radius * cos(angle), y, radius * sin(angle)};
}

static void write_vertex(struct obj *obj, struct point p, struct point n) {
    fprintf(obj->file, "v %.6f %.6f %.6f\nvn %.5f %.5f %.5f\n", p.x, p.y, p.z, n.x, n.y, n.z);
    obj->vertices++;
}

// A grid of rows x columns vertices, already written, the columns wrapping around; the rows do too where `closed`.
static void write_grid(struct obj *obj, int first, int rows, int columns, bool closed) {
    for (int i = 0; i < (closed ? rows : rows - 1); i++)
        for (int j = 0; j < columns; j++) {
            int below = (i + 1) % rows, next = (j + 1) % columns;
            int a = first + i * columns + j, b = first + i * columns + next;
            int c = first + below * columns + next, d = first + below * columns + j;
            fprintf(obj->file, "f %d//%d %d//%d %d//%d\nf %d//%d %d//%d %d//%d\n", a, a, b, b, c, c, a, a, c, c, d, d);
        }
}

// A tube round a curve of n points.
static void write_tube(struct obj *obj, const struct point *curve, int n, double radius, bool closed) {
    int first = obj->vertices + 1;
    for (int i = 0; i < n; i++) {
        int before = closed ? (i + n - 1) % n : i > 0 ? i - 1 : 0, after = closed ? (i + 1) % n : i + 1 < n ? i + 1 : i;
        struct point along = normalize(add(curve[after], scale(curve[before], -1)));
        struct point side = fabs(along.y) < 0.9 ? (struct point){0, 1, 0} : (struct point){1, 0, 0};
        struct point s = normalize(cross(along, side)), t = cross(s, along);
        for (int j = 0; j < TUBE_SIDES; j++) {
            double angle = 2 * pi * j / TUBE_SIDES;
            struct point normal = add(scale(s, cos(angle)), scale(t, sin(angle)));
            write_vertex(obj, add(curve[i], scale(normal, radius)), normal);
        }
    }
    write_grid(obj, first, n, TUBE_SIDES, closed);
}

// A profile of n pairs (radius, y), from the top down, turned about the vertical axis through `base`.
static void write_lathe(struct obj *obj, struct point base, const double (*profile)[2], int n) {
    int first = obj->vertices + 1;
    for (int i = 0; i < n; i++) {
        int before = i > 0 ? i - 1 : 0, after = i + 1 < n ? i + 1 : i;
        double dr = profile[after][0] - profile[before][0], dy = profile[after][1] - profile[before][1];
        for (int j = 0; j < LATHE_SIDES; j++) {
            double angle = 2 * pi * j / LATHE_SIDES;
            struct point normal = normalize((struct point){-dy * cos(angle), dr, -dy * sin(angle)});
            write_vertex(obj, add(base, around(profile[i][0], profile[i][1], angle)), normal);
        }
    }
    write_grid(obj, first, n, LATHE_SIDES, false);
}

static void write_ring(struct obj *obj, double radius, double y, double thickness) {
    enum { N = 128 };
    struct point curve[N];
    for (int i = 0; i < N; i++) curve[i] = around(radius, y, 2 * pi * i / N);
    write_tube(obj, curve, N, thickness, true);
}

// An S-shaped arm from the column to the bulb's cup.
static void write_arm(struct obj *obj, double angle) {
    enum { N = 33 };
    struct point curve[N];
    for (int i = 0; i < N; i++) {
        double t = i / (double)(N - 1), radius = 0.02 + (ring_radius - 0.02) * t;
        curve[i] = around(radius, 0.10 - 0.10 * sin(1.5 * pi * t) * (1 - t) - 0.095 * t * t, angle);
    }
    write_tube(obj, curve, N, 0.005, false);
}

static void write_brass(struct obj *obj) {
    static const double column[][2] = {{0.0001, 0.46},  {0.012, 0.455}, {0.012, 0.36},  {0.030, 0.345}, {0.038, 0.32},
                                       {0.030, 0.295},  {0.012, 0.28},  {0.012, 0.22},  {0.022, 0.19},  {0.045, 0.15},
                                       {0.052, 0.12},   {0.045, 0.09},  {0.020, 0.05},  {0.014, 0.02},  {0.014, -0.05},
                                       {0.030, -0.08},  {0.038, -0.1},  {0.030, -0.12}, {0.012, -0.14}, {0.006, -0.19},
                                       {0.0001, -0.195}};
    static const double cup[][2] = {{0.0145, 0.026}, {0.0165, 0.027}, {0.0175, 0.020}, {0.014, 0.010},
                                    {0.008, 0.004},  {0.008, -0.012}, {0.0001, -0.016}};
    write_lathe(obj, (struct point){0, 0, 0}, column, (int)(sizeof column / sizeof *column));
    write_ring(obj, ring_radius, -0.002, 0.006);
    write_ring(obj, 0.20, 0.245, 0.004);
    for (int i = 0; i < BULBS; i++) {
        double angle = 2 * pi * i / BULBS;
        write_arm(obj, angle);
        write_lathe(obj, around(ring_radius, 0.018, angle), cup, (int)(sizeof cup / sizeof *cup));
        struct point strut[2] = {around(0.030, 0.32, angle), around(0.20, 0.245, angle)};
        write_tube(obj, strut, 2, 0.003, false);
    }
}

// A convex closed drop: a small table on top, a crown, a girdle of `sides` corners and a pavilion that ends in a point.
static void write_crystal(struct obj *obj, struct point hook, int sides, double radius, double height, double turn) {
    int first = obj->vertices + 1;
    const double ring[3][2] = {{0.35 * radius, 0}, {0.85 * radius, -0.16 * height}, {radius, -0.36 * height}};
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < sides; j++) {
            struct point p = add(hook, around(ring[i][0], ring[i][1], turn + 2 * pi * j / sides));
            fprintf(obj->file, "v %.6f %.6f %.6f\n", p.x, p.y, p.z);
        }
    fprintf(obj->file, "v %.6f %.6f %.6f\n", hook.x, hook.y - height, hook.z);
    int apex = first + 3 * sides;
    obj->vertices = apex;
    for (int j = 1; j + 1 < sides; j++) fprintf(obj->file, "f %d %d %d\n", first, first + j + 1, first + j);
    for (int i = 0; i < 2; i++)
        for (int j = 0; j < sides; j++) {
            int a = first + i * sides + j, b = first + i * sides + (j + 1) % sides;
            fprintf(obj->file, "f %d %d %d\nf %d %d %d\n", a, b, b + sides, a, b + sides, a + sides);
        }
    for (int j = 0; j < sides; j++)
        fprintf(obj->file, "f %d %d %d\n", first + 2 * sides + j, first + 2 * sides + (j + 1) % sides, apex);
}

static void write_crystals(struct obj *obj) {
    static const struct {
        int count, sides;
        double ring, y, radius, height;
    } rows[] = {
        {48, 8, 0.360, -0.020, 0.0125, 0.050}, {36, 8, 0.285, -0.050, 0.0140, 0.058},
        {28, 6, 0.205, -0.090, 0.0150, 0.066}, {16, 6, 0.120, -0.130, 0.0165, 0.078},
        {1, 12, 0.000, -0.210, 0.0400, 0.110}, {24, 8, 0.200, 0.230, 0.0120, 0.060},
    };
    for (size_t r = 0; r < sizeof rows / sizeof *rows; r++)
        for (int i = 0; i < rows[r].count; i++) {
            double angle = 2 * pi * (i + 0.5) / rows[r].count;
            write_crystal(obj, around(rows[r].ring, rows[r].y, angle), rows[r].sides, rows[r].radius, rows[r].height,
                          angle * 3.7 + (double)r);
        }
}

static void write_sphere(FILE *file, struct point center, double radius, const char *inside) {
    fprintf(file,
            "    <shape type=\"sphere\">\n"
            "        <point name=\"center\" x=\"%.6f\" y=\"%.6f\" z=\"%.6f\"/>\n"
            "        <float name=\"radius\" value=\"%g\"/>\n"
            "        %s\n"
            "    </shape>\n",
            center.x, center.y, center.z, radius, inside);
}

static void write_scene(FILE *file) {
    fputs("<?xml version=\"1.0\" encoding=\"utf-8\"?>\n"
          "<!-- The demonstration lamp, written by make_demo_lamp: metres, y up. -->\n"
          "<scene version=\"3.0.0\">\n"
          "    <integrator type=\"path\">\n"
          "        <integer name=\"max_depth\" value=\"32\"/>\n"
          "    </integrator>\n"
          "    <sensor type=\"perspective\">\n"
          "        <float name=\"fov\" value=\"35\"/>\n"
          "        <transform name=\"to_world\">\n"
          "            <lookat origin=\"0, -0.35, 1.7\" target=\"0, 0.06, 0\" up=\"0, 1, 0\"/>\n"
          "        </transform>\n"
          "        <sampler type=\"independent\"><integer name=\"sample_count\" value=\"64\"/></sampler>\n"
          "        <film type=\"hdrfilm\">\n"
          "            <integer name=\"width\" value=\"480\"/>\n"
          "            <integer name=\"height\" value=\"480\"/>\n"
          "        </film>\n"
          "    </sensor>\n"
          "    <bsdf type=\"dielectric\" id=\"shell_outside\">\n"
          "        <float name=\"int_ior\" value=\"1.5\"/>\n"
          "        <float name=\"ext_ior\" value=\"1.0\"/>\n"
          "    </bsdf>\n"
          "    <bsdf type=\"dielectric\" id=\"shell_inside\">\n"
          "        <float name=\"int_ior\" value=\"1.0\"/>\n"
          "        <float name=\"ext_ior\" value=\"1.5\"/>\n"
          "    </bsdf>\n"
          "    <bsdf type=\"dielectric\" id=\"crystal\">\n"
          "        <float name=\"int_ior\" value=\"1.6\"/>\n"
          "        <float name=\"ext_ior\" value=\"1.0\"/>\n"
          "    </bsdf>\n"
          "    <bsdf type=\"roughconductor\" id=\"brass\">\n"
          "        <float name=\"alpha\" value=\"0.12\"/>\n"
          "        <rgb name=\"eta\" value=\"0.444, 0.527, 1.094\"/>\n"
          "        <rgb name=\"k\" value=\"3.695, 2.765, 1.829\"/>\n"
          "    </bsdf>\n"
          "    <shape type=\"obj\" id=\"crystals\">\n"
          "        <string name=\"filename\" value=\"crystals.obj\"/>\n"
          "        <boolean name=\"face_normals\" value=\"true\"/>\n"
          "        <ref id=\"crystal\"/>\n"
          "    </shape>\n"
          "    <shape type=\"obj\" id=\"frame\">\n"
          "        <string name=\"filename\" value=\"brass.obj\"/>\n"
          "        <bsdf type=\"twosided\"><ref id=\"brass\"/></bsdf>\n"
          "    </shape>\n",
          file);
    for (int i = 0; i < BULBS; i++) {
        struct point center = around(ring_radius, bulb_height, 2 * pi * i / BULBS);
        write_sphere(file, center, emitter_radius,
                     "<emitter type=\"area\"><rgb name=\"radiance\" value=\"7000, 5600, 4100\"/></emitter>");
        write_sphere(file, center, bulb_inner, "<ref id=\"shell_inside\"/>");
        write_sphere(file, center, bulb_outer, "<ref id=\"shell_outside\"/>");
    }
    fputs("</scene>\n", file);
}

static FILE *open_in(const char *folder, const char *name) {
    char path[4096];
    int length = snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *file = length > 0 && (size_t)length < sizeof path ? fopen(path, "w") : NULL;
    if (!file) fprintf(stderr, "make_demo_lamp: cannot write %s/%s: %s\n", folder, name, strerror(errno));
    return file;
}

int main(int argc, char **argv) {
    if (argc != 2) {
        fputs("usage: make_demo_lamp FOLDER\n", stderr);
        return 2;
    }
    if (mkdir(argv[1], 0777) != 0 && errno != EEXIST) {
        fprintf(stderr, "make_demo_lamp: cannot create the folder %s: %s\n", argv[1], strerror(errno));
        return 1;
    }
    static const char *const names[3] = {"crystals.obj", "brass.obj", "demo_lamp.xml"};
    for (int i = 0; i < 3; i++) {
        struct obj obj = {open_in(argv[1], names[i]), 0};
        if (!obj.file) return 1;
        if (i == 0) write_crystals(&obj);
        if (i == 1) write_brass(&obj);
        if (i == 2) write_scene(obj.file);
        bool failed = ferror(obj.file) != 0;
        if (fclose(obj.file) != 0 || failed) {
            fprintf(stderr, "make_demo_lamp: writing %s/%s failed; is the disk full?\n", argv[1], names[i]);
            return 1;
        }
    }
    return 0;
}
