// Shapes: points, sides and uvs against Mitsuba 3's values (noted from scalar_rgb 3.9.1) and closed forms; uniform
// samples against areas; errors for transforms that cannot be served.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "../../scene_from_text.h"
#include "math/sampler.h"

static void load(struct scene *scene, const char *text) {
    struct error error = {0};
    if (scene_from_text(scene, text, &error) != STATUS_OK) fail_msg("%s: %s", text, error.text);
}

static void assert_vec3(vec3 a, float x, float y, float z) {
    if (!(vec3_length(vec3_sub(a, vec3_make(x, y, z))) < 2e-5f * (1 + vec3_length(a))))
        fail_msg("(%g %g %g) instead of (%g %g %g)", a.x, a.y, a.z, x, y, z);
}

static const struct hit_case {
    const char *text;
    vec3 origin, direction, p, n;
    vec2 uv;
    vec3 dp_du, dp_dv;
} hits[] = {
    {"<shape type='rectangle'/>",
     {.2f, .4f, 5},
     {0, 0, -1},
     {.2f, .4f, 0},
     {0, 0, 1},
     {.6f, .7f},
     {2, 0, 0},
     {0, 2, 0}},
    {"<shape type='rectangle'><transform name='to_world'><scale x='-1'/></transform></shape>",
     {.2f, .4f, 5},
     {0, 0, -1},
     {.2f, .4f, 0},
     {0, 0, 1},
     {.4f, .7f},
     {-2, 0, 0},
     {0, 2, 0}},
    {"<shape type='rectangle'><transform name='to_world'><scale z='-1'/></transform></shape>",
     {.2f, .4f, 5},
     {0, 0, -1},
     {.2f, .4f, 0},
     {0, 0, -1},
     {.6f, .7f},
     {2, 0, 0},
     {0, 2, 0}},
    {"<shape type='disk'/>",
     {.2f, .4f, 5},
     {0, 0, -1},
     {.2f, .4f, 0},
     {0, 0, 1},
     {.447214f, .176208f},
     {.447214f, .894427f, 0},
     {-2.51327f, 1.25664f, 0}},
    {"<shape type='disk'><boolean name='flip_normals' value='true'/></shape>",
     {.2f, .4f, 5},
     {0, 0, -1},
     {.2f, .4f, 0},
     {0, 0, -1},
     {.447214f, .176208f},
     {.447214f, .894427f, 0},
     {-2.51327f, 1.25664f, 0}},
    {"<shape type='sphere'/>",
     {.2f, .4f, 5},
     {0, 0, -1},
     {.2f, .4f, .894427f},
     {.2f, .4f, .894427f},
     {.176208f, .147584f},
     {-2.51327f, 1.25664f, 0},
     {1.25664f, 2.51327f, -1.40496f}},
    {"<shape type='sphere'><boolean name='flip_normals' value='true'/></shape>",
     {.2f, -.4f, 5},
     {0, 0, -1},
     {.2f, -.4f, .894427f},
     {-.2f, .4f, -.894427f},
     {.823792f, .147584f},
     {2.51327f, 1.25664f, 0},
     {1.25664f, -2.51327f, -1.40496f}},
    {"<shape type='sphere'><transform name='to_world'><scale x='-1'/></transform></shape>",
     {.2f, .4f, 5},
     {0, 0, -1},
     {.2f, .4f, .894427f},
     {-.2f, -.4f, -.894427f},
     {.323792f, .147584f},
     {2.51327f, -1.25664f, 0},
     {1.25664f, 2.51327f, -1.40496f}},
    {"<shape type='cylinder'/>",
     {5, .4f, .3f},
     {-1, 0, 0},
     {.916515f, .4f, .3f},
     {.916515f, .4f, 0},
     {.0654949f, .3f},
     {-2.51327f, 5.75864f, 0},
     {0, 0, 1}},
    {"<shape type='cylinder'><point name='p0' value='1,2,3'/><point name='p1' value='2,4,3.5'/><float name='radius' "
     "value='0.5'/></shape>",
     {1.5f, 10, 3.3f},
     {0, -1, 0},
     {1.5f, 4.06059f, 3.3f},
     {-.817591f, .485994f, -.308796f},
     {.374968f, .908795f},
     {-1.17996f, -.13711f, 2.90835f},
     {1, 2, .5f}},
    {"<shape type='cylinder'><transform name='to_world'><scale value='2'/></transform></shape>",
     {0, 0, .3f},
     {-1, 0, 0},
     {-2, 0, .3f},
     {-1, 0, 0},
     {.5f, .15f},
     {0, -12.5664f, 0},
     {0, 0, 2}},
    {"<shape type='cube'/>", {.2f, .4f, 5}, {0, 0, -1}, {.2f, .4f, 1}, {0, 0, 1}, {.7f, .6f}, {0, 2, 0}, {2, 0, 0}},
    {"<shape type='cube'><boolean name='flip_normals' value='true'/></shape>",
     {0.1f, .2f, .3f},
     {1, 0, 0},
     {1, .2f, .3f},
     {-1, 0, 0},
     {.6f, .35f},
     {0, 2, 0},
     {0, 0, -2}},
};

