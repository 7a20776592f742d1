// Longest edges are halved, so that neighbours agree about the edge between them.
#include "bake/hull_cutout.h"

#include "math/sampler.h"
#include "math/warp.h"

enum { PROBES = 1024, MOST_DIVISIONS = 40 };
enum { ANALYTIC_SIDE = 8 }; // squares of an analytic shape's coordinates, to begin with
static const float whole = 0.02f, nearly_all = 0.9f;
static const float coarsest = 16; // [finest]: no hole between corners that large goes unseen

static float passing(const struct surface *surface) { return rgb_mean(surface_through(surface, surface->ng)); }

bool hull_shape_is_cutout(const struct shape *shape) {
    if (!(shape->bsdf->flags & BSDF_NULL) || shape->has_interior || shape->emitter) return false;
    struct sampler sampler = sampler_make(0, 0x637574, 0);
    int clear = 0;
    for (int i = 0; i < PROBES; i++) {
        struct surface surface = {.shape = shape};
        const vec2 at = sampler_2d(&sampler);
        const float triangle = sampler_1d(&sampler) * (float)shape->mesh.triangle_count;
        if (shape->mesh.triangle_count)
            shape_fill_triangle(shape, (uint32_t)triangle, warp_triangle(at), &surface);
        else
            shape_sample(shape, at, &surface);
        const float through = passing(&surface);
        clear += through < whole || through > 1 - whole;
    }
    return (float)clear >= nearly_all * PROBES;
}

struct cutout_corner {
    vec3 p;
    vec2 at; // barycentric in the triangle, as of shape_fill_triangle; of an analytic shape as of shape_sample
};

struct cut {
    const struct shape *shape;
    uint32_t primitive; // UINT32_MAX: of an analytic shape
    float finest2, coarsest2;
    cutout_add *add;
    void *user;
};

static struct surface surface_at(const struct cut *cut, vec2 at) {
    struct surface surface = {.shape = cut->shape};
    if (cut->primitive == UINT32_MAX)
        shape_sample(cut->shape, at, &surface);
    else
        shape_fill_triangle(cut->shape, cut->primitive, at, &surface);
    return surface;
}

static vec2 blend(const struct cutout_corner c[3], float a, float b) { // the rest of the third
    const float rest = 1 - a - b;
    return (vec2){a * c[0].at.x + b * c[1].at.x + rest * c[2].at.x, a * c[0].at.y + b * c[1].at.y + rest * c[2].at.y};
}

static bool is_there(const struct cut *cut, const struct cutout_corner c[3], float a, float b) {
    const struct surface surface = surface_at(cut, blend(c, a, b));
    return passing(&surface) < 0.5f;
}

// The same a little within the corners, at the middles of the edges and in the middle.
static bool is_uniform(const struct cut *cut, const struct cutout_corner c[3], bool there) {
    static const float places[][2] = {{0.94f, 0.03f}, {0.03f, 0.94f}, {0.03f, 0.03f}, {0.48f, 0.48f}, {0.48f, 0.04f},
                                      {0.04f, 0.48f}, {0.66f, 0.17f}, {0.17f, 0.66f}, {0.17f, 0.17f}};
    for (size_t i = 0; i < sizeof places / sizeof *places; i++)
        if (is_there(cut, c, places[i][0], places[i][1]) != there) return false;
    return true;
}

static float distance2(vec3 a, vec3 b) {
    const vec3 d = vec3_sub(a, b);
    return vec3_dot(d, d);
}

static void divide(const struct cut *cut, const struct cutout_corner c[3], int left) {
    int longest = 0; // the edge from this corner to the next
    float length2[3];
    for (int i = 0; i < 3; i++) {
        length2[i] = distance2(c[i].p, c[(i + 1) % 3].p);
        if (length2[i] > length2[longest]) longest = i;
    }
    const struct surface center = surface_at(cut, blend(c, 1.0f / 3, 1.0f / 3));
    const bool there = passing(&center) < 0.5f;
    const bool small = length2[longest] <= cut->finest2 || left == 0;
    if (small || (length2[longest] <= cut->coarsest2 && is_uniform(cut, c, there))) {
        if (there) cut->add(cut->user, &(struct cutout_piece){{c[0].p, c[1].p, c[2].p}, center.ng, cut->primitive});
        return;
    }
    const struct cutout_corner *from = &c[longest], *to = &c[(longest + 1) % 3], *other = &c[(longest + 2) % 3];
    struct cutout_corner middle = {vec3_scale(vec3_add(from->p, to->p), 0.5f),
                                   {0.5f * (from->at.x + to->at.x), 0.5f * (from->at.y + to->at.y)}};
    if (cut->primitive == UINT32_MAX) middle.p = surface_at(cut, middle.at).p;
    divide(cut, (struct cutout_corner[3]){*from, middle, *other}, left - 1);
    divide(cut, (struct cutout_corner[3]){middle, *to, *other}, left - 1);
}

void hull_cut(const struct shape *shape, float finest, cutout_add *add, void *user) {
    struct cut cut = {shape, UINT32_MAX, sqrf(finest), sqrf(coarsest * finest), add, user};
    for (uint32_t t = 0; t < shape->mesh.triangle_count; t++) {
        const uint32_t *v = shape->mesh.indices + 3 * (size_t)t;
        const vec3 *p = shape->mesh.positions;
        cut.primitive = t;
        divide(&cut, (struct cutout_corner[3]){{p[v[0]], {0, 0}}, {p[v[1]], {1, 0}}, {p[v[2]], {0, 1}}},
               MOST_DIVISIONS);
    }
    const int squares = shape->mesh.triangle_count ? 0 : ANALYTIC_SIDE * ANALYTIC_SIDE;
    for (int i = 0; i < squares; i++) {
        struct cutout_corner corner[4];
        for (int k = 0; k < 4; k++) {
            corner[k].at = (vec2){(float)(i % ANALYTIC_SIDE + k % 2) / ANALYTIC_SIDE,
                                  (float)(i / ANALYTIC_SIDE + k / 2) / ANALYTIC_SIDE};
            corner[k].p = surface_at(&cut, corner[k].at).p;
        }
        divide(&cut, (struct cutout_corner[3]){corner[0], corner[1], corner[3]}, MOST_DIVISIONS);
        divide(&cut, (struct cutout_corner[3]){corner[0], corner[3], corner[2]}, MOST_DIVISIONS);
    }
}
