// The sampling density of synthetic lamps: samples against density by chi-square from near, far and inside; integral 1;
// positive over the cone of the bounding sphere; relative variance of L / p. Prints its figures.
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <cmocka.h>

#include "../../chi_square.h"
#include "luminaire/sampling_kernel.h"
#include "synthetic_lamp.h"

enum { EXITS = 400000 };

static struct sampling_density *build(const struct lamp *lamp, bool anchors, size_t count, int threads) {
    struct line_exit *exits = malloc((count + 1) * sizeof *exits);
    size_t used = 0;
    for (size_t i = 0; i < count; i++) {
        struct sampler s = sampler_make(3, 0, i);
        used += lamp_exit(lamp, &s, &exits[used]);
    }
    float centers[12][3];
    for (int i = 0; i < lamp->count; i++) store(centers[i], lamp->balls[i].center);
    struct sampling_density *density;
    struct error error;
    assert_int_equal(sampling_density_build(&density, &lamp->proxy, (const float(*)[3])centers,
                                            anchors ? (size_t)lamp->count : 0, exits, used, 5, threads, &error),
                     STATUS_OK);
    free(exits);
    return density;
}

struct viewpoint {
    const struct sampling_density *density;
    vec3 s;
};

static bool viewpoint_sample(void *user, uint64_t index, vec3 *w) {
    const struct viewpoint *view = user;
    struct sampler s = sampler_make(11, 0, index);
    vec2 u = sampler_2d(&s);
    float pdf;
    sampling_sample(view->density, view->s, vec3_make(u.x, u.y, sampler_1d(&s)), w, &pdf);
    assert_true(pdf > 0 && isfinite(pdf));
    float again = sampling_pdf(view->density, view->s, *w);
    assert_true(fabsf(again - pdf) <= 1e-5f * pdf);
    return true;
}

static double viewpoint_pdf(void *user, vec3 w) {
    const struct viewpoint *view = user;
    return (double)sampling_pdf(view->density, view->s, w);
}

// For a narrow cone the sphere's grid is too coarse: chi-square over a grid on the cone instead, in (1 - cosine, turn).
static struct chi_square test_cone(struct viewpoint *view, size_t samples) {
    enum { ROWS = 24, COLUMNS = 24, INNER = 24 };
    const struct sampling_density *density = view->density;
    vec3 to = vec3_sub(density->center, view->s);
    float sin2 = sqrf(density->radius) / vec3_dot(to, to), rim = sin2 / (1 + sqrtf(1 - sin2));
    struct frame frame = frame_from_normal(vec3_normalize(to));
    static struct chi_square_cell cells[ROWS * COLUMNS + 1];
    memset(cells, 0, sizeof cells);
    double integral = 0;
    for (int y = 0; y < ROWS; y++)
        for (int x = 0; x < COLUMNS; x++)
            for (int k = 0; k < INNER * INNER; k++) {
                struct sampler s = sampler_make(1, (uint64_t)(y * COLUMNS + x), 0);
                float shift = sampler_1d(&s);
                float h = rim * ((float)y + ((float)(k / INNER) + shift) / INNER) / ROWS;
                float turn = 2 * PI_F * ((float)x + ((float)(k % INNER) + 0.5f) / INNER) / COLUMNS;
                float sine = sqrtf(h * (2 - h));
                vec3 w = frame_world_from_local(&frame, vec3_make(sine * cosf(turn), sine * sinf(turn), 1 - h));
                double share = viewpoint_pdf(view, w) * 2 * M_PI * (double)rim / (ROWS * COLUMNS * INNER * INNER);
                cells[y * COLUMNS + x].expected += share * (double)samples;
                integral += share;
            }
    for (size_t i = 0; i < samples; i++) {
        vec3 w;
        viewpoint_sample(view, i, &w);
        vec3 local = frame_local_from_world(&frame, w);
        double h = ((double)local.x * (double)local.x + (double)local.y * (double)local.y) / (1 + (double)local.z) /
                   (double)rim;
        double turn = atan2((double)local.y, (double)local.x) / (2 * M_PI);
        int y = (int)(h * ROWS), x = (int)((turn < 0 ? turn + 1 : turn) * COLUMNS);
        cells[h > 1.001 ? ROWS * COLUMNS : (y < ROWS ? y : ROWS - 1) * COLUMNS + (x < COLUMNS ? x : COLUMNS - 1)]
            .observed++;
    }
    struct chi_square result = chi_square_counts(cells, ROWS * COLUMNS + 1);
    result.integral = integral;
    return result;
}

