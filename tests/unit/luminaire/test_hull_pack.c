// Meshes of hulls as streams: what is packed comes back, whatever its order, and nothing else does.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>
#include <stdlib.h>
#include <string.h>

#include "luminaire/hull_pack.h"
#include "math/sampler.h"

static struct hull *random_hull(uint64_t seed, size_t vertices, size_t triangles) {
    struct hull *hull;
    struct error error;
    assert_int_equal(hull_allocate(&hull, vertices, triangles, &error), STATUS_OK);
    struct sampler sampler = sampler_make(seed, 0, 0);
    for (size_t i = 0; i < vertices; i++)
        for (int a = 0; a < 3; a++) {
            const float u = sampler_1d(&sampler);
            hull->vertices[i][a] = u < 0.1f ? 0 : u > 0.9f ? HULL_MAX_CODE : (uint32_t)(u * HULL_MAX_CODE);
        }
    for (size_t i = 0; i < vertices; i++)
        for (int a = 0; a < 2; a++) hull->normals[i][a] = (uint16_t)(sampler_1d(&sampler) * HULL_MAX_NORMAL);
    for (size_t t = 0; t < triangles; t++)
        for (int k = 0; k < 3; k++)
            hull->triangles[t][k] = (uint16_t)(sampler_1d(&sampler) * 0.999999f * (float)vertices);
    return hull;
}

static void what_is_packed_comes_back(void **state) {
    (void)state;
    static const size_t sizes[][2] = {{1, 1}, {3, 1}, {4, 2}, {300, 1}, {700, 2000}, {HULL_MAX_VERTICES, 70000}};
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        struct hull *hull = random_hull(i, sizes[i][0], sizes[i][1]), *read;
        struct error error;
        assert_int_equal(hull_pack(hull, &error), STATUS_OK);
        assert_int_equal(hull_allocate(&read, hull->vertex_count, hull->triangle_count, &error), STATUS_OK);
        assert_int_equal(hull_unpack(read, hull->packed, hull->packed_bytes, &error), STATUS_OK);
        assert_memory_equal(read->vertices, hull->vertices, hull->vertex_count * sizeof *hull->vertices);
        assert_memory_equal(read->normals, hull->normals, hull->vertex_count * sizeof *hull->normals);
        assert_memory_equal(read->triangles, hull->triangles, hull->triangle_count * sizeof *hull->triangles);
        assert_int_equal(read->packed_bytes, hull->packed_bytes);
        assert_memory_equal(read->packed, hull->packed, hull->packed_bytes);
        hull_destroy(hull);
        hull_destroy(read);
    }
}

static void rows_take_little(void **state) { // a strip of triangles in the order of its vertices
    (void)state;
    enum { N = 20000 };
    struct hull *hull;
    struct error error;
    assert_int_equal(hull_allocate(&hull, N + 2, N, &error), STATUS_OK);
    for (uint32_t i = 0; i < N + 2; i++) hull->vertices[i][0] = 800 * i, hull->vertices[i][1] = i & 1 ? 900000 : 0;
    for (size_t t = 0; t < N; t++)
        for (size_t k = 0; k < 3; k++) hull->triangles[t][k] = (uint16_t)(t + (t & 1 ? 2 - k : k));
    assert_int_equal(hull_pack(hull, &error), STATUS_OK);
    assert_true(hull->packed_bytes < N / 10);
    hull_destroy(hull);
}

static void other_streams_are_refused(void **state) {
    (void)state;
    struct hull *hull = random_hull(1, 50, 80), *read;
    struct error error = {0};
    assert_int_equal(hull_pack(hull, &error), STATUS_OK);
    const size_t bytes = hull->packed_bytes;
    unsigned char *stream = malloc(bytes);
    for (int i = 0; i < 4; i++) { // fewer vertices, more vertices, cut short, one bit turned
        assert_int_equal(hull_allocate(&read, i == 0 ? 49 : i == 1 ? 51 : 50, 80, &error), STATUS_OK);
        memcpy(stream, hull->packed, bytes);
        if (i == 3) stream[bytes / 2] ^= 4;
        error.text[0] = 0;
        assert_int_equal(hull_unpack(read, stream, i == 2 ? bytes / 2 : bytes, &error), STATUS_INVALID);
        assert_true(error.text[0]);
        hull_destroy(read);
    }
    free(stream);
    hull_destroy(hull);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(what_is_packed_comes_back), cmocka_unit_test(rows_take_little),
                                       cmocka_unit_test(other_streams_are_refused)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
