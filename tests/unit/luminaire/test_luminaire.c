// Proxies, the assembled luminaire, its file and the training state.
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <unistd.h>
#include <cmocka.h>

#include "../../stat/luminaire/synthetic_lamp.h"
#include "base/file.h"
#include "luminaire/encoding.h"
#include "luminaire/proxy.h"

static const float box_lower[3] = {-1, -0.5f, 0.2f}, box_upper[3] = {0.4f, 0.7f, 1.1f};

// A box as a mesh of 12 outward triangles.
static float box_vertices[8][3];
static uint32_t box_indices[36] = {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                                   2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};

static struct proxy box_proxy(enum proxy_kind kind) {
    struct proxy proxy = {.kind = kind};
    float diagonal2 = 0;
    for (int a = 0; a < 3; a++) {
        proxy.lower[a] = box_lower[a], proxy.upper[a] = box_upper[a];
        proxy.center[a] = 0.5f * (box_lower[a] + box_upper[a]);
        diagonal2 += sqrf(box_upper[a] - box_lower[a]);
    }
    proxy.radius = 0.5f * sqrtf(diagonal2);
    for (int i = 0; i < 8; i++)
        for (int a = 0; a < 3; a++) box_vertices[i][a] = i >> a & 1 ? box_upper[a] : box_lower[a];
    if (kind == PROXY_MESH) {
        proxy.vertices = box_vertices, proxy.indices = box_indices;
        proxy.vertex_count = 8, proxy.triangle_count = 12;
    }
    return proxy;
}

static struct proxy cylinder_proxy(void) {
    return (struct proxy){.kind = PROXY_CYLINDER,
                          .center = {0.3f, 0.1f, -0.2f},
                          .radius = 1.3f,
                          .axis = {0.6f, 0, 0.8f},
                          .half_height = 0.9f,
                          .axis_radius = 0.7f};
}

static bool inside(const struct proxy *proxy, vec3 p) {
    vec3 d = vec3_sub(p, vec3_make(proxy->center[0], proxy->center[1], proxy->center[2]));
    if (proxy->kind == PROXY_SPHERE) return vec3_dot(d, d) <= sqrf(proxy->radius);
    if (proxy->kind == PROXY_CYLINDER) {
        vec3 axis = vec3_make(proxy->axis[0], proxy->axis[1], proxy->axis[2]);
        float h = vec3_dot(d, axis);
        return fabsf(h) <= proxy->half_height && vec3_dot(d, d) - h * h <= sqrf(proxy->axis_radius);
    }
    const float v[3] = {p.x, p.y, p.z};
    for (int a = 0; a < 3; a++)
        if (v[a] < box_lower[a] || v[a] > box_upper[a]) return false;
    return true;
}

// All proxies are convex here: the span is exactly where points of the line are inside.
static void test_spans(void **state) {
    (void)state;
    struct proxy proxies[4] = {{.kind = PROXY_SPHERE, .center = {1, 2, 3}, .radius = 0.8f},
                               box_proxy(PROXY_BOX),
                               cylinder_proxy(),
                               box_proxy(PROXY_MESH)};
    for (int k = 0; k < 4; k++) {
        struct proxy_shape shape;
        struct error error;
        assert_int_equal(proxy_shape_init(&shape, &proxies[k], &error), STATUS_OK);
        int hits = 0;
        for (int i = 0; i < 3000; i++) {
            struct sampler s = sampler_make(2, (uint64_t)k, (uint64_t)i);
            vec3 w = warp_uniform_sphere(sampler_2d(&s));
            if (i % 5 == 0) w = (vec3){i % 3 == 0, i % 3 == 1, i % 3 == 2};
            vec3 in = vec3_scale(warp_uniform_sphere(sampler_2d(&s)), 1.2f * proxies[k].radius * sampler_1d(&s));
            vec3 p = vec3_add(in, vec3_make(proxies[k].center[0], proxies[k].center[1], proxies[k].center[2]));
            p = vec3_mad(w, 8 * (sampler_1d(&s) - 0.5f), p);
            float origin[3], direction[3], t_near = 0, t_far = 0;
            store(origin, p), store(direction, w);
            bool hit = proxy_shape_span(&shape, origin, direction, &t_near, &t_far);
            hits += hit;
            if (hit) assert_true(t_near <= t_far);
            for (int j = 0; j < 200; j++) {
                float t = -7 + 14 * ((float)j + 0.5f) / 200;
                if (hit && (fabsf(t - t_near) < 1e-3f || fabsf(t - t_far) < 1e-3f)) continue;
                bool within = hit && t > t_near && t < t_far;
                if (within != inside(&proxies[k], vec3_mad(w, t, p))) // only by a hair, at an edge
                    assert_true(inside(&proxies[k], vec3_mad(w, t + 2e-3f, p)) !=
                                inside(&proxies[k], vec3_mad(w, t - 2e-3f, p)));
            }
        }
        assert_true(hits > 300 && hits < 3000);
        proxy_shape_fini(&shape);
    }
}

