// Light fields learned from synthetic lamps whose radiance is known in closed form: flux and fluence, from camera lines
// and from particles. Prints its figures.
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <cmocka.h>

#include "synthetic_lamp.h"

enum { BATCH = 4096 };

struct result {
    double flux_error, fluence_error;
};

typedef void eval_function(const void *object, size_t n, const float (*point)[3], const float (*w)[3],
                           float (*radiance)[3]);

static void eval_field(const void *object, size_t n, const float (*point)[3], const float (*w)[3],
                       float (*radiance)[3]) {
    light_field_eval(object, n, point, w, radiance);
}

static void eval_luminaire(const void *object, size_t n, const float (*point)[3], const float (*w)[3],
                           float (*radiance)[3]) {
    luminaire_eval(object, n, point, w, radiance);
}

enum { LINES = 512 };

struct comparison { // of model and lamp over weighted lines
    const struct lamp *lamp;
    eval_function *eval;
    const void *object;
    float point[LINES][3], w[LINES][3];
    double weight[LINES], model, exact;
    size_t count;
};

static void comparison_flush(struct comparison *c) {
    static float radiance[LINES][3];
    if (c->count == 0) return;
    c->eval(c->object, c->count, (const float(*)[3])c->point, (const float(*)[3])c->w, radiance);
    for (size_t i = 0; i < c->count; i++) {
        rgb l = lamp_radiance(c->lamp, vec3_make(c->point[i][0], c->point[i][1], c->point[i][2]),
                              vec3_make(c->w[i][0], c->w[i][1], c->w[i][2]));
        c->model += c->weight[i] * (double)(radiance[i][0] + radiance[i][1] + radiance[i][2]);
        c->exact += c->weight[i] * (double)(l.r + l.g + l.b);
    }
    c->count = 0;
}

static void comparison_add(struct comparison *c, vec3 p, vec3 w, double weight) {
    store(c->point[c->count], p);
    store(c->w[c->count], w);
    c->weight[c->count++] = weight;
    if (c->count == LINES) comparison_flush(c);
}

// Cones about the balls and, 0.3 of all, the bounding sphere's, seen from `at`.
static vec3 aim(const struct lamp *lamp, vec3 at, struct sampler *s, double *pdf) {
    vec3 center = lamp_center(lamp);
    bool all = sampler_1d(s) < 0.3f;
    int ball = (int)(sampler_1d(s) * (float)lamp->count);
    vec3 to = vec3_sub(all ? center : lamp->balls[ball].center, at);
    float radius = all ? lamp->proxy.radius : 1.5f * lamp->balls[ball].radius;
    struct frame frame = frame_from_normal(vec3_normalize(to));
    vec3 d =
        frame_world_from_local(&frame, warp_uniform_cone(sampler_2d(s), sqrtf(1 - sqrf(radius) / vec3_dot(to, to))));
    *pdf = 0;
    for (int j = -1; j < lamp->count; j++) {
        vec3 axis = vec3_sub(j < 0 ? center : lamp->balls[j].center, at);
        float r = j < 0 ? lamp->proxy.radius : 1.5f * lamp->balls[j].radius;
        float cosine = sqrtf(1 - sqrf(r) / vec3_dot(axis, axis));
        if (vec3_dot(d, vec3_normalize(axis)) >= cosine)
            *pdf += (double)((j < 0 ? 0.3f : 0.7f / (float)lamp->count) / (2 * PI_F * (1 - cosine)));
    }
    return d;
}

