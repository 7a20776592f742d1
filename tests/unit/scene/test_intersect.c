// Rays: robustness against brute force in double precision, rays that leave surfaces, visibility through masks, lamps'
// kept geometry, absorption, and the symmetry of corrected scattering.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "../../scene_from_text.h"
#include "math/sampler.h"
#include "math/warp.h"
#include "scene/scene_embree.h"

static void load(struct scene *scene, const char *text) {
    struct error error = {0};
    if (scene_from_text(scene, text, &error) != STATUS_OK) fail_msg("%s: %s", text, error.text);
}

// A sphere of radius 1e-3 seen from 1000 away: the share of hits in its silhouette and the hit distance.
static void distant_small_spheres_keep_their_shape(void **state) {
    (void)state;
    struct scene scene;
    load(&scene,
         "<shape type='sphere'><float name='radius' value='0.001'/><point name='center' value='600,0,800'/></shape>");
    struct frame frame = frame_from_normal(vec3_make(0.6f, 0, 0.8f));
    int wrong = 0;
    for (uint64_t k = 0; k < 2000; ++k) {
        struct sampler s = sampler_make(1, 0, k);
        vec2 u = sampler_2d(&s);
        vec3 aim = {0.003f * (u.x - 0.5f), 0.003f * (u.y - 0.5f), 0};
        vec3 target = vec3_add(vec3_make(600, 0, 800), frame_world_from_local(&frame, aim));
        vec3 origin = vec3_mad(frame.n, -999.0f, target); // parallel rays from about 1 .. 2000 away
        struct ray ray = {origin, frame.n, 0, INFINITY};
        double o[3] = {(double)origin.x - 600, (double)origin.y, (double)origin.z - 800};
        double d[3] = {(double)frame.n.x, (double)frame.n.y, (double)frame.n.z};
        double b = o[0] * d[0] + o[1] * d[1] + o[2] * d[2], gap2 = 0, dd = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
        for (int i = 0; i < 3; ++i) gap2 += (o[i] - b / dd * d[i]) * (o[i] - b / dd * d[i]);
        struct surface hit;
        bool expected = gap2 < 1e-6, found = scene_intersect(&scene, &ray, -1, &hit);
        if (fabs(sqrt(gap2) - 0.001) > 1e-8) wrong += expected != found;
    }
    assert_int_equal(wrong, 0);
    scene_fini(&scene);
}

// From every shape, far from the origin too: a ray that leaves a convex shape does not meet it again, one that goes in
// meets it exactly once more, on its inner side.
static void spawned_rays_do_not_hit_their_start(void **state) {
    (void)state;
    static const char *const shapes[] = {"<shape type='sphere'>", "<shape type='cube'>"};
    static const char *const places[] = {
        "<scale value='1'/>", "<scale value='0.01'/><translate x='1' y='0.001' z='-3'/>",
        "<rotate x='1' y='2' angle='33'/><scale value='50'/><translate x='1000' y='3' z='-200'/>"};
    for (int shape = 0; shape < 2; ++shape) {
        for (int place = 0; place < 3; ++place) {
            char text[400];
            snprintf(text, sizeof text, "%s<transform name='to_world'>%s</transform></shape>", shapes[shape],
                     places[place]);
            struct scene scene;
            load(&scene, text);
            vec3 center = scene.bounds.center;
            int again = 0, lost = 0;
            for (uint64_t k = 0; k < 20000; ++k) {
                struct sampler s = sampler_make(2, 0, k);
                vec3 out = warp_uniform_sphere(sampler_2d(&s));
                struct ray ray = {vec3_mad(out, 3 * scene.bounds.radius, center), vec3_neg(out), 0, INFINITY};
                struct surface start, hit;
                assert_true(scene_intersect(&scene, &ray, -1, &start));
                struct frame frame = frame_from_normal(start.ng);
                vec3 w = frame_world_from_local(&frame, warp_cosine_hemisphere(sampler_2d(&s)));
                ray = surface_spawn_ray(&start, w);
                again += scene_intersect(&scene, &ray, -1, &hit);
                ray = surface_spawn_ray(&start, vec3_neg(w));
                lost += !scene_intersect(&scene, &ray, -1, &hit) || vec3_dot(hit.ng, w) > 0;
            }
            if (again + lost > 2) fail_msg("%d rays hit their start, %d are lost, on %s", again, lost, text);
            scene_fini(&scene);
        }
    }
}

#define MASK "<bsdf type='mask'><float name='opacity' value='0.75'/><bsdf type='diffuse'/></bsdf>"

static void visibility_multiplies_masks(void **state) {
    (void)state;
    struct scene scene;
    load(&scene,
         "<shape type='rectangle'>" MASK "</shape><shape type='sphere'><point name='center' z='3'/>" MASK "</shape>"
         "<shape type='rectangle'><transform name='to_world'><translate x='10'/></transform></shape>");
    struct ray through = {{0.1f, 0.2f, -1}, {0, 0, 1}, 0, INFINITY};
    assert_float_equal(scene_visibility(&scene, &through, -1).g, 1.0 / 64, 1e-6);
    through.t_max = 2;
    assert_float_equal(scene_visibility(&scene, &through, -1).g, 0.25, 1e-6);
    through.t_max = 0.5f;
    assert_float_equal(scene_visibility(&scene, &through, -1).g, 1, 0);
    through.origin.x = 10;
    through.t_max = 2;
    assert_float_equal(scene_visibility(&scene, &through, -1).g, 0, 0);
    scene_fini(&scene);
}

