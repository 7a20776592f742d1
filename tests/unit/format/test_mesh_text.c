// OBJ and PLY files written here. What Mitsuba 3.9 makes of the same files (order of vertices, flipped v, computed
// normals) was printed with mi.traverse and is recorded in the expectations.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>
#include <cmocka.h>

#include "base/file.h"
#include "format/mesh.h"

typedef enum status mesh_loader(struct mesh *, struct arena *, const char *, struct error *);

static struct arena arena;
static struct error error;

static enum status load(struct mesh *mesh, mesh_loader *loader, const void *text, size_t length) {
    char path[64];
    snprintf(path, sizeof path, "/tmp/sconce_test_mesh_%ld", (long)getpid());
    assert_int_equal(file_write_atomic(path, text, length, NULL), STATUS_OK);
    enum status status = loader(mesh, &arena, path, &error);
    if (status != STATUS_OK) assert_non_null(strstr(error.text, path));
    remove(path);
    return status;
}

static enum status load_text(struct mesh *mesh, mesh_loader *loader, const char *text) {
    return load(mesh, loader, text, strlen(text));
}

static int free_arena(void **state) {
    (void)state;
    arena_fini(&arena);
    return 0;
}

static void assert_vec3(vec3 v, float x, float y, float z) {
    assert_float_equal(v.x, x, 1e-5f);
    assert_float_equal(v.y, y, 1e-5f);
    assert_float_equal(v.z, z, 1e-5f);
}

static void assert_bent_quad(const struct mesh *mesh) {
    const uint32_t indices[] = {0, 1, 2, 0, 2, 3};
    assert_int_equal(mesh->vertex_count, 4);
    assert_int_equal(mesh->triangle_count, 2);
    assert_memory_equal(mesh->indices, indices, sizeof indices);
    assert_vec3(mesh->positions[3], 0, 1, 0.5f);
    assert_null(mesh->normals);
    struct mesh copy = *mesh;
    assert_int_equal(mesh_compute_normals(&copy, &arena, &error), STATUS_OK);
    assert_vec3(copy.normals[0], 0.227046f, -0.227046f, 0.947048f); // Mitsuba's values
    assert_vec3(copy.normals[1], 0, 0, 1);
    assert_vec3(copy.normals[3], 0.408248f, -0.408248f, 0.816497f);
}

static void test_obj(void **state) {
    (void)state;
    struct mesh mesh;
    assert_int_equal(load_text(&mesh, mesh_load_obj,
                               "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0.5\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
                               "f 1/1 2/2 3/3\nf 1/1 3/3 4/4\n"),
                     STATUS_OK);
    assert_bent_quad(&mesh);
    assert_float_equal(mesh.uvs[0].y, 1, 0);
    assert_float_equal(mesh.uvs[2].x, 1, 0);
    assert_float_equal(mesh.uvs[2].y, 0, 0);
    assert_int_equal(load_text(&mesh, mesh_load_obj, "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0.5\nf -4 -3 -2 -1\n"),
                     STATUS_OK);
    assert_bent_quad(&mesh);
    assert_null(mesh.uvs);
    // Two objects with a material each, a line and a point: joined in order; normals become unit.
    assert_int_equal(
        load_text(&mesh, mesh_load_obj,
                  "mtllib none.mtl\no a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 3\nusemtl x\nf 1//1 2//1 3//1\nl 1 2\np 3\n"
                  "o b\nv 0 0 1\nv 1 0 1\nv 0 1 1\nvn 0 0 -2\nusemtl y\nf 4//2 5//2 6//2\n"),
        STATUS_OK);
    assert_int_equal(mesh.triangle_count, 2);
    assert_vec3(mesh.positions[mesh.indices[3]], 0, 0, 1);
    assert_vec3(mesh.normals[mesh.indices[0]], 0, 0, 1);
    assert_vec3(mesh.normals[mesh.indices[5]], 0, 0, -1);
}

static void test_obj_errors(void **state) {
    (void)state;
    struct mesh mesh;
    const char *bad[] = {"",
                         "hello\n",
                         "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n",
                         "v 0 0 0\nv nan 0 0\nv 0 1 0\nf 1 2 3\n",
                         "v 0 0 0\nv 1e400 0 0\nv 0 1 0\nf 1 2 3\n",
                         "v 0 0 0\nv 1 0 0\nv 0 1 0\nl 1 2\np 3\n",
                         "v 0 0 0\nv 1 0 0\nv 0 1"};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; ++i)
        assert_int_equal(load_text(&mesh, mesh_load_obj, bad[i]), STATUS_INVALID);
    assert_int_equal(mesh_load_obj(&mesh, &arena, "/nowhere/a.obj", &error), STATUS_IO);
    assert_non_null(strstr(error.text, "/nowhere/a.obj"));
    assert_int_equal(mesh_load_ply(&mesh, &arena, "/nowhere/a.ply", &error), STATUS_IO);
}