static void hits_are_mitsubas(void **state) {
    (void)state;
    for (size_t i = 0; i < sizeof hits / sizeof *hits; ++i) {
        struct scene scene;
        load(&scene, hits[i].text);
        struct ray ray = {hits[i].origin, hits[i].direction, 0, INFINITY};
        struct surface s;
        if (!scene_intersect(&scene, &ray, -1, &s)) fail_msg("no hit on %s", hits[i].text);
        assert_vec3(s.p, hits[i].p.x, hits[i].p.y, hits[i].p.z);
        assert_vec3(s.ng, hits[i].n.x, hits[i].n.y, hits[i].n.z);
        assert_vec3(s.shading.n, hits[i].n.x, hits[i].n.y, hits[i].n.z);
        assert_float_equal(s.uv.x, hits[i].uv.x, 2e-6);
        assert_float_equal(s.uv.y, hits[i].uv.y, 2e-6);
        assert_vec3(s.dp_du, hits[i].dp_du.x, hits[i].dp_du.y, hits[i].dp_du.z);
        assert_vec3(s.dp_dv, hits[i].dp_dv.x, hits[i].dp_dv.y, hits[i].dp_dv.z);
        assert_vec3(vec3_cross(s.shading.s, s.shading.t), s.shading.n.x, s.shading.n.y, s.shading.n.z);
        scene_fini(&scene);
    }
}

// A uniform sample is hit again from outside, at the same place and uv.
static void samples_lie_on_the_surface(void **state) {
    (void)state;
    static const char *const texts[] = {
        "<shape type='rectangle'>", "<shape type='disk'>", "<shape type='cube'>",
        "<shape type='sphere'><point name='center' value='1,2,3'/><float name='radius' value='0.3'/>",
        "<shape type='cylinder'><point name='p1' value='0.5,0.3,1'/><float name='radius' value='0.3'/>"};
    for (size_t i = 0; i < sizeof texts / sizeof *texts; ++i) {
        char text[600];
        snprintf(text, sizeof text,
                 "%s<transform name='to_world'><rotate x='1' y='1' angle='50'/><scale value='3'/><translate "
                 "x='10'/></transform><emitter type='area'/></shape>",
                 texts[i]);
        struct scene scene;
        load(&scene, text);
        for (uint64_t k = 0; k < 2000; ++k) {
            struct sampler sampler = sampler_make(1, i, k);
            struct surface sample, hit;
            shape_sample(scene.shapes[0], sampler_2d(&sampler), &sample);
            struct ray ray = {vec3_mad(sample.ng, 0.01f, sample.p), vec3_neg(sample.ng), 0, INFINITY};
            assert_true(scene_intersect(&scene, &ray, -1, &hit));
            assert_float_equal(hit.t, 0.01f, 2e-5);
            assert_true(fabsf(hit.uv.x - sample.uv.x) < 1e-3f || fabsf(fabsf(hit.uv.x - sample.uv.x) - 1) < 1e-3f);
        }
        scene_fini(&scene);
    }
}

