// Lines against meshes: what the tree finds is what a plain loop over all triangles in double precision finds, as far
// as rounding leaves a choice, and lines through the edges and vertices of a closed mesh do not slip through it.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>
#include <stdlib.h>
#include <string.h>

#include "luminaire/mesh_tree.h"
#include "math/sampler.h"
#include "math/warp.h"

enum { MOST_TRIANGLES = 7000, LINES = 1500 };
static const double hair = 4e-6; // [length] what rounding may do, meshes being about as large as the unit sphere

struct mesh {
    float vertices[3 * MOST_TRIANGLES][3];
    uint32_t triangles[MOST_TRIANGLES][3];
    size_t count;
};
static struct mesh mesh;
static struct mesh_tree *tree;

static void add_vertex(size_t vertex, vec3 p) { memcpy(mesh.vertices[vertex], (float[3]){p.x, p.y, p.z}, 12); }

static vec3 corner_at(size_t triangle, int corner) {
    const float *p = mesh.vertices[mesh.triangles[triangle][corner]];
    return (vec3){p[0], p[1], p[2]};
}

static void make_tree(void) {
    struct error error;
    assert_int_equal(mesh_tree_create(&tree, (const float(*)[3])mesh.vertices, (const uint32_t(*)[3])mesh.triangles,
                                      mesh.count, &error),
                     STATUS_OK);
}

// Loose triangles of all sizes; every tenth is degenerate: a point or a segment.
static void make_soup(size_t count) {
    mesh.count = count;
    for (size_t i = 0; i < count; i++) {
        struct sampler s = sampler_make(1, 0, i);
        const float size = powf(10, -2.5f * sampler_1d(&s));
        const vec3 middle = vec3_scale(warp_uniform_sphere(sampler_2d(&s)), 0.7f * sampler_1d(&s));
        for (size_t c = 0; c < 3; c++) {
            add_vertex(3 * i + c, vec3_mad(warp_uniform_sphere(sampler_2d(&s)), 0.3f * size, middle));
            mesh.triangles[i][c] = (uint32_t)(3 * i + c);
        }
        if (i % 10 == 9) mesh.triangles[i][2] = mesh.triangles[i][1];
        if (i % 20 == 19) mesh.triangles[i][1] = mesh.triangles[i][0];
    }
}

// A closed ball with `rings` of twice as many quads, its radius waved by `wave`; 1: a cube of flat sides instead.
static void make_ball(int rings, float wave) {
    mesh.count = 0;
    for (int i = 0; i <= rings; i++)
        for (int k = 0; k < 2 * rings; k++) {
            float theta = PI_F * (float)i / (float)rings, phi = PI_F * (float)k / (float)rings;
            vec3 d = {sinf(theta) * cosf(phi), sinf(theta) * sinf(phi), cosf(theta)};
            if (i == 0 || i == rings) d = (vec3){0, 0, i ? -1 : 1};
            float radius = 0.5f + wave * sinf(5 * theta) * sinf(6 * phi);
            if (wave == 1) radius = 0.5f / maxf(fabsf(d.x), maxf(fabsf(d.y), fabsf(d.z)));
            add_vertex((size_t)(i * 2 * rings + k), vec3_scale(d, radius));
        }
    for (int i = 0; i < rings; i++)
        for (int k = 0; k < 2 * rings; k++) {
            uint32_t a = (uint32_t)(2 * rings * i + k), b = (uint32_t)(2 * rings * i + (k + 1) % (2 * rings));
            uint32_t below = (uint32_t)(2 * rings);
            memcpy(mesh.triangles[mesh.count++], (uint32_t[3]){a, a + below, b + below}, 12);
            memcpy(mesh.triangles[mesh.count++], (uint32_t[3]){a, b + below, b}, 12);
        }
}

struct meeting { // of a line and a triangle, in double precision
    bool certain, possible;
    double from, to; // of t
};

static double segment_distance(const double *a, const double *b) { // of the origin, in the plane
    double dx = b[0] - a[0], dy = b[1] - a[1], length2 = dx * dx + dy * dy;
    double at = length2 > 0 ? -(a[0] * dx + a[1] * dy) / length2 : 0;
    at = at < 0 ? 0 : at > 1 ? 1 : at;
    return hypot(a[0] + at * dx, a[1] + at * dy);
}