static void test_bad_proxies(void **state) {
    (void)state;
    struct proxy bad[5] = {{.kind = PROXY_SPHERE, .radius = -1},
                           box_proxy(PROXY_BOX),
                           cylinder_proxy(),
                           box_proxy(PROXY_MESH),
                           {.kind = PROXY_SPHERE, .center = {NAN, 0, 0}, .radius = 1}};
    bad[1].upper[1] = bad[1].lower[1];
    bad[2].half_height = 5;
    bad[3].vertex_count = 7;
    for (int k = 0; k < 5; k++) {
        struct proxy_shape shape;
        struct error error = {0};
        assert_int_equal(proxy_shape_init(&shape, &bad[k], &error), STATUS_INVALID);
        assert_true(error.text[0] != 0);
        proxy_shape_fini(&shape);
    }
}

static void test_octahedral_block(void **state) {
    (void)state;
    float w[3][NET_LANES], x[NET_LANES], y[NET_LANES];
    for (int i = 0; i < 50; i++) {
        struct sampler s = sampler_make(1, 0, (uint64_t)i);
        vec3 v[NET_LANES];
        for (int l = 0; l < NET_LANES; l++) {
            v[l] = warp_uniform_sphere(sampler_2d(&s));
            w[0][l] = v[l].x, w[1][l] = v[l].y, w[2][l] = v[l].z;
        }
        octahedral_block((const float(*)[NET_LANES])w, x, y);
        for (int l = 0; l < NET_LANES; l++) {
            vec3 back = direction_from_octahedral((vec2){x[l], y[l]});
            assert_true(vec3_length(vec3_sub(back, v[l])) < 1e-5f);
        }
    }
}

// Nearby lines (and any point on a line) give nearby radiance: nothing depends on where on the line `point` is.
static struct light_field *train_field(const struct lamp *lamp, const struct proxy *proxy, size_t steps, int threads,
                                       size_t batch) {
    static const float shells[] = {0.7f, 0.4f};
    float anchor[1][3] = {{proxy->center[0], proxy->center[1], proxy->center[2]}};
    struct light_field_options options = {.proxy = *proxy,
                                          .anchors = (const float(*)[3])anchor,
                                          .anchor_count = 1,
                                          .anchor_radius = 0.1f,
                                          .shell_radii = shells,
                                          .shell_count = 2,
                                          .use_grid4 = true,
                                          .radiance_unit = 0.5f,
                                          .log2_entries = 10,
                                          .steps = 40,
                                          .seed = 4};
    struct light_field *field;
    struct error error;
    assert_int_equal(light_field_create(&field, &options, &error), STATUS_OK);
    struct line_sample *samples = malloc(batch * sizeof *samples);
    for (size_t step = 0; step < steps; step++) {
        lamp_batch(lamp, DATA_CAMERA, 0.5f, step, batch, samples);
        light_field_train(field, samples, batch, threads, NULL);
    }
    free(samples);
    return field;
}

enum { PROBES = 300 };
struct probes {
    float point[PROBES][3], w[PROBES][3];
};

static struct probes probe_lines(const struct proxy *proxy) {
    struct probes probes;
    for (int i = 0; i < PROBES; i++) {
        struct sampler s = sampler_make(77, 0, (uint64_t)i);
        vec3 p = vec3_scale(warp_uniform_sphere(sampler_2d(&s)), 1.2f * proxy->radius * sampler_1d(&s));
        store(probes.point[i], vec3_add(p, vec3_make(proxy->center[0], proxy->center[1], proxy->center[2])));
        store(probes.w[i], warp_uniform_sphere(sampler_2d(&s)));
    }
    return probes;
}

