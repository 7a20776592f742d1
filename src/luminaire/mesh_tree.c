// Ray against triangle as Woop, Benthin and Wald 2013 ("Watertight Ray/Triangle Intersection"): corners are sheared so
// that the line becomes the z axis, and both triangles at an edge ask the same product on which side of it the line
// passes. Here an edge belongs to both by the rounding of that product.
#include "luminaire/mesh_tree_private.h"

enum { STACK = 320 }; // 7 children wait in each of the levels, of which mesh_tree_build.c makes 42 at most
#define EACH_LANE for (int l = 0; l < LANES; l++)

typedef float lane_floats[LANES] __attribute__((aligned(32)));

struct line {
    float origin[3], inverse[3];
    int x, y, z; // axes; the line runs mostly along z
    float shear_x, shear_y;
};

struct waiting {
    float near;
    uint32_t child;
};

static struct line line_make(vec3 origin, vec3 direction) {
    const float d[3] = {direction.x, direction.y, direction.z};
    struct line line = {.origin = {origin.x, origin.y, origin.z}};
    // Boxes are a little larger than what they hold, so no difference to a side is 0 and no product with a huge
    // inverse is undefined.
    for (int a = 0; a < 3; a++) line.inverse[a] = 1 / (fabsf(d[a]) > 1e-20f ? d[a] : copysignf(1e-20f, d[a]));
    line.z = fabsf(d[0]) > fabsf(d[1]) ? 0 : 1;
    line.z = fabsf(d[2]) > fabsf(d[line.z]) ? 2 : line.z;
    line.x = line.z < 2 ? line.z + 1 : 0;
    line.y = line.x < 2 ? line.x + 1 : 0;
    line.shear_x = d[line.x] * line.inverse[line.z];
    line.shear_y = d[line.y] * line.inverse[line.z];
    return line;
}

// Puts the children whose boxes the line meets between t_min and t_max on the stack, the nearest on top.
static inline int push_children(const struct mesh_node *node, const struct line *line, float t_min, float t_max,
                                struct waiting *stack, int depth) {
    lane_floats near, far;
    const float *nears[3], *fars[3];
    for (int a = 0; a < 3; a++) {
        int back = line->inverse[a] < 0;
        nears[a] = node->bounds[back][a];
        fars[a] = node->bounds[!back][a];
    }
    EACH_LANE {
        float x = (nears[0][l] - line->origin[0]) * line->inverse[0];
        float y = (nears[1][l] - line->origin[1]) * line->inverse[1];
        float z = (nears[2][l] - line->origin[2]) * line->inverse[2];
        near[l] = maxf(maxf(x, y), maxf(z, t_min));
        x = (fars[0][l] - line->origin[0]) * line->inverse[0];
        y = (fars[1][l] - line->origin[1]) * line->inverse[1];
        z = (fars[2][l] - line->origin[2]) * line->inverse[2];
        far[l] = minf(minf(x, y), minf(z, t_max));
    }
    const int first = depth;
    int met = 0;
    EACH_LANE met |= near[l] <= far[l] ? 1 << l : 0;
    for (; met; met &= met - 1) {
        const int l = __builtin_ctz((unsigned)met);
        stack[depth++] = (struct waiting){near[l], node->child[l]};
    }
    for (int i = first + 1; i < depth; i++) {
        const struct waiting moved = stack[i];
        int k = i;
        for (; k > first && stack[k - 1].near < moved.near; k--) stack[k] = stack[k - 1];
        stack[k] = moved;
    }
    return depth;
}

