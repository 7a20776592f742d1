// The published networks on a synthetic lamp: what they learn, samples against density by chi-square from near, far and
// inside, the file, any number of threads. Prints its figures.
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <unistd.h>
#include <cmocka.h>

#include "../../chi_square.h"
#include "base/file.h"
#include "luminaire/paper.h"
#include "synthetic_lamp.h"

enum { BATCH = 256, VIEWS = 64 };

static void light_batch(const struct lamp *lamp, uint64_t stream, uint64_t step, struct line_sample *samples) {
    for (size_t i = 0; i < BATCH; i++) {
        struct sampler s = sampler_make(stream, step, i);
        vec3 p, w;
        samples[i] = (struct line_sample){.mass = lamp_line(lamp, &s, &p, &w) * LINE_MEASURE(lamp->proxy.radius)};
        store(samples[i].point, p);
        store(samples[i].w, w);
        rgb l = lamp_radiance(lamp, p, w);
        const float radiance[3] = {l.r, l.g, l.b};
        for (int c = 0; c < 3; c++) samples[i].target[c] = samples[i].mass * radiance[c];
    }
}

static void view_batch(const struct lamp *lamp, const struct paper *paper, uint64_t step, struct paper_view *views) {
    for (size_t i = 0; i < VIEWS; i++) {
        struct sampler s = sampler_make(31, step, i);
        vec3 out = warp_uniform_sphere(sampler_2d(&s));
        float u = sampler_1d(&s), distance = i % 8 == 0 ? cbrtf(u) : powf(12, u);
        vec3 at = vec3_mad(out, distance * lamp->proxy.radius, lamp_center(lamp));
        store(views[i].s, at);
        for (int pixel = 0; pixel < PAPER_PIXELS; pixel++) {
            rgb sum = {0, 0, 0};
            for (int k = 0; k < 4; k++) {
                vec2 u2 = sampler_2d(&s);
                float p[2] = {((float)(pixel % PAPER_SIDE) + u2.x) / PAPER_SIDE,
                              ((float)(pixel / PAPER_SIDE) + u2.y) / PAPER_SIDE},
                      d[3];
                paper_view_direction(paper, views[i].s, p, d);
                vec3 w = vec3_make(-d[0], -d[1], -d[2]);
                sum = rgb_add(sum, lamp_radiance(lamp, at, w));
            }
            store(views[i].radiance[pixel], vec3_make(sum.r / 4, sum.g / 4, sum.b / 4));
        }
    }
}

static struct paper *train(const struct lamp *lamp, size_t light_steps, size_t view_steps, int threads) {
    struct paper *paper;
    struct error error;
    double loss;
    assert_int_equal(paper_create(&paper, &lamp->proxy, &error), STATUS_OK);
    struct line_sample samples[BATCH];
    assert_int_equal(paper_train_begin(paper, PAPER_EVAL, BATCH, 1, &error), STATUS_OK);
    for (size_t step = 0; step < light_steps; step++) {
        light_batch(lamp, 5, step, samples);
        paper_train_lines(paper, PAPER_EVAL, samples, BATCH, threads, &loss);
    }
    paper_train_end(paper, PAPER_EVAL);
    struct paper_view *views = malloc(VIEWS * sizeof *views);
    assert_int_equal(paper_train_begin(paper, PAPER_SAMPLING, VIEWS, 1, &error), STATUS_OK);
    for (size_t step = 0; step < view_steps; step++) {
        view_batch(lamp, paper, step, views);
        paper_train_views(paper, views, VIEWS, threads, &loss);
    }
    paper_train_end(paper, PAPER_SAMPLING);
    free(views);
    return paper;
}

// Held-out error of log(1 + L) over the black image's.
static double light_error(const struct lamp *lamp, const struct paper *paper) {
    double error = 0, black = 0;
    struct line_sample samples[BATCH];
    for (uint64_t step = 0; step < 8; step++) {
        light_batch(lamp, 6, step, samples);
        for (size_t i = 0; i < BATCH; i++) {
            float l[1][3];
            paper_eval(paper, 1, (const float(*)[3])samples[i].point, (const float(*)[3])samples[i].w, l);
            for (int c = 0; c < 3; c++) {
                float y = log1pf(samples[i].target[c] / samples[i].mass);
                error += (double)(samples[i].mass * sqrf(log1pf(l[0][c]) - y));
                black += (double)(samples[i].mass * sqrf(y));
            }
        }
    }
    return error / black;
}