static void test_training_is_deterministic(void **state) {
    (void)state;
    struct lamp lamp = lamp_frosted();
    struct light_field *a = train_field(&lamp, &lamp.proxy, 6, 1, 3001),
                       *b = train_field(&lamp, &lamp.proxy, 6, 2, 3001);
    struct probes probes = probe_lines(&lamp.proxy);
    static float ra[PROBES][3], rb[PROBES][3];
    light_field_eval(a, PROBES, (const float(*)[3])probes.point, (const float(*)[3])probes.w, ra);
    light_field_eval(b, PROBES, (const float(*)[3])probes.point, (const float(*)[3])probes.w, rb);
    assert_memory_equal(ra, rb, sizeof ra);
    light_field_destroy(a);
    light_field_destroy(b);
}

static void test_resume(void **state) {
    (void)state;
    char path[] = "/tmp/sconce_state_XXXXXX";
    int file = mkstemp(path);
    assert_true(file >= 0);
    close(file);
    struct lamp lamp = lamp_frosted();
    struct error error = {0};
    struct light_field *whole = train_field(&lamp, &lamp.proxy, 6, 1, 512),
                       *first = train_field(&lamp, &lamp.proxy, 3, 1, 512);
    assert_int_equal(light_field_save_state(first, path, &error), STATUS_OK);
    struct light_field *second = train_field(&lamp, &lamp.proxy, 0, 1, 512);
    assert_int_equal(light_field_load_state(second, path, &error), STATUS_OK);
    struct line_sample samples[512];
    for (size_t step = 3; step < 6; step++) {
        lamp_batch(&lamp, DATA_CAMERA, 0.5f, step, 512, samples);
        light_field_train(second, samples, 512, 1, NULL);
    }
    struct probes probes = probe_lines(&lamp.proxy);
    static float ra[PROBES][3], rb[PROBES][3];
    light_field_eval(whole, PROBES, (const float(*)[3])probes.point, (const float(*)[3])probes.w, ra);
    light_field_eval(second, PROBES, (const float(*)[3])probes.point, (const float(*)[3])probes.w, rb);
    assert_memory_equal(ra, rb, sizeof ra);
    struct transparency *other;
    assert_int_equal(
        transparency_create(
            &other, &(struct transparency_options){.proxy = &lamp.proxy, .log2_entries = 10, .steps = 10, .seed = 1},
            &error),
        STATUS_OK);
    assert_int_equal(transparency_load_state(other, path, &error), STATUS_INVALID); // another network's state
    transparency_destroy(other);
    light_field_destroy(whole);
    light_field_destroy(first);
    light_field_destroy(second);
    unlink(path);
}

static void test_transparency_learns(void **state) {
    (void)state; // a ball of transmittance (0.5, 0.25, 0) in clear air, seen through noise
    struct proxy proxy = {.kind = PROXY_SPHERE, .center = {1, 0, 0}, .radius = 2};
    struct transparency *t;
    struct error error;
    enum { BATCH = 4096, STEPS = 120 };
    assert_int_equal(
        transparency_create(
            &t, &(struct transparency_options){.proxy = &proxy, .log2_entries = 15, .steps = STEPS, .seed = 3}, &error),
        STATUS_OK);
    struct line_sample *samples = calloc(BATCH, sizeof *samples);
    double error2 = 0, mean = 0;
    for (size_t step = 0; step <= STEPS; step++) {
        for (size_t i = 0; i < BATCH; i++) {
            struct sampler s = sampler_make(1, step, i);
            vec3 w = warp_uniform_sphere(sampler_2d(&s));
            struct frame frame = frame_from_normal(w);
            vec2 disk = warp_concentric_disk(sampler_2d(&s));
            float r2 = disk.x * disk.x + disk.y * disk.y;
            vec3 p =
                vec3_add(vec3_make(1, 0, 0), vec3_scale(vec3_mad(frame.s, disk.x, vec3_scale(frame.t, disk.y)), 2));
            store(samples[i].point, p);
            store(samples[i].w, w);
            samples[i].mass = 1.0f / BATCH;
            for (int c = 0; c < 3; c++)
                samples[i].target[c] = r2 < 0.25f ? (sampler_1d(&s) < 0.5f / (float)(1 << c) * (c < 2)) : 1;
        }
        if (step < STEPS) transparency_train(t, samples, BATCH, 1, NULL);
    }
    for (size_t i = 0; i < BATCH; i++) { // against the ball itself, on lines that were not trained
        float result[3];
        transparency_eval(t, 1, (const float(*)[3])samples[i].point, (const float(*)[3])samples[i].w, &result);
        vec3 d = vec3_make(samples[i].point[0] - 1, samples[i].point[1], samples[i].point[2]);
        float exact = vec3_dot(d, d) < 1 ? 0.5f : 1;
        error2 += (double)sqrf(result[0] - exact);
        mean += (double)(result[0] - exact);
    }
    printf("transparency: rms error %.3f, mean %+.4f\n", sqrt(error2 / BATCH), mean / BATCH);
    assert_true(sqrt(error2 / BATCH) < 0.12);
    assert_true(fabs(mean / BATCH) < 0.01);
    free(samples);
    transparency_destroy(t);
}