// Where the line meets each triangle of the block beyond t_min; infinity: nowhere.
static inline void meet(const struct mesh_block *block, const struct line *line, float t_min, float *restrict t) {
    const float *ax = block->corners[0][line->x], *ay = block->corners[0][line->y], *az = block->corners[0][line->z];
    const float *bx = block->corners[1][line->x], *by = block->corners[1][line->y], *bz = block->corners[1][line->z];
    const float *cx = block->corners[2][line->x], *cy = block->corners[2][line->y], *cz = block->corners[2][line->z];
    const float ox = line->origin[line->x], oy = line->origin[line->y], oz = line->origin[line->z];
    const float shear_x = line->shear_x, shear_y = line->shear_y, inverse = line->inverse[line->z];
    const float rounding = 0x1p-22f; // of a difference of two products, as a share of one of them where they are equal
    EACH_LANE {
        float a_z = az[l] - oz, b_z = bz[l] - oz, c_z = cz[l] - oz;
        float a_x = ax[l] - ox - shear_x * a_z, a_y = ay[l] - oy - shear_y * a_z;
        float b_x = bx[l] - ox - shear_x * b_z, b_y = by[l] - oy - shear_y * b_z;
        float c_x = cx[l] - ox - shear_x * c_z, c_y = cy[l] - oy - shear_y * c_z;
        float cb = c_y * b_x, ac = a_y * c_x, ba = b_y * a_x;
        float u = c_x * b_y - cb, v = a_x * c_y - ac, w = b_x * a_y - ba;
        float slack_u = rounding * fabsf(cb), slack_v = rounding * fabsf(ac), slack_w = rounding * fabsf(ba);
        float least = minf(minf(u + slack_u, v + slack_v), w + slack_w);
        float most = maxf(maxf(u - slack_u, v - slack_v), w - slack_w);
        float determinant = u + v + w, depth = (u * a_z + v * b_z + w * c_z) / determinant;
        // Seen from its edge a triangle has no depth and no sides but for noise: its box has.
        float low_x = minf(minf(a_x, b_x), c_x), high_x = maxf(maxf(a_x, b_x), c_x);
        float low_y = minf(minf(a_y, b_y), c_y), high_y = maxf(maxf(a_y, b_y), c_y);
        float low_z = minf(minf(a_z, b_z), c_z), high_z = maxf(maxf(a_z, b_z), c_z);
        float outside = maxf(maxf(low_x, -high_x), maxf(low_y, -high_y));
        depth = minf(maxf(depth, low_z), high_z) * inverse;
        bool met = (outside <= 0) & ((least >= 0) | (most <= 0)) & (determinant != 0) & (depth > t_min);
        t[l] = met ? depth : INFINITY;
    }
}

static inline float least_of(const float *v) {
    float quarter[4];
    for (int l = 0; l < 4; l++) quarter[l] = minf(v[l], v[l + 4]);
    return minf(minf(quarter[0], quarter[1]), minf(quarter[2], quarter[3]));
}

// The triangle with the least t in (t_min, *t), which becomes *t.
static uint32_t find_nearest(const struct mesh_tree *tree, const struct line *line, float t_min, float *t) {
    struct waiting stack[STACK];
    uint32_t triangle = MESH_MISSED;
    float t_max = *t;
    int depth = push_children(&tree->nodes[0], line, t_min, t_max, stack, 0);
    while (depth > 0) {
        const struct waiting next = stack[--depth];
        if (next.near > t_max) continue;
        const uint32_t count = next.child & CHILD_COUNT, index = next.child >> CHILD_SHIFT;
        if (count == CHILD_INNER) {
            depth = push_children(&tree->nodes[index], line, t_min, t_max, stack, depth);
            continue;
        }
        for (const struct mesh_block *block = tree->blocks + index; block < tree->blocks + index + count; block++) {
            lane_floats at;
            meet(block, line, t_min, at);
            const float least = least_of(at);
            if (!(least < t_max)) continue;
            t_max = least;
            EACH_LANE triangle = at[l] == least ? block->triangle[l] : triangle;
        }
    }
    *t = t_max;
    return triangle;
}

uint32_t mesh_tree_nearest(const struct mesh_tree *tree, vec3 origin, vec3 direction, float t_min, float *t) {
    const struct line line = line_make(origin, direction);
    *t = INFINITY;
    return find_nearest(tree, &line, t_min, t);
}

bool mesh_tree_span(const struct mesh_tree *tree, vec3 origin, vec3 direction, float length, float *first,
                    float *last) {
    struct line line = line_make(origin, direction);
    *first = INFINITY;
    if (find_nearest(tree, &line, -INFINITY, first) == MESH_MISSED) return false;
    // The same from the other end, only as far as to the first.
    vec3_store(line.origin, vec3_mad(direction, length, origin));
    for (int a = 0; a < 3; a++) line.inverse[a] = -line.inverse[a];
    float back = length - *first;
    find_nearest(tree, &line, -INFINITY, &back);
    *last = maxf(length - back, *first);
    return true;
}

void mesh_tree_visit(const struct mesh_tree *tree, vec3 origin, vec3 direction, float t_min, mesh_visit *visit,
                     void *user) {
    const struct line line = line_make(origin, direction);
    struct waiting stack[STACK];
    int depth = push_children(&tree->nodes[0], &line, t_min, INFINITY, stack, 0);
    while (depth > 0) {
        const uint32_t child = stack[--depth].child, count = child & CHILD_COUNT, index = child >> CHILD_SHIFT;
        if (count == CHILD_INNER) {
            depth = push_children(&tree->nodes[index], &line, t_min, INFINITY, stack, depth);
            continue;
        }
        for (const struct mesh_block *block = tree->blocks + index; block < tree->blocks + index + count; block++) {
            lane_floats at;
            meet(block, &line, t_min, at);
            EACH_LANE if (at[l] < INFINITY) visit(user, block->triangle[l]);
        }
    }
}