// Relative variance of L / p of light samples at s, L from the lamp itself.
static double sample_variance(const struct lamp *lamp, const struct paper *paper, vec3 at, bool uniform) {
    enum { N = 4096 };
    static float s[N][3], u[N][3], d[N][3], pdf[N];
    vec3 to = vec3_sub(lamp_center(lamp), at);
    float cosine = sqrtf(1 - sqrf(lamp->proxy.radius) / vec3_dot(to, to));
    struct frame frame = frame_from_normal(vec3_normalize(to));
    double mean = 0, square = 0;
    for (int i = 0; i < N; i++) {
        struct sampler random = sampler_make(9, 0, (uint64_t)i);
        store(s[i], at);
        for (int a = 0; a < 3; a++) u[i][a] = sampler_1d(&random);
    }
    paper_sample(paper, N, (const float(*)[3])s, (const float(*)[3])u, d, pdf);
    for (int i = 0; i < N; i++) {
        if (uniform) {
            store(d[i], frame_world_from_local(&frame, warp_uniform_cone((vec2){u[i][0], u[i][1]}, cosine)));
            pdf[i] = warp_uniform_cone_pdf(cosine);
        }
        rgb l = lamp_radiance(lamp, at, vec3_make(-d[i][0], -d[i][1], -d[i][2]));
        double x = (double)(l.r + l.g + l.b) / (double)pdf[i];
        mean += x / N;
        square += x * x / N;
    }
    return square / (mean * mean) - 1;
}

static void test_learns(void **state) {
    (void)state;
    struct lamp lamp = lamp_frosted();
    struct paper *paper = train(&lamp, 120, 100, 2);
    double error = light_error(&lamp, paper);
    vec3 at = vec3_add(lamp_center(&lamp), vec3_make(0.9f, -1.1f, 0.4f));
    double variance = sample_variance(&lamp, paper, at, false), uniform = sample_variance(&lamp, paper, at, true);
    printf("frosted: error of log(1 + L) %.3f of the black image's; a sample's variance %.2f, a uniform one's %.2f\n",
           error, variance, uniform);
    assert_true(error < 0.7);
    assert_true(variance < 0.8 * uniform);
    paper_destroy(paper);
}

// Chi-square over a grid on the sphere's cone (from within: on all directions) in (1 - cosine, turn).
static void test_samples_match_density(void **state) {
    (void)state;
    enum { SIDE = 16, INNER = 12, POINTS = SIDE * SIDE * INNER * INNER, N = 60000 };
    static float s[N][3], u[N][3], d[N][3], pdf[N], again[N];
    static const float distances[] = {0.5f, 1.02f, 1.3f, 2, 40};
    static const vec3 outs[] = {
        {0, -1, 0}, {0.48f, 0.6f, -0.64f}, {0, 1, 0}, {0.0006f, 0.9999998f, 0}, {0.6f, 0, 0.8f}};
    struct lamp lamp = lamp_frosted();
    struct paper *paper = train(&lamp, 0, 30, 2);
    const double level = chi_square_sidak(1e-3, 5);
    for (int k = 0; k < 5; k++) {
        const vec3 at = vec3_mad(outs[k], distances[k] * lamp.proxy.radius, lamp_center(&lamp));
        struct frame frame = frame_from_normal(vec3_neg(outs[k]));
        const float sin2 = 1 / sqrf(distances[k]), rim = sin2 < 1 ? sin2 / (1 + sqrtf(1 - sin2)) : 2;
        static struct chi_square_cell cells[SIDE * SIDE + 1];
        memset(cells, 0, sizeof cells);
        double integral = 0;
        for (int i = 0; i < POINTS; i++) {
            struct sampler random = sampler_make(1, (uint64_t)k, (uint64_t)i);
            vec2 jitter = sampler_2d(&random);
            int cell = i / (INNER * INNER), inner = i % (INNER * INNER);
            float h = rim * ((float)(cell / SIDE) + ((float)(inner / INNER) + jitter.x) / INNER) / SIDE;
            float turn = 2 * PI_F * ((float)(cell % SIDE) + ((float)(inner % INNER) + jitter.y) / INNER) / SIDE;
            float sine = sqrtf(h * (2 - h));
            store(s[i], at);
            store(d[i], frame_world_from_local(&frame, vec3_make(sine * cosf(turn), sine * sinf(turn), 1 - h)));
        }
        paper_pdf(paper, POINTS, (const float(*)[3])s, (const float(*)[3])d, pdf);
        for (int i = 0; i < POINTS; i++) {
            double share = (double)(pdf[i] * 2 * PI_F * rim) / POINTS;
            cells[i / (INNER * INNER)].expected += share * N;
            integral += share;
        }
        for (int i = 0; i < N; i++) {
            struct sampler random = sampler_make(11, (uint64_t)k, (uint64_t)i);
            vec2 u2 = sampler_2d(&random);
            store(s[i], at);
            u[i][0] = u2.x, u[i][1] = u2.y, u[i][2] = sampler_1d(&random);
        }
        paper_sample(paper, N, (const float(*)[3])s, (const float(*)[3])u, d, pdf);
        paper_pdf(paper, N, (const float(*)[3])s, (const float(*)[3])d, again);
        for (int i = 0; i < N; i++) {
            assert_true(pdf[i] > 0 && isfinite(pdf[i]) && fabsf(again[i] - pdf[i]) <= 1e-5f * pdf[i]);
            vec3 local = frame_local_from_world(&frame, vec3_make(d[i][0], d[i][1], d[i][2]));
            float across2 = sqrf(local.x) + sqrf(local.y);
            float h = (local.z > 0 ? across2 / (1 + local.z) : 1 - local.z) / rim;
            float turn = atan2f(local.y, local.x) / (2 * PI_F);
            int y = (int)(h * SIDE), x = (int)((turn < 0 ? turn + 1 : turn) * SIDE);
            y = y < SIDE ? y : SIDE - 1, x = x < SIDE ? x : SIDE - 1;
            cells[h > 1.001f ? SIDE * SIDE : y * SIDE + x].observed++;
        }
        struct chi_square result = chi_square_counts(cells, SIDE * SIDE + 1);
        char text[60];
        snprintf(text, sizeof text, "at %g radii", (double)distances[k]);
        printf("%s: integral of the density %.4f, p %.3f\n", text, integral, result.p);
        assert_true(fabs(integral - 1) < 0.015);
        assert_true(chi_square_passes(text, result, level));
    }
    paper_destroy(paper);
}

