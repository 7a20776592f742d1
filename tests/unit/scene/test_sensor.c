// Cameras: rays against Mitsuba 3's (noted from scalar_rgb 3.9.1), connections against rays, and the importance against
// its definition: particles from a plane of radiance 1 must give an image of 1 everywhere (docs/conventions.md).
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "../../scene_from_text.h"
#include "math/sampler.h"

#define FILM                                                                                                           \
    "<film type='hdrfilm'><integer name='width' value='200'/><integer name='height' "                                  \
    "value='100'/></film></sensor><shape type='rectangle'/>"
#define PERSPECTIVE(axis)                                                                                              \
    "<sensor type='perspective'><float name='fov' value='50'/><string name='fov_axis' value='" axis "'/>"              \
    "<float name='principal_point_offset_x' value='.1'/><float name='principal_point_offset_y' value='-.05'/>"         \
    "<float name='near_clip' value='.1'/>" FILM
#define PLACED "<transform name='to_world'><lookat origin='1,2,3' target='0.5,0.1,0.2' up='0,1,0'/></transform>"

static void load(struct scene *scene, const char *text) {
    struct error error = {0};
    if (scene_from_text(scene, text, &error) != STATUS_OK) fail_msg("%s: %s", text, error.text);
}

static void assert_near(vec3 a, vec3 b, float tolerance) {
    if (!(vec3_length(vec3_sub(a, b)) < tolerance))
        fail_msg("(%g %g %g) instead of (%g %g %g)", a.x, a.y, a.z, b.x, b.y, b.z);
}

static void rays_are_mitsubas(void **state) {
    (void)state;
    static const struct {
        const char *text;
        vec3 near, direction;
    } cases[] = {
        {PERSPECTIVE("x"), {0.0186523f, -0.00699461f, 0.1f}, {0.182929f, -0.0685982f, 0.98073f}},
        {PERSPECTIVE("y"), {0.0373046f, -0.0139892f, 0.1f}, {0.346554f, -0.129958f, 0.928984f}},
        {PERSPECTIVE("diagonal"), {0.0166831f, -0.00625617f, 0.1f}, {0.164245f, -0.0615917f, 0.984495f}},
        {PERSPECTIVE("smaller"), {0.0373046f, -0.0139892f, 0.1f}, {0.346554f, -0.129958f, 0.928984f}},
        {PERSPECTIVE("larger"), {0.0186523f, -0.00699461f, 0.1f}, {0.182929f, -0.0685982f, 0.98073f}},
        {"<sensor type='orthographic'><float name='near_clip' value='.1'/>" FILM, {0.6f, -0.2f, 0.1f}, {0, 0, 1}},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        struct scene scene;
        load(&scene, cases[i].text);
        struct ray ray;
        scene.sensor->type->sample_ray(scene.sensor, (vec2){.2f, .7f}, (vec2){.3f, .4f}, &ray);
        assert_near(ray.direction, cases[i].direction, 2e-6f);
        assert_near(vec3_mad(ray.direction, ray.t_min, ray.origin), cases[i].near, 1e-6f);
        scene_fini(&scene);
    }
}

static const char *const placed[] = {
    "<sensor type='perspective'><float name='fov' value='50'/><float name='principal_point_offset_x' "
    "value='.1'/>" PLACED FILM,
    "<sensor type='perspective'><string name='focal_length' value='35mm'/>" PLACED FILM,
    "<sensor type='thinlens'><float name='fov' value='50'/><float name='aperture_radius' value='0.2'/><float "
    "name='focus_distance' value='3'/>" PLACED FILM,
    "<sensor type='orthographic'><transform name='to_world'><scale value='2'/><lookat origin='1,2,3' "
    "target='0.5,0.1,0.2' up='0,1,0'/></transform>" FILM,
};

