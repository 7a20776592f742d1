// The hierarchy is split by the surface area heuristic (Goldsmith and Salmon 1987), of 15 planes across each axis of
// the centroids' box (Wald 2007, "On fast Construction of SAH-based Bounding Volume Hierarchies"), a block counting as
// one whether it is full or not. A node of 8 comes from 7 such splits, always of the largest box that can be split.
#include <stdlib.h>
#include <string.h>

#include "luminaire/mesh_tree_private.h"

enum { BINS = 16, LEVELS_BY_AREA = 18 }; // below them halves, of which there are at most log2(2^26 / 8)
static const float margin = 2e-6f; // [extent of the mesh] of boxes, for rounding
static const float rounding = 4e-7f; // of the sine of an angle

struct box {
    float lower[3], upper[3];
};

struct item {
    struct box box;
    float middle[3];
    uint32_t triangle;
};

struct range {
    size_t first, count;
    struct box box;
};

struct builder {
    struct mesh_tree *tree;
    struct item *items;
    const float (*vertices)[3];
    const uint32_t (*triangles)[3];
    uint32_t node_count, block_count;
    float margin;
};

static const struct box nothing = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};

static void grow(struct box *box, const struct box *by) {
    for (int a = 0; a < 3; a++) {
        box->lower[a] = minf(box->lower[a], by->lower[a]);
        box->upper[a] = maxf(box->upper[a], by->upper[a]);
    }
}

static float half_area(const struct box *box) {
    float x = box->upper[0] - box->lower[0], y = box->upper[1] - box->lower[1], z = box->upper[2] - box->lower[2];
    return x * y + y * z + z * x;
}

static size_t blocks_of(size_t count) { return (count + LANES - 1) / LANES; }

static float cost_of(const struct box *box, size_t count) {
    return count ? half_area(box) * (float)blocks_of(count) : 0;
}

struct split {
    int axis;
    float from, scale; // bin = (middle - from) * scale
    int bin; // the first of the second half
    float cost;
};

static int bin_of(const struct split *split, const struct item *item) {
    int bin = (int)((item->middle[split->axis] - split->from) * split->scale);
    return bin < BINS ? bin : BINS - 1;
}

// The best plane across an axis, where it is better than the one in *best.
static void find_plane(const struct item *items, size_t count, int axis, struct split *best) {
    float from = INFINITY, to = -INFINITY;
    for (size_t i = 0; i < count; i++) {
        from = minf(from, items[i].middle[axis]);
        to = maxf(to, items[i].middle[axis]);
    }
    struct split split = {axis, from, BINS / (to - from), 0, 0};
    if (!(split.scale < INFINITY)) return;
    struct box boxes[BINS], behind[BINS], box = nothing;
    size_t counts[BINS] = {0}, n = 0;
    for (int b = 0; b < BINS; b++) boxes[b] = nothing;
    for (size_t i = 0; i < count; i++) {
        int bin = bin_of(&split, &items[i]);
        grow(&boxes[bin], &items[i].box);
        counts[bin]++;
    }
    for (int b = BINS; b-- > 0;) {
        grow(&box, &boxes[b]);
        behind[b] = box;
    }
    box = nothing;
    for (split.bin = 1; split.bin < BINS; split.bin++) {
        grow(&box, &boxes[split.bin - 1]);
        n += counts[split.bin - 1];
        if (n == 0 || n == count) continue;
        split.cost = cost_of(&box, n) + cost_of(&behind[split.bin], count - n);
        if (split.cost < best->cost) *best = split;
    }
}

static struct range range_make(const struct builder *b, size_t first, size_t count) {
    struct range range = {first, count, nothing};
    for (size_t i = first; i < first + count; i++) grow(&range.box, &b->items[i].box);
    return range;
}

// Moves the items of the first half of the range to its front; returns how many.
static size_t divide(const struct builder *b, const struct range *range, bool by_area) {
    struct item *items = b->items + range->first;
    struct split best = {.cost = INFINITY};
    for (int axis = 0; by_area && axis < 3; axis++) find_plane(items, range->count, axis, &best);
    if (!(best.cost < INFINITY)) return range->count / 2;
    size_t front = 0;
    for (size_t i = 0; i < range->count; i++) {
        if (bin_of(&best, &items[i]) >= best.bin) continue;
        struct item item = items[i];
        items[i] = items[front];
        items[front++] = item;
    }
    return front;
}