static void areas(void **state) {
    (void)state;
    static const struct {
        const char *text;
        double area;
    } cases[] = {
        {"<shape type='rectangle'><transform name='to_world'><scale x='2' y='3'/></transform></shape>", 24},
        {"<shape type='disk'><transform name='to_world'><scale x='2' y='3'/></transform></shape>", 6 * M_PI},
        {"<shape type='cube'/>", 24},
        {"<shape type='sphere'><float name='radius' value='2'/><transform name='to_world'><scale "
         "value='3'/></transform></shape>",
         4 * M_PI * 36},
        {"<shape type='cylinder'><transform name='to_world'><scale x='2' y='2' z='5'/></transform></shape>", 20 * M_PI},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        struct scene scene;
        load(&scene, cases[i].text);
        assert_float_equal(scene.shapes[0]->area, (float)cases[i].area, 1e-5f * (float)cases[i].area);
        scene_fini(&scene);
    }
}

static void bad_transforms_are_errors(void **state) {
    (void)state;
    static const char *const cases[][2] = {
        {"<shape type='sphere'><transform name='to_world'><scale x='2'/></transform></shape>", "ellipsoid"},
        {"<shape type='cylinder'><transform name='to_world'><scale x='2'/></transform></shape>", "cylinder"},
        {"<shape type='cylinder'><point name='p1' value='0,0,0'/></shape>", "same point"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        struct scene scene;
        struct error error = {0};
        assert_int_equal(scene_from_text(&scene, cases[i][0], &error), STATUS_INVALID);
        if (!strstr(error.text, cases[i][1]) || !strstr(error.text, ".xml:1:")) fail_msg("%s", error.text);
    }
}

static void mesh_normals(void **state) {
    (void)state;
    char path[] = "/tmp/sconce_test_XXXXXX.obj", text[400];
    FILE *file = fdopen(mkstemps(path, 4), "w");
    fputs("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\n", file);
    fclose(file);
    static const struct {
        const char *more;
        float x;
        vec3 ng, n;
    } cases[] = {
        {"", .2f, {0, 0, 1}, {0, -.594217f, .804305f}},
        {"<boolean name='face_normals' value='true'/>", .2f, {0, 0, 1}, {0, 0, 1}},
        {"<boolean name='flip_normals' value='true'/>", .2f, {0, 0, -1}, {0, .594217f, -.804305f}},
        {"<transform name='to_world'><scale x='-1'/></transform>", -.2f, {0, 0, -1}, {0, .594217f, -.804305f}},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        struct scene scene;
        snprintf(text, sizeof text, "<shape type='obj'><string name='filename' value='%s'/>%s</shape>", path,
                 cases[i].more);
        load(&scene, text);
        struct ray ray = {{cases[i].x, .2f, 5}, {0, 0, -1}, 0, INFINITY};
        struct surface s;
        assert_true(scene_intersect(&scene, &ray, -1, &s));
        assert_vec3(s.ng, cases[i].ng.x, cases[i].ng.y, cases[i].ng.z);
        assert_vec3(s.shading.n, cases[i].n.x, cases[i].n.y, cases[i].n.z);
        scene_fini(&scene);
    }
    unlink(path);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(hits_are_mitsubas),
        cmocka_unit_test(samples_lie_on_the_surface),
        cmocka_unit_test(areas),
        cmocka_unit_test(bad_transforms_are_errors),
        cmocka_unit_test(mesh_normals),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