static void test_ply_ascii(void **state) {
    (void)state;
    struct mesh mesh;
    assert_int_equal(
        load_text(
            &mesh, mesh_load_ply,
            "ply\r\nformat ascii 1.0\r\ncomment a quad\r\nelement vertex 4\r\nproperty float x\nproperty double y\n"
            "property float z\nproperty list uchar int tags\nproperty float s\nproperty float t\n"
            "element edge 1\nproperty int a\nproperty int b\n"
            "element face 2\nproperty uchar red\nproperty list uint8 int32 vertex_index\nend_header\n"
            "0 0 0 0 0 0\n1 0 0 1 7 1 0\n1 1 0 2 7 8 1 1\n0 1 0.5 0 0 0.75\n0 1\n9 4 0 1 2 3\n9 2 0 1\n"),
        STATUS_OK);
    assert_bent_quad(&mesh);
    assert_float_equal(mesh.uvs[3].x, 0, 0);
    assert_float_equal(mesh.uvs[3].y, 0.75f, 0);
    assert_float_equal(mesh.uvs[2].x, 1, 0);
}

// The same quad in both byte orders, then every truncation of it.
static void test_ply_binary(void **state) {
    (void)state;
    const float vertices[4][6] = {{0, 0, 0, 0, 0, 2}, {1, 0, 0, 0, 0, 0}, {1, 1, 0, 0, 3, 0}, {0, 1, 0.5f, 1, 0, 0}};
    const int32_t faces[2][3] = {{0, 1, 2}, {0, 2, 3}};
    for (int big = 0; big < 2; ++big) {
        uint8_t file[512];
        size_t length =
            (size_t)snprintf((char *)file, sizeof file,
                             "ply\nformat binary_%s_endian 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
                             "property float z\nproperty float nx\nproperty float ny\nproperty float nz\n"
                             "element face 2\nproperty list uchar int vertex_indices\nend_header\n",
                             big ? "big" : "little");
        for (int i = 0; i < 24 + 8; ++i) {
            uint32_t bits;
            if (i >= 24 && (i - 24) % 4 == 0) {
                file[length++] = 3;
                continue;
            }
            if (i < 24) memcpy(&bits, &vertices[i / 6][i % 6], 4);
            if (i >= 24) bits = (uint32_t)faces[(i - 24) / 4][(i - 24) % 4 - 1];
            for (int k = 0; k < 4; ++k) file[length++] = (uint8_t)(bits >> 8 * (big ? 3 - k : k));
        }
        struct mesh mesh;
        assert_int_equal(load(&mesh, mesh_load_ply, file, length), STATUS_OK);
        assert_vec3(mesh.normals[0], 0, 0, 1);
        assert_vec3(mesh.normals[1], 0, 0, 1); // written as zero: computed
        assert_vec3(mesh.normals[2], 0, 1, 0);
        mesh.normals = NULL;
        assert_bent_quad(&mesh);
        for (size_t i = 0; i < length; ++i) assert_int_equal(load(&mesh, mesh_load_ply, file, i), STATUS_INVALID);
        file[length - 4 + (big ? 3 : 0)] = 4;
        assert_int_equal(load(&mesh, mesh_load_ply, file, length), STATUS_INVALID);
        assert_non_null(strstr(error.text, "refers to vertex 4 of 4"));
    }
}

static void test_ply_errors(void **state) {
    (void)state;
    struct mesh mesh;
    const char *bad[] = {
        "ply\nformat ascii 1.0\nelement vertex 9000000000000000000\nproperty float x\nproperty float y\nproperty float "
        "z\nend_header\n0 0 0\n",
        "ply\nformat ascii 1.0\nelement vertex -1\nproperty float x\nproperty float y\nproperty float z\nend_header\n",
        "ply\nformat ascii 1.0\nelement nothing 9000000000000000000\nend_header\n",
        "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nend_header\n0 0\n",
        "ply\nformat ascii 1.0\nproperty float x\nend_header\n",
        "ply\nformat ascii 1.0\nelement vertex 1\nproperty quaternion x\nend_header\n0\n",
        "ply\nelement vertex 0\nend_header\n",
        "plyx\n",
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face "
        "1\n"
        "property list char int vertex_indices\nend_header\n0 0 0\n0 inf 0\n1 1 1\n3 0 1 2\n",
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face "
        "1\n"
        "property list char int vertex_indices\nend_header\n0 0 0\n0 1 0\n1 1 1\n3 0 1 -2\n",
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; ++i)
        assert_int_equal(load_text(&mesh, mesh_load_ply, bad[i]), STATUS_INVALID);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_obj),        cmocka_unit_test(test_obj_errors), cmocka_unit_test(test_ply_ascii),
        cmocka_unit_test(test_ply_binary), cmocka_unit_test(test_ply_errors),
    };
    return cmocka_run_group_tests(tests, NULL, free_arena);
}