static void check_lamp(const char *name, const struct lamp *lamp, bool anchors, size_t exits) {
    struct sampling_density *density = build(lamp, anchors, exits, 1);
    static const float distances[] = {0, 0.3f, 0.9f, 1.02f, 1.6f, 6, 40};
    double level = chi_square_sidak(1e-3, 4 * sizeof distances / sizeof *distances);
    for (size_t k = 0; k < sizeof distances / sizeof *distances; k++)
        for (int turn = 0; turn < 2; turn++) {
            struct sampler random = sampler_make(21, k, (uint64_t)turn);
            vec3 out = warp_uniform_sphere(sampler_2d(&random));
            struct viewpoint view = {density, vec3_mad(out, distances[k] * lamp->proxy.radius, density->center)};
            char text[100];
            snprintf(text, sizeof text, "%s at %g radii", name, (double)distances[k]);
            bool inside = distances[k] <= 1;
            struct chi_square result;
            if (inside) {
                struct chi_square_direction test = {.sample = viewpoint_sample,
                                                    .pdf_sa = viewpoint_pdf,
                                                    .user = &view,
                                                    .samples = 60000,
                                                    .rows = 20,
                                                    .columns = 40};
                result = chi_square_test_directions(&test);
            } else
                result = test_cone(&view, 60000);
            bool sharp = anchors && lamp->count > 1; // the quadrature resolves the small cones of bulbs only roughly
            assert_true(fabs(result.integral - 1) < (sharp ? 0.05 : 0.01));
            if (!sharp) assert_true(chi_square_passes(text, result, level));
        }
    sampling_density_destroy(density);
}

static void test_map_matches_density(void **state) {
    (void)state;
    struct lamp clear = lamp_clear(), frosted = lamp_frosted();
    check_lamp("clear, map only", &clear, false, EXITS);
    check_lamp("frosted, map only", &frosted, false, EXITS);
    check_lamp("frosted, one anchor", &frosted, true, EXITS);
    check_lamp("no data", &frosted, false, 0);
    check_lamp("clear, anchors", &clear, true, EXITS);
}

