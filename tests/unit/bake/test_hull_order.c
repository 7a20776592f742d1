// The order of a hull's triangles: the same triangles, wound the same way, in their parts; neighbours follow each
// other.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>
#include <stdlib.h>
#include <string.h>

#include "bake/hull_order.h"
#include "luminaire/hull_pack.h"
#include "math/sampler.h"

enum { SIDE = 60, GRID = 2 * SIDE * SIDE, LOOSE = 50, TRIANGLES = GRID + LOOSE };

static uint16_t grid_vertex(int x, int y) { return (uint16_t)(y * (SIDE + 1) + x); }

// A grid of SIDE x SIDE squares, its triangles shuffled, and a part of random ones.
static struct hull *make_hull(void) {
    struct hull *hull;
    struct error error;
    const size_t vertices = (SIDE + 1) * (SIDE + 1);
    assert_int_equal(hull_allocate(&hull, vertices + 7, TRIANGLES, &error), STATUS_OK); // 7 of no triangle
    struct sampler sampler = sampler_make(3, 0, 0);
    for (int y = 0; y <= SIDE; y++)
        for (int x = 0; x <= SIDE; x++) {
            uint32_t *v = hull->vertices[grid_vertex(x, y)];
            v[0] = 1000 * (uint32_t)x, v[1] = 1000 * (uint32_t)y, v[2] = (uint32_t)(sampler_1d(&sampler) * 300);
        }
    for (int y = 0, t = 0; y < SIDE; y++)
        for (int x = 0; x < SIDE; x++, t += 2) {
            const uint16_t square[2][3] = {{grid_vertex(x, y), grid_vertex(x + 1, y), grid_vertex(x, y + 1)},
                                           {grid_vertex(x, y + 1), grid_vertex(x + 1, y), grid_vertex(x + 1, y + 1)}};
            memcpy(hull->triangles[t], square, sizeof square);
        }
    for (size_t t = GRID - 1; t > 0; t--) {
        const size_t other = (size_t)(sampler_1d(&sampler) * 0.99999f * (float)(t + 1));
        uint16_t kept[3];
        memcpy(kept, hull->triangles[t], sizeof kept);
        memcpy(hull->triangles[t], hull->triangles[other], sizeof kept);
        memcpy(hull->triangles[other], kept, sizeof kept);
    }
    for (int t = GRID; t < TRIANGLES; t++)
        for (int k = 0; k < 3; k++)
            hull->triangles[t][k] = (uint16_t)(sampler_1d(&sampler) * 0.99999f * (float)vertices);
    hull->part_count = 2;
    hull->parts[0] = (struct hull_part){.count = GRID};
    hull->parts[1] = (struct hull_part){.first = GRID, .count = LOOSE};
    return hull;
}

struct corners { // of a triangle by position, the least first
    uint32_t at[3][3];
};

static int corners_order(const void *a, const void *b) { return memcmp(a, b, sizeof(struct corners)); }

static struct corners *sorted_triangles(const struct hull *hull, size_t part) {
    const struct hull_part *of = &hull->parts[part];
    struct corners *all = calloc(of->count, sizeof *all);
    for (size_t i = 0; i < of->count; i++) {
        const uint16_t *v = hull->triangles[of->first + i];
        int first = 0;
        for (int k = 1; k < 3; k++)
            if (memcmp(hull->vertices[v[k]], hull->vertices[v[first]], sizeof *hull->vertices) < 0) first = k;
        for (int k = 0; k < 3; k++) memcpy(all[i].at[k], hull->vertices[v[(first + k) % 3]], sizeof *all[i].at);
    }
    qsort(all, of->count, sizeof *all, corners_order);
    return all;
}

static void keeps_the_triangles(void **state) {
    (void)state;
    struct hull *before = make_hull(), *after = make_hull();
    struct error error;
    assert_int_equal(hull_order(after, &error), STATUS_OK);
    assert_int_equal(after->vertex_count, before->vertex_count - 7);
    assert_int_equal(after->triangle_count, TRIANGLES);
    for (size_t part = 0; part < 2; part++) {
        struct corners *a = sorted_triangles(before, part), *b = sorted_triangles(after, part);
        assert_memory_equal(a, b, before->parts[part].count * sizeof *a);
        free(a);
        free(b);
    }
    size_t joined = 0; // triangles that share two vertices with the one before
    for (int t = 1; t < GRID; t++) {
        int shared = 0;
        for (int k = 0; k < 9; k++) shared += after->triangles[t][k / 3] == after->triangles[t - 1][k % 3];
        joined += shared == 2;
    }
    assert_true(joined > GRID * 8 / 10);
    assert_int_equal(hull_pack(before, &error), STATUS_OK);
    assert_int_equal(hull_pack(after, &error), STATUS_OK);
    assert_true(3 * after->packed_bytes < before->packed_bytes);
    hull_destroy(before);
    hull_destroy(after);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(keeps_the_triangles)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