static struct luminaire *make_luminaire(const struct proxy *proxy, bool transparent) {
    struct lamp lamp = lamp_frosted();
    lamp.proxy = *proxy;
    memcpy(&lamp.balls[0].center, proxy->center, sizeof proxy->center);
    lamp.balls[0].radius = 0.3f * proxy->radius;
    struct light_field *field = train_field(&lamp, proxy, 5, 1, 512);
    light_field_set_scale(field, (const float[3]){1.1f, 0.9f, 1});
    struct transparency *t = NULL;
    struct error error = {0};
    if (transparent)
        assert_int_equal(
            transparency_create(
                &t, &(struct transparency_options){.proxy = proxy, .log2_entries = 12, .steps = 10, .seed = 1}, &error),
            STATUS_OK);
    enum { EXITS = 5000 };
    struct line_exit *exits = malloc(EXITS * sizeof *exits);
    for (size_t i = 0; i < EXITS; i++) {
        struct sampler s = sampler_make(3, 0, i);
        lamp_exit(&lamp, &s, &exits[i]);
    }
    float anchor[1][3] = {{proxy->center[0], proxy->center[1], proxy->center[2]}};
    struct sampling_density *density;
    assert_int_equal(sampling_density_build(&density, proxy, (const float(*)[3])anchor, 1, exits, EXITS, 1, 1, &error),
                     STATUS_OK);
    free(exits);
    const char *keys[] = {"source", "length_unit"}, *values[] = {"made up", "m"};
    struct luminaire *luminaire;
    assert_int_equal(
        luminaire_assemble(&luminaire, proxy, field, t, density, (const float[3]){1, 2, 3}, keys, values, 2, &error),
        STATUS_OK);
    return luminaire;
}

static void compare_luminaires(const struct luminaire *a, const struct luminaire *b, const struct probes *probes) {
    static float ra[PROBES][3], rb[PROBES][3], pa[PROBES], pb[PROBES];
    const float(*point)[3] = (const float(*)[3])probes->point, (*w)[3] = (const float(*)[3])probes->w;
    luminaire_eval(a, PROBES, point, w, ra);
    luminaire_eval(b, PROBES, point, w, rb);
    assert_memory_equal(ra, rb, sizeof ra);
    luminaire_transmittance(a, PROBES, point, w, ra);
    luminaire_transmittance(b, PROBES, point, w, rb);
    assert_memory_equal(ra, rb, sizeof ra);
    luminaire_pdf(a, PROBES, point, w, pa);
    luminaire_pdf(b, PROBES, point, w, pb);
    assert_memory_equal(pa, pb, sizeof pa);
}

static void test_file_round_trip(void **state) {
    (void)state;
    struct proxy proxies[4] = {{.kind = PROXY_SPHERE, .center = {1, 2, 3}, .radius = 0.8f},
                               box_proxy(PROXY_BOX),
                               cylinder_proxy(),
                               box_proxy(PROXY_MESH)};
    for (int k = 0; k < 4; k++) {
        char path[] = "/tmp/sconce_lamp_XXXXXX";
        int file = mkstemp(path);
        assert_true(file >= 0);
        close(file);
        struct error error = {0};
        struct luminaire *made = make_luminaire(&proxies[k], k != 2), *loaded;
        const float back[3] = {0.5f, 0.25f, 1}, onward[3] = {0.5f, 0, 0}, more[3] = {0.25f, 0.25f, 0.25f};
        assert_int_equal(luminaire_set_scattering(made, back, onward, &error), STATUS_OK);
        assert_int_equal(luminaire_set_scattering(made, back, more, &error), STATUS_INVALID);
        assert_int_equal(luminaire_save(made, path, &error), STATUS_OK);
        enum status status = luminaire_load(&loaded, path, &error);
        if (status) printf("%s\n", error.text);
        assert_int_equal(status, STATUS_OK);
        assert_string_equal(luminaire_metadata(loaded, "source"), "made up");
        assert_null(luminaire_metadata(loaded, "nothing"));
        float flux[3];
        luminaire_flux(loaded, flux);
        assert_true(flux[0] == 1 && flux[1] == 2 && flux[2] == 3);
        float shares[2][3];
        luminaire_scattering(loaded, shares[0], shares[1]);
        assert_memory_equal(shares[0], back, sizeof back);
        assert_memory_equal(shares[1], onward, sizeof onward);
        struct probes probes = probe_lines(&proxies[k]);
        compare_luminaires(made, loaded, &probes);
        luminaire_destroy(made);

        // Cut anywhere, or with any one of many bytes changed, the file is refused or harmless.
        uint8_t *bytes;
        size_t length;
        assert_int_equal(file_read(path, &bytes, &length, &error), STATUS_OK);
        assert_true(luminaire_bytes(loaded) == length);
        luminaire_destroy(loaded);
        for (size_t cut = 0; cut < length; cut += length / 37 + 1) {
            assert_int_not_equal(luminaire_parse(&loaded, "cut", bytes, cut, &error), STATUS_OK);
            assert_null(loaded);
        }
        for (size_t i = 0; i < 3000 && i < length; i += 7) {
            uint8_t kept = bytes[i];
            bytes[i] ^= (uint8_t)(1 << i % 8);
            if (luminaire_parse(&loaded, "changed", bytes, length, &error) == STATUS_OK)
                luminaire_destroy(loaded);
            else
                assert_null(loaded);
            bytes[i] = kept;
        }
        free(bytes);
        unlink(path);
    }
}