static struct meeting meet(size_t triangle, vec3 origin, vec3 direction) {
    const double o[3] = {(double)origin.x, (double)origin.y, (double)origin.z};
    const double d[3] = {(double)direction.x, (double)direction.y, (double)direction.z};
    const double most = fmax(fabs(d[0]), fmax(fabs(d[1]), fabs(d[2])));
    const int z = fabs(d[0]) == most ? 0 : fabs(d[1]) == most ? 1 : 2, x = (z + 1) % 3, y = (z + 2) % 3;
    double p[3][3], sides[3], edge = INFINITY;
    struct meeting meeting = {.from = INFINITY, .to = -INFINITY};
    for (int c = 0; c < 3; c++) {
        const float *v = mesh.vertices[mesh.triangles[triangle][c]];
        p[c][2] = ((double)v[z] - o[z]) / d[z];
        p[c][0] = (double)v[x] - o[x] - d[x] * p[c][2];
        p[c][1] = (double)v[y] - o[y] - d[y] * p[c][2];
        meeting.from = fmin(meeting.from, p[c][2] - hair);
        meeting.to = fmax(meeting.to, p[c][2] + hair);
    }
    for (int c = 0; c < 3; c++) {
        const double *a = p[(c + 1) % 3], *b = p[(c + 2) % 3];
        sides[c] = a[0] * b[1] - a[1] * b[0];
        edge = fmin(edge, segment_distance(a, b));
    }
    const double area = sides[0] + sides[1] + sides[2];
    const bool inside = fabs(area) > 1e-12 && sides[0] / area >= 0 && sides[1] / area >= 0 && sides[2] / area >= 0;
    meeting.certain = inside && edge > hair;
    meeting.possible = inside || edge <= hair;
    if (fabs(area) > 1e-12) {
        double depth = (sides[0] * p[0][2] + sides[1] * p[1][2] + sides[2] * p[2][2]) / area, spread = hair;
        for (int c = 0; c < 3; c++) // how fast depth changes across the line
            spread += 2 * hair * hypot(p[(c + 1) % 3][0] - p[(c + 2) % 3][0], p[(c + 1) % 3][1] - p[(c + 2) % 3][1]) *
                      fabs(p[c][2] - depth) / fabs(area);
        meeting.from = fmax(meeting.from, depth - spread);
        meeting.to = fmin(meeting.to, depth + spread);
    }
    return meeting;
}

// Random ones; along an axis; through a vertex; through an edge; in the plane of a triangle.
static void make_line(uint64_t i, vec3 *origin, vec3 *direction) {
    struct sampler s = sampler_make(2, 0, i);
    const size_t triangle = (size_t)(sampler_1d(&s) * (float)mesh.count);
    const vec3 a = corner_at(triangle, 0), b = corner_at(triangle, 1), c = corner_at(triangle, 2);
    vec3 away = vec3_scale(warp_uniform_sphere(sampler_2d(&s)), 0.6f + 2 * sampler_1d(&s));
    vec3 target = vec3_scale(warp_uniform_sphere(sampler_2d(&s)), sampler_1d(&s));
    const float share = sampler_1d(&s);
    if (i % 5 == 1) {
        const int axis = (int)(3 * share);
        target = vec3_mad((vec3){axis == 0, axis == 1, axis == 2}, i % 2 ? 1 : -1, away);
        if (i % 3 == 0) away = vec3_sub(vec3_add(away, a), target), target = a; // and through a vertex
    }
    if (i % 5 == 2) target = a;
    if (i % 5 == 3) target = vec3_mad(vec3_sub(b, a), share, a);
    if (i % 5 == 4) {
        target = vec3_mad(vec3_sub(b, a), share, a);
        away = vec3_mad(vec3_sub(c, target), -3, target);
    }
    vec3 along = vec3_sub(target, away);
    *origin = away;
    *direction = vec3_length(along) > 1e-3f ? vec3_normalize(along) : (vec3){0, 0, 1};
}

static void mark(void *user, uint32_t triangle) { ((bool *)user)[triangle] = true; }

