// Serialized meshes written here with zlib; Mitsuba 3.9 read the same bytes to the same arrays.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>
#include <cmocka.h>

#include "base/file.h"
#include "format/mesh.h"

static struct arena arena;
static struct error error;

struct bytes {
    uint8_t data[4096];
    size_t length;
};

static void put(struct bytes *b, const void *data, size_t length) {
    assert_true(b->length + length <= sizeof b->data);
    memcpy(b->data + b->length, data, length);
    b->length += length;
}

static void put_integer(struct bytes *b, uint64_t value, size_t size) { put(b, &value, size); } // little-endian hosts

static void put_number(struct bytes *b, double value, uint32_t flags) {
    float single = (float)value;
    if (flags & 0x2000)
        put(b, &value, 8);
    else
        put(b, &single, 4);
}

static const double quad[4][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0.5}};
static const uint32_t quad_indices[] = {0, 1, 2, 0, 2, 3};

// The quad, raised by `z`, announcing the given counts.
static void put_shape(struct bytes *file, int version, uint32_t flags, double z, uint64_t vertices,
                      uint64_t triangles) {
    struct bytes raw = {.length = 0};
    put_integer(&raw, flags, 4);
    if (version == 4) put(&raw, "quad", 5);
    put_integer(&raw, vertices, 8);
    put_integer(&raw, triangles, 8);
    for (int i = 0; i < 12; ++i) put_number(&raw, quad[i / 3][i % 3] + (i % 3 == 2 ? z : 0), flags);
    for (int i = 0; i < 12 && flags & 1; ++i) put_number(&raw, i % 3 == 2 ? -2 : 0, flags);
    for (int i = 0; i < 8 && flags & 2; ++i) put_number(&raw, 0.125 * i, flags);
    for (int i = 0; i < 12 && flags & 8; ++i) put_number(&raw, 0.5, flags);
    put(&raw, quad_indices, sizeof quad_indices);
    put_integer(file, 0x041C, 2);
    put_integer(file, (uint64_t)version, 2);
    uLongf room = sizeof file->data - file->length;
    assert_int_equal(compress(file->data + file->length, &room, raw.data, raw.length), Z_OK);
    file->length += room;
}

static void put_dictionary(struct bytes *file, int version, const uint64_t *offsets, size_t count) {
    for (size_t i = 0; i < count; ++i) put_integer(file, offsets[i], version == 4 ? 8 : 4);
    put_integer(file, count, 4);
}

static enum status parse(struct mesh *mesh, const struct bytes *file, int shape_index) {
    uint8_t *exact = malloc(file->length + 1); // so that a sanitizer sees reads past the end
    assert_non_null(exact);
    memcpy(exact, file->data, file->length);
    enum status status = mesh_parse_serialized(mesh, &arena, "a.serialized", exact, file->length, shape_index, &error);
    if (status != STATUS_OK) assert_non_null(strstr(error.text, "a.serialized"));
    free(exact);
    return status;
}

static int free_arena(void **state) {
    (void)state;
    arena_fini(&arena);
    return 0;
}

static void test_versions_and_flags(void **state) {
    (void)state;
    const uint32_t flags[] = {0, 1, 2, 3, 8 | 2, 0x1000 | 1 | 2 | 8, 0x2000, 0x2000 | 1 | 2 | 8, 0x10 | 1};
    for (size_t i = 0; i < 2 * (sizeof flags / sizeof *flags); ++i) {
        int version = 3 + (int)(i % 2);
        uint32_t flag = flags[i / 2];
        struct bytes file = {.length = 0};
        uint64_t offsets[2] = {0};
        put_shape(&file, version, 0, 5, 4, 2);
        offsets[1] = file.length;
        put_shape(&file, version, flag, 7, 4, 2);
        put_dictionary(&file, version, offsets, 2);
        struct mesh mesh;
        assert_int_equal(parse(&mesh, &file, 1), STATUS_OK);
        assert_int_equal(mesh.vertex_count, 4);
        assert_int_equal(mesh.triangle_count, 2);
        assert_memory_equal(mesh.indices, quad_indices, sizeof quad_indices);
        for (int v = 0; v < 4; ++v) {
            assert_float_equal(mesh.positions[v].x, (float)quad[v][0], 0);
            assert_float_equal(mesh.positions[v].z, (float)quad[v][2] + 7, 0);
            if (mesh.normals) assert_float_equal(mesh.normals[v].z, -1, 0);
            if (mesh.uvs) assert_float_equal(mesh.uvs[v].y, 0.125f + 0.25f * (float)v, 0);
        }
        assert_int_equal(mesh.normals != NULL, (flag & 1) != 0);
        assert_int_equal(mesh.uvs != NULL, (flag & 2) != 0);
        assert_int_equal(parse(&mesh, &file, 0), STATUS_OK);
        assert_float_equal(mesh.positions[0].z, 5, 0);
        assert_int_equal(parse(&mesh, &file, 2), STATUS_INVALID);
        assert_int_equal(parse(&mesh, &file, -1), STATUS_INVALID);
    }
}

static void test_damage(void **state) {
    (void)state;
    struct bytes whole = {.length = 0};
    struct mesh mesh;
    const uint64_t offset = 0;
    put_shape(&whole, 4, 3, 0, 4, 2);
    put_dictionary(&whole, 4, &offset, 1);
    for (size_t i = 0; i < whole.length; ++i) {
        struct bytes cut = whole;
        cut.length = i;
        assert_int_not_equal(parse(&mesh, &cut, 0), STATUS_OK);
        cut = whole;
        cut.data[i] ^= 0x41;
        parse(&mesh, &cut, 0); // may be an error or, where a position changed, a mesh
    }
    struct bytes other = whole;
    other.data[2] = 5;
    assert_int_equal(parse(&mesh, &other, 0), STATUS_UNSUPPORTED);
    assert_int_equal(mesh_load_serialized(&mesh, &arena, "/nowhere/a.serialized", 0, &error), STATUS_IO);
}

// A hundred bytes that announce 2^32 - 1 vertices and more must fail on what is there, without the memory.
static void test_claims(void **state) {
    (void)state;
    const uint64_t counts[][2] = {
        {5, 2},          {4, 3},          {1ull << 40, 2}, {UINT32_MAX, 2}, {UINT64_MAX, UINT64_MAX},
        {4, 1ull << 40}, {4, UINT64_MAX}, {0, 0},          {4, 0},          {3, 2}};
    for (size_t i = 0; i < sizeof counts / sizeof *counts; ++i) {
        struct bytes file = {.length = 0};
        struct mesh mesh;
        const uint64_t offset = 0;
        put_shape(&file, 4, 0, 0, counts[i][0], counts[i][1]);
        put_dictionary(&file, 4, &offset, 1);
        assert_int_equal(parse(&mesh, &file, 0), STATUS_INVALID);
    }
    struct bytes file = {.length = 0};
    struct mesh mesh;
    put_shape(&file, 3, 0, NAN, 4, 2);
    const uint64_t offsets[] = {0, 0xFFFFFFFF};
    put_dictionary(&file, 3, offsets, 1);
    assert_int_equal(parse(&mesh, &file, 0), STATUS_INVALID);
    assert_non_null(strstr(error.text, "not finite"));
    put_dictionary(&file, 3, offsets, 2);
    assert_int_equal(parse(&mesh, &file, 1), STATUS_INVALID);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_versions_and_flags),
        cmocka_unit_test(test_damage),
        cmocka_unit_test(test_claims),
    };
    return cmocka_run_group_tests(tests, NULL, free_arena);
}