static void kept_geometry_is_ignored_by_instance(void **state) {
    (void)state;
    struct scene scene;
    load(&scene, "<shape type='rectangle'/><shape type='sphere'><point name='center' z='3'/></shape>"
                 "<shape type='rectangle'><transform name='to_world'><translate z='6'/></transform></shape>");
    scene.shapes[0]->luminaire = 40;
    scene.shapes[1]->luminaire = 71;
    embree_scene_destroy(scene.embree);
    struct error error = {0};
    assert_int_equal(embree_scene_create(&scene.embree, &scene, 1, &error), STATUS_OK);
    struct ray ray = {{0.1f, 0.2f, -1}, {0, 0, 1}, 0, INFINITY};
    struct surface hit;
    static const struct {
        int ignore;
        uint32_t shape;
        float start;
    } cases[] = {{-1, 0, -1}, {71, 0, -1}, {40, 1, -1}, {71, 2, 1}, {5, 0, -1}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        ray.origin.z = cases[i].start;
        assert_true(scene_intersect(&scene, &ray, cases[i].ignore, &hit));
        assert_int_equal(hit.shape->index, cases[i].shape);
    }
    ray.origin.z = 1;
    ray.t_max = 4.5f;
    assert_float_equal(scene_visibility(&scene, &ray, 71).g, 1, 0);
    assert_float_equal(scene_visibility(&scene, &ray, 40).g, 0, 0);
    scene_fini(&scene);
}

static void absorption_follows_the_sides(void **state) {
    (void)state;
    struct scene scene;
    load(&scene, "<shape type='sphere'><bsdf type='dielectric'/><medium name='interior' type='homogeneous'><rgb "
                 "name='sigma_a' value='0.5 0 2'/></medium></shape>");
    struct ray ray = {{0, 0, -3}, {0, 0, 1}, 0, INFINITY};
    struct surface in, out;
    assert_true(scene_intersect(&scene, &ray, -1, &in));
    ray = surface_spawn_ray(&in, ray.direction);
    assert_true(scene_intersect(&scene, &ray, -1, &out));
    rgb inside = segment_absorption(&in, &out, ray.direction, out.t);
    assert_float_equal(inside.r, exp(-1), 1e-4);
    assert_float_equal(inside.g, 1, 0);
    assert_float_equal(inside.b, exp(-4), 1e-4);
    assert_float_equal(segment_absorption(NULL, &in, vec3_make(0, 0, 1), 2).r, 1, 0);
    assert_float_equal(segment_absorption(NULL, &out, vec3_make(0, 0, 1), 2).r, exp(-1), 1e-4);
    assert_float_equal(segment_absorption(&out, NULL, vec3_make(0, 0, 1), INFINITY).r, 1, 0);
    scene_fini(&scene);
}

// Reciprocal materials: eval(wi, wo) / |wo.ng| for importance equals eval(wo, wi) / |wi.ns| ... of radiance, which is
// what makes light and camera paths integrate the same function.
static void importance_is_adjoint(void **state) {
    (void)state;
    struct scene scene;
    load(&scene, "<shape type='sphere'/>");
    struct ray ray = {{0.3f, 0.1f, -3}, {0, 0, 1}, 0, INFINITY};
    struct surface s;
    assert_true(scene_intersect(&scene, &ray, -1, &s));
    s.shading = frame_from_normal(vec3_normalize(vec3_add(s.ng, vec3_make(0.3f, -0.2f, 0.1f))));
    int compared = 0;
    for (uint64_t k = 0; k < 1000; ++k) {
        struct sampler sampler = sampler_make(3, 0, k);
        vec3 to_light = warp_uniform_sphere(sampler_2d(&sampler)),
             to_camera = warp_uniform_sphere(sampler_2d(&sampler));
        float radiance = surface_eval_bsdf(&s, to_camera, to_light, TRANSPORT_RADIANCE).g;
        float importance = surface_eval_bsdf(&s, to_light, to_camera, TRANSPORT_IMPORTANCE).g;
        // Measurement: flux density L |to_light.ng| times importance = radiance |to_light.ns| per camera-side
        // |to_camera.ng|.
        float a = importance * fabsf(vec3_dot(to_light, s.ng)), b = radiance * fabsf(vec3_dot(to_camera, s.ng));
        assert_float_equal(a, b, 1e-5);
        compared += a > 0;
        bool agree = vec3_dot(to_light, s.ng) * vec3_dot(to_light, s.shading.n) > 0 &&
                     vec3_dot(to_camera, s.ng) * vec3_dot(to_camera, s.shading.n) > 0;
        if (!agree) assert_true(a == 0 && b == 0);
    }
    assert_in_range(compared, 100, 900);
    scene_fini(&scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(distant_small_spheres_keep_their_shape),
        cmocka_unit_test(spawned_rays_do_not_hit_their_start),
        cmocka_unit_test(visibility_multiplies_masks),
        cmocka_unit_test(kept_geometry_is_ignored_by_instance),
        cmocka_unit_test(absorption_follows_the_sides),
        cmocka_unit_test(importance_is_adjoint),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