// Radiance belongs to the line, not to the point that names it; misses are dark and clear.
static void test_queries_belong_to_lines(void **state) {
    (void)state;
    struct proxy proxy = box_proxy(PROXY_BOX);
    struct luminaire *luminaire = make_luminaire(&proxy, true);
    struct probes probes = probe_lines(&proxy), shifted = probes;
    for (int i = 0; i < PROBES; i++)
        for (int a = 0; a < 3; a++) shifted.point[i][a] += 0.7f * probes.w[i][a];
    static float l[PROBES][3], m[PROBES][3], t[PROBES][3], l_met[PROBES][3], t_met[PROBES][3];
    luminaire_eval(luminaire, PROBES, (const float(*)[3])probes.point, (const float(*)[3])probes.w, l);
    luminaire_eval(luminaire, PROBES, (const float(*)[3])shifted.point, (const float(*)[3])shifted.w, m);
    luminaire_transmittance(luminaire, PROBES, (const float(*)[3])probes.point, (const float(*)[3])probes.w, t);
    luminaire_eval_met(luminaire, PROBES, (const float(*)[3])probes.point, (const float(*)[3])probes.w, l_met);
    luminaire_transmittance_met(luminaire, PROBES, (const float(*)[3])probes.point, (const float(*)[3])probes.w, t_met);
    int misses = 0;
    for (int i = 0; i < PROBES; i++) {
        float t_near, t_far, one[3];
        bool hit = luminaire_span(luminaire, probes.point[i], probes.w[i], &t_near, &t_far);
        luminaire_eval(luminaire, 1, (const float(*)[3])probes.point[i], (const float(*)[3])probes.w[i], &one);
        misses += !hit;
        for (int c = 0; c < 3; c++) {
            assert_true(fabsf(l[i][c] - m[i][c]) <= 2e-2f * l[i][c] + 1e-5f);
            assert_true(l[i][c] == one[c]); // the same in a batch and alone
            if (!hit)
                assert_true(l[i][c] == 0 && t[i][c] == 1);
            else
                assert_true(l[i][c] > 0 && t[i][c] >= 0 && t[i][c] <= 1 && l[i][c] == l_met[i][c] &&
                            t[i][c] == t_met[i][c]);
        }
    }
    assert_true(misses > 10 && misses < PROBES - 10);
    luminaire_destroy(luminaire);
}

int main(int argc, char **argv) {
    if (argc == 2) { // writes the fuzzers' seed
        struct proxy proxy = {.kind = PROXY_SPHERE, .center = {1, 2, 3}, .radius = 0.8f};
        struct luminaire *luminaire = make_luminaire(&proxy, false);
        struct error error;
        enum status status = luminaire_save(luminaire, argv[1], &error);
        luminaire_destroy(luminaire);
        return status != STATUS_OK;
    }
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_spans),
        cmocka_unit_test(test_bad_proxies),
        cmocka_unit_test(test_octahedral_block),
        cmocka_unit_test(test_training_is_deterministic),
        cmocka_unit_test(test_resume),
        cmocka_unit_test(test_transparency_learns),
        cmocka_unit_test(test_file_round_trip),
        cmocka_unit_test(test_queries_belong_to_lines),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
