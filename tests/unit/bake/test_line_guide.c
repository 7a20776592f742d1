// The guide's density against its samples, by integrals that are known in closed form: the measure of all lines that
// cross a sphere of radius r is (2 pi r)^2.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "bake/line_guide.h"
#include "math/warp.h"

static const vec3 center = {3, -2, 5};
static const float radius = 0.7f;
static const struct emission_cluster clusters[2] = {{{3.2f, -2.1f, 5}, 0.02f, 0.25f},
                                                    {{2.7f, -1.9f, 5.3f}, 0.05f, 0.75f}};

// Exits round the first cluster, so that the histogram is far from uniform.
static struct line_guide *make_guide(float cluster_share) {
    enum { N = 20000 };
    static struct line_exit exits[N];
    for (size_t i = 0; i < N; i++) {
        struct sampler sampler = sampler_make(7, 0, i);
        vec3 w = warp_uniform_sphere(sampler_2d(&sampler)), d = vec3_sub(clusters[0].center, center);
        float b = vec3_dot(d, w), t = sqrtf(b * b - vec3_dot(d, d) + radius * radius) - b;
        vec3 p = vec3_mad(w, t, clusters[0].center);
        exits[i] = (struct line_exit){{p.x, p.y, p.z}, {w.x, w.y, w.z}, {1, 2, 3}};
    }
    struct line_guide_options options = {center, radius, exits, N, 0.5f, clusters, 2, cluster_share};
    struct line_guide *guide = NULL;
    struct error error;
    assert_int_equal(line_guide_create(&guide, &options, &error), STATUS_OK);
    return guide;
}

static bool crosses(vec3 point, vec3 w, vec3 c, float r) {
    vec3 d = vec3_sub(point, c);
    return vec3_dot(d, d) - vec3_dot(d, w) * vec3_dot(d, w) < r * r;
}

static void check_integrals(float cluster_share) {
    struct line_guide *guide = make_guide(cluster_share);
    const struct {
        vec3 c;
        float r;
    } balls[] = {{center, radius}, {clusters[0].center, 0.02f}, {clusters[1].center, 0.1f}};
    enum { N = 400000 };
    double sum[3] = {0}, squares[3] = {0};
    for (size_t i = 0; i < N; i++) {
        struct sampler sampler = sampler_make(11, 1, i);
        vec3 point, w;
        float density = line_guide_sample(guide, &sampler, &point, &w);
        if (density == 0) continue;
        assert_true(density > 0);
        assert_true(fabsf(vec3_length(w) - 1) < 1e-4f);
        assert_true(fabsf(vec3_length(vec3_sub(point, center)) - radius) < 1e-4f);
        assert_true(vec3_dot(vec3_sub(point, center), w) >= -1e-4f);
        for (int k = 0; k < 3; k++) {
            double y = crosses(point, w, balls[k].c, balls[k].r) ? 1 / (double)density : 0;
            sum[k] += y;
            squares[k] += y * y;
        }
    }
    for (int k = 0; k < 3; k++) {
        double mean = sum[k] / N, error = sqrt((squares[k] / N - mean * mean) / N);
        double expected = 4 * M_PI * M_PI * balls[k].r * balls[k].r;
        assert_true(fabs(mean - expected) <
                    4.5 * error + 1e-4 * expected); // a line tangent to the sphere rounds either way
        assert_true(error < 0.05 * expected);
    }
    line_guide_destroy(guide);
}

static void integrals_with_clusters(void **state) { (void)state, check_integrals(0.4f); }
static void integrals_without_clusters(void **state) { (void)state, check_integrals(0); }

static void density_integrates_to_one(void **state) {
    (void)state;
    struct line_guide *guide = make_guide(0.4f);
    enum { N = 400000 };
    double sum = 0, squares = 0;
    for (size_t i = 0; i < N; i++) { // uniform lines: a direction, and a point on the disk across it
        struct sampler sampler = sampler_make(5, 2, i);
        vec3 w = warp_uniform_sphere(sampler_2d(&sampler));
        vec2 disk = warp_concentric_disk(sampler_2d(&sampler));
        struct frame frame = frame_from_normal(w);
        vec3 p = vec3_mad(frame.s, disk.x * radius, vec3_mad(frame.t, disk.y * radius, center));
        double y = (double)line_guide_density(guide, p, w) * 4 * M_PI * M_PI * (double)(radius * radius);
        sum += y;
        squares += y * y;
    }
    double mean = sum / N, error = sqrt((squares / N - mean * mean) / N);
    // The share that the clusters lose to lines outside the sphere is nil: both lie inside.
    assert_true(fabs(mean - 1) < 4.5 * error);
    assert_true(error < 0.1);
    line_guide_destroy(guide);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(integrals_with_clusters),
                                       cmocka_unit_test(integrals_without_clusters),
                                       cmocka_unit_test(density_integrates_to_one)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
