// Proxies of lamps whose smallest sphere, box and cylinder are known; a given mesh that holds the lamp, cuts it, is
// open.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "bake/lamp_check.h"
#include "bake/lamp_proxy.h"

static const uint32_t cube_faces[36] = {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                                        2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};

struct box_lamp {
    vec3 corners[8];
    struct shape shape, *shapes[1];
    struct scene scene;
};

static void make_box(struct box_lamp *lamp, vec3 center, vec3 half) {
    memset(lamp, 0, sizeof *lamp);
    for (int i = 0; i < 8; i++)
        lamp->corners[i] =
            vec3_add(center, (vec3){i & 1 ? half.x : -half.x, i & 2 ? half.y : -half.y, i & 4 ? half.z : -half.z});
    lamp->shape.mesh = (struct mesh){.positions = lamp->corners,
                                     .indices = (uint32_t *)(uintptr_t)cube_faces,
                                     .vertex_count = 8,
                                     .triangle_count = 12};
    lamp->shapes[0] = &lamp->shape;
    lamp->scene = (struct scene){.shapes = lamp->shapes, .shape_count = 1, .path = "box.xml"};
}

static struct proxy fit(struct box_lamp *lamp, enum bake_proxy kind) {
    struct proxy proxy;
    struct error error;
    assert_int_equal(lamp_proxy_fit(&proxy, &lamp->scene, kind, NULL, NULL, &error), STATUS_OK);
    return proxy;
}

static void assert_near(float a, float b, float tolerance) { assert_true(fabsf(a - b) <= tolerance * fabsf(b)); }

static void sphere_is_smallest(void **state) {
    (void)state;
    struct box_lamp lamp;
    make_box(&lamp, (vec3){10, 20, -5}, (vec3){1, 2, 2});
    struct proxy proxy = fit(&lamp, BAKE_PROXY_SPHERE);
    assert_int_equal(proxy.kind, PROXY_SPHERE);
    assert_near(proxy.radius, 3, 0.02f);
    assert_true(proxy.radius > 3);
    assert_near(proxy.center[0], 10, 0.005f);
}

static void shapes_choose_their_proxy(void **state) {
    (void)state;
    struct box_lamp lamp;
    make_box(&lamp, (vec3){0, 0, 0}, (vec3){5, 0.2f, 5}); // a flat square panel
    struct proxy proxy = fit(&lamp, BAKE_PROXY_AUTO);
    assert_int_equal(proxy.kind, PROXY_BOX);
    assert_near(proxy.upper[0], 5, 0.02f);
    assert_near(proxy.lower[1], -0.2f, 0.02f);

    enum { N = 64 }; // a tube about x
    static vec3 ring[2 * N];
    for (int i = 0; i < N; i++) {
        float a = 2 * PI_F * (float)i / N;
        ring[2 * i] = (vec3){-4, cosf(a), sinf(a)};
        ring[2 * i + 1] = (vec3){4, cosf(a), sinf(a)};
    }
    lamp.shape.mesh = (struct mesh){.positions = ring, .vertex_count = 2 * N, .triangle_count = 1};
    proxy = fit(&lamp, BAKE_PROXY_AUTO);
    assert_int_equal(proxy.kind, PROXY_CYLINDER);
    assert_near(proxy.axis[0], 1, 1e-6f);
    assert_near(proxy.axis_radius, 1, 0.02f);
    assert_near(proxy.half_height, 4, 0.02f);
    assert_true(proxy.radius >= hypotf(proxy.axis_radius, proxy.half_height) * 0.9999f);
}

static void scale_does_not_matter(void **state) {
    (void)state;
    for (float unit = 1e-4f; unit < 1e6f; unit *= 100) {
        struct box_lamp lamp;
        make_box(&lamp, (vec3){0, 0, 0}, (vec3){3 * unit, 3 * unit, 3 * unit});
        struct proxy proxy = fit(&lamp, BAKE_PROXY_CYLINDER);
        assert_near(proxy.axis_radius, 3 * sqrtf(2) * unit, 0.02f);
    }
}

static void write_cube(const char *path, float half, int faces) {
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    for (int i = 0; i < 8; i++)
        fprintf(file, "v %g %g %g\n", (double)(i & 1 ? half : -half), (double)(i & 2 ? half : -half),
                (double)(i & 4 ? half : -half));
    for (int i = 0; i < faces; i++)
        fprintf(file, "f %u %u %u\n", cube_faces[3 * i] + 1, cube_faces[3 * i + 1] + 1, cube_faces[3 * i + 2] + 1);
    fclose(file);
}

static enum status fit_mesh(float half, int faces, struct proxy *proxy, struct arena *arena, struct error *error) {
    char path[] = "/tmp/sconce_proxy_XXXXXX.obj";
    int descriptor = mkstemps(path, 4);
    assert_true(descriptor >= 0);
    close(descriptor);
    write_cube(path, half, faces);
    struct box_lamp lamp;
    make_box(&lamp, (vec3){0, 0, 0}, (vec3){1, 1, 1});
    enum status status = lamp_proxy_fit(proxy, &lamp.scene, BAKE_PROXY_MESH, path, arena, error);
    unlink(path);
    return status;
}

static void mesh_must_hold_the_lamp(void **state) {
    (void)state;
    struct arena arena = {0};
    struct proxy proxy;
    struct error error;
    assert_int_equal(fit_mesh(1.1f, 12, &proxy, &arena, &error), STATUS_OK);
    assert_int_equal(proxy.kind, PROXY_MESH);
    assert_near(proxy.radius, 1.1f * sqrtf(3), 0.01f);
    double volume = 0; // outward winding
    for (size_t t = 0; t < proxy.triangle_count; t++) {
        vec3 v[3];
        for (size_t i = 0; i < 3; i++) memcpy(&v[i], proxy.vertices[proxy.indices[3 * t + i]], sizeof v[i]);
        volume += vec3_dot(v[0], vec3_cross(v[1], v[2])) / 6;
    }
    assert_near((float)volume, 8 * 1.1f * 1.1f * 1.1f, 1e-3f);
    assert_int_equal(fit_mesh(0.9f, 12, &proxy, &arena, &error), STATUS_INVALID);
    assert_non_null(strstr(error.text, "cuts the lamp"));
    assert_int_equal(fit_mesh(1.1f, 11, &proxy, &arena, &error), STATUS_INVALID);
    assert_non_null(strstr(error.text, "open"));
    arena_fini(&arena);
}

static void open_edges_are_counted(void **state) {
    (void)state;
    struct box_lamp lamp;
    make_box(&lamp, (vec3){0, 0, 0}, (vec3){1, 1, 1});
    assert_int_equal(mesh_open_edges(&lamp.shape.mesh), 0);
    lamp.shape.mesh.triangle_count = 11;
    assert_int_equal(mesh_open_edges(&lamp.shape.mesh), 3);
    vec3 split[36]; // every triangle with vertices of its own is still closed
    uint32_t order[36];
    for (uint32_t i = 0; i < 36; i++) {
        split[i] = lamp.corners[cube_faces[i]];
        order[i] = i;
    }
    struct mesh mesh = {.positions = split, .indices = order, .vertex_count = 36, .triangle_count = 12};
    assert_int_equal(mesh_open_edges(&mesh), 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sphere_is_smallest), cmocka_unit_test(shapes_choose_their_proxy),
        cmocka_unit_test(scale_does_not_matter), cmocka_unit_test(mesh_must_hold_the_lamp),
        cmocka_unit_test(open_edges_are_counted)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