static void compare_line(vec3 origin, vec3 direction, int *met) {
    static bool visited[MOST_TRIANGLES];
    memset(visited, 0, sizeof visited);
    mesh_tree_visit(tree, origin, direction, -INFINITY, mark, visited);
    float t = 0, first = 0, last = 0;
    const uint32_t nearest = mesh_tree_nearest(tree, origin, direction, 0, &t);
    const bool hit = mesh_tree_span(tree, origin, direction, 3, &first, &last);
    double ahead = INFINITY, least = INFINITY, most = -INFINITY; // beyond which nothing can begin or end
    bool ahead_fits = nearest == MESH_MISSED, first_fits = !hit, last_fits = !hit;
    for (size_t i = 0; i < mesh.count; i++) {
        const struct meeting m = meet(i, origin, direction);
        assert_true(visited[i] ? m.possible : !m.certain);
        if (m.certain) {
            least = fmin(least, m.to);
            most = fmax(most, m.from);
            if (m.from > 0) ahead = fmin(ahead, m.to);
        }
        ahead_fits |= i == nearest && m.possible && (double)t >= m.from && (double)t <= m.to;
        first_fits |= m.possible && (double)first >= m.from && (double)first <= m.to;
        last_fits |= m.possible && (double)last >= m.from && (double)last <= m.to;
    }
    assert_true(ahead_fits && first_fits && last_fits);
    assert_true(nearest == MESH_MISSED ? ahead == INFINITY : t > 0 && (double)t <= ahead);
    assert_true(hit ? (double)first <= least && (double)last >= most && first <= last : least == INFINITY);
    *met += hit;
}

static void compare(void) {
    int met = 0;
    make_tree();
    for (uint64_t i = 0; i < LINES; i++) {
        vec3 origin, direction;
        make_line(i, &origin, &direction);
        compare_line(origin, direction, &met);
    }
    assert_true(met > LINES / 5);
    mesh_tree_destroy(tree);
}

static void soups_agree(void **state) {
    (void)state;
    static const size_t counts[] = {1, 5, 9, 40, 1000};
    for (size_t k = 0; k < sizeof counts / sizeof *counts; k++) {
        make_soup(counts[k]);
        compare();
    }
}

static void closed_meshes_agree(void **state) {
    (void)state;
    static const struct {
        int rings;
        float wave;
    } balls[] = {{4, 0}, {4, 1}, {12, 0.2f}, {30, 0.3f}, {32, 1}};
    for (size_t k = 0; k < sizeof balls / sizeof *balls; k++) {
        make_ball(balls[k].rings, balls[k].wave);
        compare();
    }
}

// From within, every line leaves: through vertices and along edges too.
static void closed_meshes_have_no_gaps(void **state) {
    (void)state;
    for (int k = 0; k < 2; k++) {
        make_ball(41, k ? 1 : 0);
        make_tree();
        for (size_t i = 0; i < mesh.count; i++)
            for (int c = 0; c < 3; c++) {
                struct sampler s = sampler_make(3, 0, 3 * i + (size_t)c);
                const vec3 a = corner_at(i, c), b = corner_at(i, (c + 1) % 3);
                const vec3 from = vec3_scale(warp_uniform_sphere(sampler_2d(&s)), 0.3f);
                const vec3 at = vec3_mad(vec3_sub(b, a), i % 2 ? 0 : sampler_1d(&s), a);
                float t = 0;
                assert_true(mesh_tree_nearest(tree, from, vec3_normalize(vec3_sub(at, from)), 0, &t) != MESH_MISSED);
                assert_true(t <= vec3_length(vec3_sub(at, from)) + 1e-5f);
            }
        mesh_tree_destroy(tree);
    }
}

static void an_empty_mesh_is_missed(void **state) {
    (void)state;
    float t, first, last;
    mesh.count = 0;
    make_tree();
    assert_true(mesh_tree_nearest(tree, (vec3){0, 0, 0}, (vec3){-1, 0, 0}, 0, &t) == MESH_MISSED);
    assert_false(mesh_tree_span(tree, (vec3){0, 0, 0}, (vec3){0, -1, 0}, 1, &first, &last));
    mesh_tree_destroy(tree);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(soups_agree), cmocka_unit_test(closed_meshes_agree),
                                       cmocka_unit_test(closed_meshes_have_no_gaps),
                                       cmocka_unit_test(an_empty_mesh_is_missed)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