// Samples of the anchors' cones against the density, on a small grid about one bulb where both are smooth enough.
static void test_anchors_match_density(void **state) {
    (void)state;
    struct lamp lamp = lamp_clear();
    struct sampling_density *density = build(&lamp, true, EXITS, 1);
    double level = chi_square_sidak(1e-3, 12);
    for (int k = 0; k < 12; k++) {
        struct sampler random = sampler_make(31, (uint64_t)k, 0);
        vec3 out = warp_uniform_sphere(sampler_2d(&random));
        float far = k < 4 ? 0.5f * sampler_1d(&random) : k < 8 ? 1.3f : 7;
        struct viewpoint view = {density, vec3_mad(out, far * lamp.proxy.radius, density->center)};
        vec3 to = vec3_sub(lamp.balls[k % 8].center, view.s);
        float span = asinf(fminf(1, 2 * lamp.balls[0].radius / vec3_length(to)));
        struct frame frame = frame_from_normal(vec3_normalize(to));
        enum { RINGS = 12, TURNS = 8, INNER = 200 };
        struct chi_square_cell cells[RINGS * TURNS + 1];
        memset(cells, 0, sizeof cells);
        const size_t samples = 200000;
        float rim = 2 * sqrf(sinf(0.5f * span));
        double sum = 0;
        for (int c = 0; c < RINGS * TURNS; c++)
            for (int i = 0; i < INNER; i++) {
                float h = rim * ((float)(c / TURNS) + ((float)i + 0.5f) / INNER) / RINGS;
                float turn = 2 * PI_F * ((float)(c % TURNS) + sampler_1d(&random)) / TURNS, sine = sqrtf(h * (2 - h));
                vec3 w = frame_world_from_local(&frame, vec3_make(sine * cosf(turn), sine * sinf(turn), 1 - h));
                double share = viewpoint_pdf(&view, w) * 2 * M_PI * (double)rim / (RINGS * TURNS * INNER);
                cells[c].expected += share * (double)samples;
                sum += share;
            }
        cells[RINGS * TURNS].expected = (1 - sum) * (double)samples;
        for (size_t i = 0; i < samples; i++) {
            vec3 w;
            viewpoint_sample(&view, i, &w);
            vec3 local = frame_local_from_world(&frame, w);
            double h = ((double)local.x * (double)local.x + (double)local.y * (double)local.y) / (1 + (double)local.z) /
                       (double)rim;
            double turn = atan2((double)local.y, (double)local.x) / (2 * M_PI);
            int x = (int)((turn < 0 ? turn + 1 : turn) * TURNS);
            if (local.z <= 0 || h >= 1)
                cells[RINGS * TURNS].observed++;
            else
                cells[(int)(h * RINGS) * TURNS + (x < TURNS ? x : TURNS - 1)].observed++;
        }
        assert_true(chi_square_passes("cones about a bulb", chi_square_counts(cells, RINGS * TURNS + 1), level));
    }
    sampling_density_destroy(density);
}

// The kernels against the scalar mixture, over points from the middle to far away: the same samples, but for the few
// that rounding puts into the next pixel or cone, and the same densities of any direction.
static void check_kernel(const struct sampling_kernel *kernel, const struct sampling_density *density) {
    enum { BLOCKS = 4000 };
    int directions_off = 0, densities_off = 0;
    for (uint64_t block = 0; block < BLOCKS; block++) {
        struct sampling_lanes lanes, again;
        for (int i = 0; i < SAMPLING_LANES; i++) {
            struct sampler random = sampler_make(51, block, (uint64_t)i);
            float far = i % 4 == 0 ? sampler_1d(&random) : powf(20, sampler_1d(&random));
            vec3 out = warp_uniform_sphere(sampler_2d(&random));
            vec3 s = vec3_mad(out, far * density->radius, density->center);
            lanes.s[0][i] = s.x, lanes.s[1][i] = s.y, lanes.s[2][i] = s.z;
            for (int c = 0; c < 3; c++) lanes.u[c][i] = sampler_1d(&random);
        }
        kernel->sample(density, &lanes);
        again = lanes;
        kernel->pdf(density, &again);
        for (int i = 0; i < SAMPLING_LANES; i++) {
            vec3 s = {lanes.s[0][i], lanes.s[1][i], lanes.s[2][i]}, u = {lanes.u[0][i], lanes.u[1][i], lanes.u[2][i]};
            vec3 w = {lanes.direction[0][i], lanes.direction[1][i], lanes.direction[2][i]}, scalar;
            float pdf;
            assert_true(lanes.pdf_sa[i] > 0 && isfinite(lanes.pdf_sa[i]));
            assert_true(fabsf(again.pdf_sa[i] - lanes.pdf_sa[i]) <= 1e-5f * lanes.pdf_sa[i]);
            sampling_sample(density, s, u, &scalar, &pdf);
            directions_off += !(vec3_length(vec3_sub(scalar, w)) < 2e-5f);
            pdf = sampling_pdf(density, s, w);
            densities_off += !(fabsf(pdf - lanes.pdf_sa[i]) < 1e-3f * pdf);
        }
    }
    printf("%d directions and %d densities of %d differ from the scalar ones\n", directions_off, densities_off,
           BLOCKS * SAMPLING_LANES);
    assert_true(directions_off < BLOCKS * SAMPLING_LANES / 1000);
    assert_true(densities_off < BLOCKS * SAMPLING_LANES / 1000);
}