static void connections_invert_rays(void **state) {
    (void)state;
    for (size_t i = 0; i < sizeof placed / sizeof *placed; ++i) {
        struct scene scene;
        load(&scene, placed[i]);
        const struct sensor *sensor = scene.sensor;
        for (uint64_t k = 0; k < 1000; ++k) {
            struct sampler s = sampler_make(1, i, k);
            vec2 film = {0.01f + 0.98f * sampler_1d(&s), 0.01f + 0.98f * sampler_1d(&s)}, lens = sampler_2d(&s);
            struct ray ray;
            sensor->type->sample_ray(sensor, film, lens, &ray);
            struct sensor_sample sample;
            float t = 1 + 5 * sampler_1d(&s), pdf_position, pdf_direction;
            vec3 p = vec3_mad(ray.direction, t, ray.origin);
            assert_true(sensor->type->sample_connection(sensor, p, lens, &sample));
            assert_float_equal(sample.film.x, film.x, 2e-5);
            assert_float_equal(sample.film.y, film.y, 2e-5);
            assert_float_equal(sample.distance, t, 1e-5);
            assert_near(sample.direction, vec3_neg(ray.direction), 1e-5f);
            assert_near(sample.p, ray.origin, 1e-5f);
            sensor->type->pdf_ray(sensor, &ray, &pdf_position, &pdf_direction);
            float importance = pdf_position * pdf_direction / sample.cos_theta;
            if (strcmp(sensor->type->name, "orthographic") == 0) importance *= t * t;
            assert_float_equal(sample.importance, importance, 1e-4f * importance);
        }
        scene_fini(&scene);
    }
}

// Points uniform on a plane that fills the view, at a slant, of radiance 1: the film's integral is 1, and so is each
// half.
static void plane_of_radiance_one_gives_one(void **state) {
    (void)state;
    for (size_t i = 0; i < sizeof placed / sizeof *placed; ++i) {
        struct scene scene;
        load(&scene, placed[i]);
        const struct sensor *sensor = scene.sensor;
        vec3 n = vec3_normalize(vec3_make(0.2f, 0.5f, 1)), center = {0.5f, 0.1f, 0.2f};
        struct frame frame = frame_from_normal(n);
        float half = 6;
        double sums[5] = {0}, squares[5] = {0};
        int count = 1000000;
        for (int k = 0; k < count; ++k) {
            struct sampler s = sampler_make(2, i, (uint64_t)k);
            vec2 u = sampler_2d(&s), lens = sampler_2d(&s);
            vec3 p = vec3_add(center,
                              frame_world_from_local(&frame, vec3_make(half * (2 * u.x - 1), half * (2 * u.y - 1), 0)));
            struct sensor_sample sample;
            if (!sensor->type->sample_connection(sensor, p, lens, &sample)) continue;
            double cosine = fabs((double)vec3_dot(n, sample.direction)), area = 4 * (double)(half * half);
            double value =
                area * cosine *
                (double)(sample.importance * sample.cos_theta / (sample.distance * sample.distance * sample.pdf_area));
            int quarter = 1 + (sample.film.x >= 0.5f) + 2 * (sample.film.y >= 0.5f);
            sums[0] += value / count, squares[0] += value * value / count;
            sums[quarter] += value / count, squares[quarter] += value * value / count;
        }
        for (int q = 0; q < 5; ++q) {
            double expected = q ? 0.25 : 1, sigma = sqrt((squares[q] - sums[q] * sums[q]) / count);
            if (!(fabs(sums[q] - expected) < 4.5 * sigma && sigma < 0.02 * expected))
                fail_msg("%g instead of %g (sigma %g), part %d of %s", sums[q], expected, sigma, q, placed[i]);
        }
        scene_fini(&scene);
    }
}

static void depth_of_field_is_sharp_at_focus(void **state) {
    (void)state;
    struct scene scene;
    load(&scene, placed[2]);
    const struct sensor *sensor = scene.sensor;
    vec3 first = {0};
    for (int k = 0; k < 10; ++k) {
        struct ray ray, axis;
        sensor->type->sample_ray(sensor, (vec2){0.5f, 0.5f}, (vec2){0.5f, 0.5f}, &axis);
        sensor->type->sample_ray(sensor, (vec2){0.8f, 0.3f}, (vec2){0.1f * (float)k, 0.37f}, &ray);
        vec3 p = vec3_mad(ray.direction, 3 / vec3_dot(ray.direction, axis.direction), ray.origin);
        if (k == 0) first = p;
        assert_near(p, first, 1e-5f);
    }
    scene_fini(&scene);
}

static void uneven_scale_is_an_error(void **state) {
    (void)state;
    struct scene scene;
    struct error error = {0};
    assert_int_equal(
        scene_from_text(&scene, "<sensor type='perspective'><transform name='to_world'><scale x='2'/></transform>" FILM,
                        &error),
        STATUS_INVALID);
    assert_non_null(strstr(error.text, "camera"));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rays_are_mitsubas),
        cmocka_unit_test(connections_invert_rays),
        cmocka_unit_test(plane_of_radiance_one_gives_one),
        cmocka_unit_test(depth_of_field_is_sharp_at_focus),
        cmocka_unit_test(uneven_scale_is_an_error),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