// Relative error of the flux, and rms relative error of the fluence (integral of L over directions) at 40 points at 1.5
// to 5 radii, each with the same directions for model and lamp.
static struct result measure(const struct lamp *lamp, eval_function *eval, const void *object) {
    static struct comparison c;
    c = (struct comparison){.lamp = lamp, .eval = eval, .object = object};
    for (int i = 0; i < 400000; i++) {
        struct sampler s = sampler_make(7, 0, (uint64_t)i);
        vec3 p, w;
        double mass = (double)lamp_line(lamp, &s, &p, &w);
        comparison_add(&c, p, w, mass);
    }
    comparison_flush(&c);
    double flux_error = c.model / c.exact - 1, sum2 = 0;
    for (int k = 0; k < 40; k++) {
        struct sampler s = sampler_make(8, 0, (uint64_t)k);
        vec3 out = warp_uniform_sphere(sampler_2d(&s));
        vec3 at = vec3_mad(out, lamp->proxy.radius * (1.5f + 3.5f * sampler_1d(&s)), lamp_center(lamp));
        c.model = c.exact = 0;
        for (int i = 0; i < 8000; i++) {
            double pdf;
            vec3 d = aim(lamp, at, &s, &pdf);
            comparison_add(&c, at, vec3_neg(d), 1 / pdf);
        }
        comparison_flush(&c);
        sum2 += (c.model / c.exact - 1) * (c.model / c.exact - 1);
    }
    return (struct result){flux_error, sqrt(sum2 / 40)};
}

static void learn(const char *name, const struct lamp *lamp, struct light_field_options options, enum lamp_data data,
                  size_t steps, double flux_tolerance, double fluence_tolerance) {
    double flux[3];
    lamp_flux(lamp, flux);
    float unit = (float)((flux[0] + flux[1] + flux[2]) / 3) / LINE_MEASURE(lamp->proxy.radius);
    options.proxy = lamp->proxy;
    options.radiance_unit = unit;
    options.log2_entries = 16;
    options.steps = steps;
    options.seed = 1;
    struct light_field *field;
    struct error error;
    assert_int_equal(light_field_create(&field, &options, &error), STATUS_OK);
    struct line_sample *samples = malloc(BATCH * sizeof *samples);
    double training = 0;
    for (size_t step = 0; step < steps; step++) {
        lamp_batch(lamp, data, unit, step, BATCH, samples);
        double start = clock_cpu_s();
        light_field_train(field, samples, BATCH, 1, NULL);
        training += clock_cpu_s() - start;
    }
    free(samples);
    struct result trained = measure(lamp, eval_field, field);
    float total[3] = {(float)flux[0], (float)flux[1], (float)flux[2]};
    struct luminaire *luminaire;
    assert_int_equal(luminaire_assemble(&luminaire, &lamp->proxy, field, NULL, NULL, total, NULL, NULL, 0, &error),
                     STATUS_OK);
    struct result baked = measure(lamp, eval_luminaire, luminaire);
    printf("%s: flux %+.2f %%, fluence rms %.2f %%; with 8-bit tables %+.2f %%, %.2f %%; %.0f k samples/s, %.2f MB\n",
           name, 100 * trained.flux_error, 100 * trained.fluence_error, 100 * baked.flux_error,
           100 * baked.fluence_error, (double)(BATCH * steps) / training / 1e3,
           (double)luminaire_bytes(luminaire) / 1e6);
    luminaire_destroy(luminaire);
    assert_true(fabs(baked.flux_error) < flux_tolerance);
    assert_true(baked.fluence_error < fluence_tolerance);
}

static struct light_field_options clear_options(const struct lamp *lamp, float (*anchors)[3]) {
    for (int i = 0; i < lamp->count; i++) store(anchors[i], lamp->balls[i].center);
    return (struct light_field_options){.anchors = (const float(*)[3])anchors,
                                        .anchor_count = (size_t)lamp->count,
                                        .anchor_radius = 0.1f * lamp->proxy.radius,
                                        .use_grid4 = true};
}

static const float frosted_shells[] = {0.7f};

static void test_clear_from_camera_lines(void **state) {
    (void)state;
    struct lamp lamp = lamp_clear();
    float anchors[12][3];
    learn("clear lamp, camera lines", &lamp, clear_options(&lamp, anchors), DATA_CAMERA, 500, 0.02, 0.04);
}