static struct luminaire *make_luminaire(const struct lamp *lamp, int threads) {
    const char *keys[] = {"bake.preset"}, *values[] = {"paper"};
    struct luminaire *luminaire;
    struct error error;
    assert_int_equal(luminaire_assemble_paper(&luminaire, &lamp->proxy, train(lamp, 2, 2, threads),
                                              (const float[3]){1, 2, 3}, keys, values, 1, &error),
                     STATUS_OK);
    return luminaire;
}

enum { PROBES = 100 };
struct answers {
    float radiance[PROBES][3], transmittance[PROBES][3], direction[PROBES][3], pdf[2][PROBES];
};

static struct answers ask(const struct luminaire *luminaire, const struct lamp *lamp) {
    struct answers answers = {0};
    float point[PROBES][3], w[PROBES][3], u[PROBES][3];
    for (int i = 0; i < PROBES; i++) {
        struct sampler s = sampler_make(77, 0, (uint64_t)i);
        vec3 p = vec3_scale(warp_uniform_sphere(sampler_2d(&s)), 1.5f * lamp->proxy.radius * sampler_1d(&s));
        store(point[i], vec3_add(p, lamp_center(lamp)));
        store(w[i], warp_uniform_sphere(sampler_2d(&s)));
        for (int a = 0; a < 3; a++) u[i][a] = sampler_1d(&s);
    }
    const float(*points)[3] = (const float(*)[3])point, (*ws)[3] = (const float(*)[3])w;
    luminaire_eval(luminaire, PROBES, points, ws, answers.radiance);
    luminaire_transmittance(luminaire, PROBES, points, ws, answers.transmittance);
    luminaire_sample(luminaire, PROBES, points, (const float(*)[3])u, answers.direction, answers.pdf[0]);
    luminaire_pdf(luminaire, PROBES, points, ws, answers.pdf[1]);
    return answers;
}

// The same file for any number of threads; read again it answers the same; damaged it is refused.
static void test_file(void **state) {
    (void)state;
    struct lamp lamp = lamp_frosted();
    struct luminaire *made = make_luminaire(&lamp, 1), *other = make_luminaire(&lamp, 3), *loaded;
    struct answers a = ask(made, &lamp), b = ask(other, &lamp);
    assert_memory_equal(&a, &b, sizeof a);
    char path[] = "/tmp/sconce_paper_XXXXXX";
    int file = mkstemp(path);
    assert_true(file >= 0);
    close(file);
    struct error error = {0};
    assert_int_equal(luminaire_save(made, path, &error), STATUS_OK);
    assert_int_equal(luminaire_load(&loaded, path, &error), STATUS_OK);
    b = ask(loaded, &lamp);
    assert_memory_equal(&a, &b, sizeof a);
    assert_string_equal(luminaire_metadata(loaded, "bake.preset"), "paper");
    luminaire_destroy(made);
    luminaire_destroy(other);
    luminaire_destroy(loaded);
    uint8_t *bytes;
    size_t length;
    assert_int_equal(file_read(path, &bytes, &length, &error), STATUS_OK);
    assert_true(length > 17000000 && length < 17100000);
    assert_int_equal(luminaire_parse(&loaded, "cut", bytes, length - 4, &error), STATUS_INVALID);
    memset(bytes + length / 2, 0xff, 8); // a NaN
    assert_int_equal(luminaire_parse(&loaded, "nan", bytes, length, &error), STATUS_INVALID);
    assert_non_null(strstr(error.text, "finite"));
    free(bytes);
    unlink(path);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_learns),
        cmocka_unit_test(test_samples_match_density),
        cmocka_unit_test(test_file),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