static void test_kernels_match_scalar(void **state) {
    (void)state;
    struct lamp lamps[] = {lamp_clear(), lamp_frosted()};
    for (int i = 0; i < 3; i++) {
        struct sampling_density *density = build(&lamps[i % 2], i < 2, EXITS, 1);
        check_kernel(&sampling_kernel_avx2, density);
        if (sampling_kernel_best() == &sampling_kernel_avx512) check_kernel(&sampling_kernel_avx512, density);
        sampling_density_destroy(density);
    }
}

// Mean over shading points of the relative variance of L / p, and of the cone's uniform density for comparison.
static double variance(const struct lamp *lamp, const struct sampling_density *density, double *uniform) {
    double sum = 0, sum_uniform = 0;
    const int points = 40, n = 20000;
    for (int k = 0; k < points; k++) {
        struct sampler s = sampler_make(41, (uint64_t)k, 0);
        vec3 out = warp_uniform_sphere(sampler_2d(&s));
        vec3 at = vec3_mad(out, lamp->proxy.radius * (1.1f + 6 * sampler_1d(&s)), density->center);
        struct sampling_view view = sampling_view_make(density, at);
        double m1 = 0, m2 = 0, u1 = 0, u2 = 0;
        for (int i = 0; i < n; i++) {
            vec2 u = sampler_2d(&s);
            vec3 d;
            float pdf;
            sampling_sample(density, at, vec3_make(u.x, u.y, sampler_1d(&s)), &d, &pdf);
            rgb l = lamp_radiance(lamp, at, vec3_neg(d));
            double f = (double)(l.r + l.g + l.b) / (double)pdf;
            m1 += f, m2 += f * f;
            l = lamp_radiance(lamp, at, vec3_neg(sampling_direction_from_image(&view, sampler_2d(&s))));
            f = (double)(l.r + l.g + l.b) * 2 * M_PI * (double)view.rim;
            u1 += f, u2 += f * f;
        }
        sum += m2 * n / (m1 * m1) - 1;
        sum_uniform += u2 * n / (u1 * u1) - 1;
    }
    *uniform = sum_uniform / points;
    return sum / points;
}

static void test_variance(void **state) {
    (void)state;
    struct lamp clear = lamp_clear(), frosted = lamp_frosted();
    const struct {
        const char *name;
        const struct lamp *lamp;
        bool anchors;
        size_t exits;
        double most;
    } cases[] = {{"clear, anchors", &clear, true, EXITS, 0.6},
                 {"clear, map only", &clear, false, EXITS, 60},
                 {"frosted, map only", &frosted, false, EXITS, 0.4},
                 {"frosted, map only, 1.5 M exits", &frosted, false, 1500000, 0.3},
                 {"frosted, one anchor", &frosted, true, EXITS, 0.4}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        double start = clock_cpu_s();
        struct sampling_density *density = build(cases[i].lamp, cases[i].anchors, cases[i].exits, 1);
        double seconds = clock_cpu_s() - start, uniform, relative = variance(cases[i].lamp, density, &uniform);
        printf("%s: relative variance of L / p %.3f (uniform %.2f), %.2f s\n", cases[i].name, relative, uniform,
               seconds);
        sampling_density_destroy(density);
        assert_true(relative < cases[i].most);
    }
}

static void test_threads_do_not_matter(void **state) {
    (void)state;
    struct lamp lamp = lamp_clear();
    struct sampling_density *a = build(&lamp, true, 50000, 1), *b = build(&lamp, true, 50000, 3);
    assert_memory_equal(a->codes, b->codes, sampling_cell_count(a) * MAP_BYTES);
    assert_memory_equal(a->residual_share, b->residual_share, sampling_cell_count(a));
    sampling_density_destroy(a);
    sampling_density_destroy(b);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_map_matches_density),
                                       cmocka_unit_test(test_anchors_match_density),
                                       cmocka_unit_test(test_kernels_match_scalar), cmocka_unit_test(test_variance),
                                       cmocka_unit_test(test_threads_do_not_matter)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