static void test_clear_from_particles(void **state) {
    (void)state;
    struct lamp lamp = lamp_clear();
    float anchors[12][3];
    learn("clear lamp, particles", &lamp, clear_options(&lamp, anchors), DATA_PARTICLES, 500, 0.03, 0.05);
}

static void test_frosted_from_camera_lines(void **state) {
    (void)state;
    struct lamp lamp = lamp_frosted();
    struct light_field_options options = {.shell_radii = frosted_shells, .shell_count = 1, .use_grid4 = true};
    learn("frosted lamp, camera lines", &lamp, options, DATA_CAMERA, 500, 0.02, 0.03);
}

static void test_frosted_from_particles(void **state) {
    (void)state;
    struct lamp lamp = lamp_frosted();
    struct light_field_options options = {.shell_radii = frosted_shells, .shell_count = 1, .use_grid4 = true};
    learn("frosted lamp, particles", &lamp, options, DATA_PARTICLES, 500, 0.02, 0.03);
}

static void test_grid4_alone(void **state) {
    (void)state;
    struct lamp lamp = lamp_frosted();
    learn("frosted lamp, grid4 alone", &lamp, (struct light_field_options){.use_grid4 = true}, DATA_CAMERA, 500, 0.03,
          0.05);
}

// A lamp of radiance 1 everywhere, traced so noisily that a line in ten brings 10 and the others nothing. The
// likelihood finds 1; of the logarithm's squares the minimum is at log(1 + L) = log(11) / 10.
static double constant_learned(enum light_loss loss) {
    struct lamp lamp = lamp_frosted();
    const struct light_field_options options = {.proxy = lamp.proxy,
                                                .use_grid4 = true,
                                                .radiance_unit = 1,
                                                .log2_entries = 10,
                                                .steps = 300,
                                                .seed = 1,
                                                .loss = loss};
    struct light_field *field;
    struct error error;
    assert_int_equal(light_field_create(&field, &options, &error), STATUS_OK);
    static struct line_sample samples[BATCH];
    static float point[BATCH][3], w[BATCH][3], radiance[BATCH][3];
    for (size_t step = 0; step < options.steps; step++) {
        for (size_t i = 0; i < BATCH; i++) {
            struct sampler s = sampler_make(3, step, i);
            vec3 p, d;
            lamp_line(&lamp, &s, &p, &d);
            store(samples[i].point, p);
            store(samples[i].w, d);
            store(point[i], p);
            store(w[i], d);
            const float y = sampler_1d(&s) < 0.1f ? 10 : 0;
            samples[i].mass = 1.0f / BATCH;
            for (int c = 0; c < 3; c++) samples[i].target[c] = y / BATCH;
        }
        light_field_train(field, samples, BATCH, 1, NULL);
    }
    double sum = 0, lit = 0; // lines beside the proxy are dark
    light_field_eval(field, BATCH, (const float(*)[3])point, (const float(*)[3])w, radiance);
    for (size_t i = 0; i < BATCH; i++) sum += (double)radiance[i][1], lit += radiance[i][1] > 0;
    light_field_destroy(field);
    return sum / lit;
}

static void test_losses_under_noise(void **state) {
    (void)state;
    const double likelihood = constant_learned(LIGHT_LOSS_LIKELIHOOD),
                 logarithm = constant_learned(LIGHT_LOSS_LOGARITHM);
    printf("constant 1 under noise: %.3f by likelihood, %.3f by the logarithm\n", likelihood, logarithm);
    assert_true(fabs(likelihood - 1) < 0.05);
    assert_true(fabs(logarithm - expm1(0.1 * log(11))) < 0.05);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_clear_from_camera_lines),   cmocka_unit_test(test_clear_from_particles),
        cmocka_unit_test(test_frosted_from_camera_lines), cmocka_unit_test(test_frosted_from_particles),
        cmocka_unit_test(test_losses_under_noise),        cmocka_unit_test(test_grid4_alone),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