static uint32_t build_leaf(struct builder *b, const struct range *range) {
    const uint32_t first = b->block_count;
    for (size_t k = 0; k < blocks_of(range->count); k++) {
        struct mesh_block *block = &b->tree->blocks[b->block_count++];
        for (size_t l = 0; l < LANES; l++) {
            const size_t i = k * LANES + l;
            const bool used = i < range->count;
            block->triangle[l] = b->items[range->first + (used ? i : 0)].triangle;
            const uint32_t *corners = b->triangles[block->triangle[l]];
            for (int c = 0; c < 3; c++) {
                for (int a = 0; a < 3; a++) block->corners[c][a][l] = b->vertices[corners[used ? c : 0]][a];
            }
        }
    }
    return first << CHILD_SHIFT | (b->block_count - first);
}

static void build_node(struct builder *b, uint32_t at, struct range whole, int level) {
    struct range ranges[LANES] = {whole};
    int count = 1;
    while (count < LANES) {
        int widest = -1;
        for (int i = 0; i < count; i++)
            if (ranges[i].count > LANES && (widest < 0 || half_area(&ranges[i].box) > half_area(&ranges[widest].box)))
                widest = i;
        if (widest < 0) break;
        const struct range range = ranges[widest];
        const size_t front = divide(b, &range, level < LEVELS_BY_AREA);
        ranges[widest] = range_make(b, range.first, front);
        ranges[count++] = range_make(b, range.first + front, range.count - front);
    }
    struct mesh_node *node = &b->tree->nodes[at];
    for (int i = 0; i < LANES; i++) {
        const bool used = i < count && ranges[i].count > 0;
        for (int a = 0; a < 3; a++) {
            node->bounds[0][a][i] = used ? ranges[i].box.lower[a] - b->margin : INFINITY;
            node->bounds[1][a][i] = used ? ranges[i].box.upper[a] + b->margin : -INFINITY;
        }
        if (!used) continue;
        if (blocks_of(ranges[i].count) <= MOST_BLOCKS) {
            node->child[i] = build_leaf(b, &ranges[i]);
            continue;
        }
        const uint32_t child = b->node_count++;
        node->child[i] = child << CHILD_SHIFT | CHILD_INNER;
        build_node(b, child, ranges[i], level + 1);
    }
}

static bool item_make(struct item *item, const float (*vertices)[3], const uint32_t corners[3], uint32_t triangle) {
    vec3 corner[3];
    item->box = nothing;
    for (int c = 0; c < 3; c++) {
        const float *p = vertices[corners[c]];
        corner[c] = (vec3){p[0], p[1], p[2]};
        for (int a = 0; a < 3; a++) {
            item->box.lower[a] = minf(item->box.lower[a], p[a]);
            item->box.upper[a] = maxf(item->box.upper[a], p[a]);
        }
    }
    const vec3 first = vec3_sub(corner[1], corner[0]), second = vec3_sub(corner[2], corner[0]);
    if (!(vec3_length(vec3_cross(first, second)) > rounding * vec3_length(first) * vec3_length(second))) return false;
    for (int a = 0; a < 3; a++) item->middle[a] = 0.5f * item->box.lower[a] + 0.5f * item->box.upper[a];
    item->triangle = triangle;
    return true;
}

static float margin_of(const struct box *box) {
    float largest = 0;
    for (int a = 0; a < 3; a++) {
        float extent = box->upper[a] - box->lower[a], away = maxf(fabsf(box->lower[a]), fabsf(box->upper[a]));
        largest = maxf(largest, maxf(extent, away));
    }
    return margin * largest;
}

enum status mesh_tree_create(struct mesh_tree **result, const float (*vertices)[3], const uint32_t (*triangles)[3],
                             size_t count, struct error *error) {
    struct mesh_tree *tree = *result = calloc(1, sizeof *tree);
    struct item *items = malloc((count + 1) * sizeof *items);
    size_t used = 0;
    for (uint32_t i = 0; items && i < count; i++) used += item_make(&items[used], vertices, triangles[i], i);
    if (tree) { // Every node has two children or more but the root, every leaf a triangle.
        tree->nodes = aligned_alloc(_Alignof(struct mesh_node), (used + 1) * sizeof *tree->nodes);
        tree->blocks = aligned_alloc(_Alignof(struct mesh_block), (used + 1) * sizeof *tree->blocks);
    }
    if (!tree || !items || !tree->nodes || !tree->blocks) {
        free(items);
        mesh_tree_destroy(tree);
        *result = NULL;
        return error_set(error, STATUS_MEMORY, "out of memory for a tree of %zu triangles", count);
    }
    struct builder b = {tree, items, vertices, triangles, 1, 0, 0};
    struct range whole = range_make(&b, 0, used);
    b.margin = margin_of(&whole.box);
    build_node(&b, 0, whole, 0);
    free(items);
    return STATUS_OK;
}

void mesh_tree_destroy(struct mesh_tree *tree) {
    if (!tree) return;
    free(tree->nodes);
    free(tree->blocks);
    free(tree);
}
