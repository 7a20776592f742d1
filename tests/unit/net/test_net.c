// Kernels against the scalar reference, gradients against finite differences, training against a known function.
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#include "base/parallel.h"
#include "math/sampler.h"
#include "net/kernel.h"
#include "net/trainer.h"

static struct grid_layout layout_make(void) {
    struct grid_layout layout = {0};
    grid_add_lookup(&layout, grid_add_level(&layout, 4, 5, 12, 1), 0);
    int hashed = grid_add_level(&layout, 4, 40, 10, 1);
    grid_add_lookup(&layout, hashed, 0);
    grid_add_lookup(&layout, grid_add_level(&layout, 3, 30, 10, 1), 1);
    grid_add_lookup(&layout, grid_add_level(&layout, 2, 7, 10, 3), 2);
    grid_add_lookup(&layout, hashed, 3);
    grid_add_lookup(&layout, grid_add_level(&layout, 1, 9, 10, 1), 4);
    int tiny = grid_add_level(&layout, 2, 96, 6, 3); // where the table's last entry has its first as the next
    for (int k = 0; k < 12; k++) grid_add_lookup(&layout, tiny, 2); // more lookups than a vector has lanes
    layout.raw_count = 3;
    return layout;
}

static void input_fill(struct grid_input *input, uint64_t seed) {
    struct sampler s = sampler_make(seed, 1, 0);
    for (int k = 0; k < GRID_MAX_SETS; k++)
        for (int l = 0; l < NET_LANES; l++) {
            for (int a = 0; a < GRID_MAX_DIMS; a++) input->set[k][a][l] = 1.2f * sampler_1d(&s) - 0.1f;
            input->slice[k][l] = k == 2 ? (int32_t)(3 * sampler_1d(&s)) : 0;
        }
    for (int k = 0; k < GRID_MAX_RAW; k++)
        for (int l = 0; l < NET_LANES; l++) input->raw[k][l] = 2 * sampler_1d(&s) - 1;
    input->set[0][0][3] = NAN; // must not lead out of the table
    input->set[0][1][4] = 1;
    input->set[1][2][5] = 0;
}

static const struct kernel *kernels(int i) {
    if (i == 0) return &kernel_avx2;
    return kernel_best() == &kernel_avx2 ? NULL : kernel_best();
}

static void test_grid_matches_reference(void **state) {
    (void)state;
    struct grid_layout layout = layout_make();
    float *table = malloc(layout.entry_count * 2 * sizeof(float)), scale[GRID_MAX_LEVELS];
    int8_t *codes = calloc(layout.entry_count * 2 + GRID_PADDING, 1);
    struct sampler s = sampler_make(7, 0, 0);
    for (size_t i = 0; i < layout.entry_count * 2; i++) table[i] = 2 * sampler_1d(&s) - 1;
    grid_quantise(&layout, table, codes, scale);
    for (size_t i = 0; i < layout.entry_count * 2; i++) {
        int level = 0;
        while (level + 1 < layout.level_count && i >= 2 * (size_t)layout.levels[level + 1].offset) level++;
        assert_float_equal(codes[i] * scale[level], table[i], 0.501f / 127);
    }
    static struct grid_by_lookup by_lookup;
    grid_by_lookup_make(&layout, scale, &by_lookup);
    for (int i = 0; i < 2 && kernels(i); i++)
        for (uint64_t seed = 0; seed < 20; seed++) {
            struct grid_input input;
            input_fill(&input, seed);
            _Alignas(64) int32_t index[64 * NET_LANES];
            _Alignas(64) float weight[64 * NET_LANES], x[64 * NET_LANES], y[64 * NET_LANES];
            kernels(i)->index(&layout, &input, index, weight);
            kernels(i)->gather_float(&layout, table, &input, index, weight, x);
            kernels(i)->lookup(&layout, codes, scale, &input, y);
            for (int l = 0; l < NET_LANES; l++) {
                float lane[64];
                kernels(i)->lookup_lane(&by_lookup, codes, &input, l, lane);
                for (int k = 0; k < grid_input_count(&layout); k++)
                    assert_memory_equal(&lane[k], &y[k * NET_LANES + l], sizeof(float));
            }
            for (int j = 0; j < layout.lookup_count; j++)
                for (int l = 0; l < NET_LANES; l++) {
                    const struct grid_lookup *lookup = &layout.lookups[j];
                    const struct grid_level *level = &layout.levels[lookup->level];
                    float coordinates[4], share[5], sum = 0, expected[2] = {0, 0}, coded[2] = {0, 0};
                    uint32_t corner[5];
                    for (int a = 0; a < 4; a++) coordinates[a] = input.set[lookup->set][a][l];
                    grid_corners(level, coordinates, input.slice[lookup->set][l], corner, share);
                    for (int k = 0; k <= level->dims; k++) {
                        assert_true(corner[k] >= level->offset);
                        assert_true(corner[k] < level->offset + level->slice_entries * level->slices);
                        assert_true(share[k] >= -1e-6f);
                        sum += share[k];
                        for (uint32_t f = 0; f < 2; f++) {
                            expected[f] += share[k] * table[2 * corner[k] + f];
                            coded[f] += share[k] * codes[2 * corner[k] + f] * scale[lookup->level];
                        }
                    }
                    assert_float_equal(sum, 1, 1e-5);
                    for (int f = 0; f < 2; f++) {
                        assert_float_equal(x[(2 * j + f) * NET_LANES + l], expected[f], 2e-5);
                        assert_float_equal(y[(2 * j + f) * NET_LANES + l], coded[f], 2e-5);
                    }
                }
            for (int k = 0; k < layout.raw_count; k++)
                assert_memory_equal(x + (2 * layout.lookup_count + k) * NET_LANES, input.raw[k], sizeof input.raw[k]);
        }
    free(table);
    free(codes);
}

// Linear functions of the coordinates are reproduced exactly by a dense grid.
static void test_grid_is_linear(void **state) {
    (void)state;
    struct grid_layout layout = {0};
    int k = grid_add_level(&layout, 3, 4, 10, 1);
    const struct grid_level *level = &layout.levels[k];
    for (int trial = 0; trial < 200; trial++) {
        struct sampler s = sampler_make(3, 0, (uint64_t)trial);
        float p[3] = {sampler_1d(&s), sampler_1d(&s), sampler_1d(&s)}, weight[5], value = 0;
        uint32_t index[5];
        grid_corners(level, p, 0, index, weight);
        for (int c = 0; c < 4; c++) {
            uint32_t i = index[c];
            value += weight[c] * (float)(1 * (i % 5) + 2 * (i / 5 % 5) + 3 * (i / 25)) / 4;
        }
        assert_float_equal(value, p[0] + 2 * p[1] + 3 * p[2], 1e-5);
    }
}

static void test_mlp_matches_reference(void **state) {
    (void)state;
    static const struct mlp_shape shapes[] = {{4, 8, 1}, {20, 32, 3}, {96, 32, 3}, {12, 16, 4}, {128, 64, 2}};
    for (size_t t = 0; t < sizeof shapes / sizeof *shapes; t++)
        for (int i = 0; i < 2 && kernels(i); i++) {
            const struct mlp_shape *shape = &shapes[t];
            enum { BLOCKS = 3, ROOM = BLOCKS * NET_LANES * 128 };
            size_t count = mlp_layout(shape).count;
            float *p = malloc(count * 4), *fast = calloc(count, 4), *slow = calloc(count, 4);
            mlp_init(shape, p, t);
            static _Alignas(64) float x[ROOM], h1[ROOM], h2[ROOM], z[ROOM], d_z[ROOM], d_x[ROOM], d_h[2 * ROOM];
            struct sampler s = sampler_make(5, t, 0);
            for (int k = 0; k < ROOM; k++) x[k] = 2 * sampler_1d(&s) - 1, d_z[k] = 2 * sampler_1d(&s) - 1;
            int w = shape->width * NET_LANES, n = shape->inputs * NET_LANES, o = shape->outputs * NET_LANES;
            for (int b = 0; b < BLOCKS; b++)
                kernels(i)->forward(shape, p, x + b * n, h1 + b * w, h2 + b * w, z + b * o);
            float *by_input = malloc(count * 4);
            mlp_transpose(shape, p, by_input);
            for (int l = 0; l < NET_LANES; l++) {
                float lane[128], result[4];
                for (int k = 0; k < shape->inputs; k++) lane[k] = x[k * NET_LANES + l];
                kernels(i)->forward_lane(shape, by_input, lane, result);
                for (int k = 0; k < shape->outputs; k++)
                    assert_memory_equal(&result[k], &z[k * NET_LANES + l], sizeof(float));
            }
            free(by_input);
            kernels(i)->backward(shape, p, BLOCKS, x, h1, h2, d_z, shape->inputs, d_x, d_h, fast);
            for (int b = 0; b < BLOCKS; b++)
                for (int l = 0; l < NET_LANES; l++) {
                    float xs[128], a[64], c[64], zs[4], dz[4], dx[128];
                    for (int k = 0; k < shape->inputs; k++) xs[k] = x[b * n + k * NET_LANES + l];
                    mlp_forward(shape, p, xs, a, c, zs);
                    for (int k = 0; k < shape->outputs; k++) {
                        assert_float_equal(z[b * o + k * NET_LANES + l], zs[k], 1e-4);
                        dz[k] = d_z[b * o + k * NET_LANES + l];
                    }
                    mlp_backward(shape, p, xs, a, c, dz, dx, slow);
                    for (int k = 0; k < shape->inputs; k++)
                        assert_float_equal(d_x[b * n + k * NET_LANES + l], dx[k], 1e-4);
                }
            for (size_t k = 0; k < count; k++) assert_float_equal(fast[k], slow[k], 1e-3);
            free(p);
            free(fast);
            free(slow);
        }
}

static void test_gradient_by_differences(void **state) {
    (void)state;
    struct mlp_shape shape = {8, 8, 2};
    enum { COUNT = 8 * 8 + 8 + 8 * 8 + 8 + 2 * 8 + 2 };
    float p[COUNT], x[8], h1[8], h2[8], z[2], d_x[8], d_p[COUNT] = {0}, d_z[2] = {0.7f, -0.4f};
    assert_int_equal(mlp_layout(&shape).count, COUNT);
    mlp_init(&shape, p, 11);
    for (int i = 0; i < 8; i++) x[i] = 0.1f * (float)(i - 3);
    mlp_forward(&shape, p, x, h1, h2, z);
    mlp_backward(&shape, p, x, h1, h2, d_z, d_x, d_p);
    for (int k = 0; k < COUNT + 8; k++) {
        float *at = k < COUNT ? &p[k] : &x[k - COUNT], kept = *at, f[2];
        for (int side = 0; side < 2; side++) {
            *at = kept + (side ? -1e-3f : 1e-3f);
            mlp_forward(&shape, p, x, h1, h2, z);
            f[side] = d_z[0] * z[0] + d_z[1] * z[1];
        }
        *at = kept;
        assert_float_equal((f[0] - f[1]) / 2e-3f, k < COUNT ? d_p[k] : d_x[k - COUNT], 2e-3);
    }
}

static void test_exponential(void **state) {
    (void)state;
    for (int i = 0; i < 2 && kernels(i); i++)
        for (float v = -60; v < 60; v += 0.7f) {
            _Alignas(64) float values[NET_LANES];
            for (int l = 0; l < NET_LANES; l++) values[l] = v + 0.04f * (float)l;
            kernels(i)->exponential(values, NET_LANES);
            for (int l = 0; l < NET_LANES; l++) {
                double expected = exp(v + 0.04f * (float)l);
                assert_true(fabs(values[l] - expected) < 1e-6 * expected);
            }
        }
}

struct problem {
    size_t step;
};

static float wave(float x, float y, float z) { return sinf(6 * x) * cosf(5 * y) + z; }

static void problem_encode(const void *user, size_t first, int count, struct grid_input *input) {
    const struct problem *problem = user;
    for (int l = 0; l < count; l++) {
        struct sampler s = sampler_make(1, problem->step, first + (size_t)l);
        for (int a = 0; a < 3; a++) input->set[0][a][l] = sampler_1d(&s);
    }
}

static double problem_loss(const void *user, size_t first, int count, const float *z, float *d_z) {
    struct grid_input input;
    double loss = 0;
    problem_encode(user, first, count, &input);
    for (int l = 0; l < NET_LANES; l++) {
        float error = z[l] - wave(input.set[0][0][l], input.set[0][1][l], input.set[0][2][l]);
        d_z[l] = l < count ? error : 0;
        loss += l < count ? error * error : 0;
    }
    return loss;
}

static double train(int threads, size_t n, size_t steps, struct trainer *trainer) {
    struct grid_layout layout = {0};
    grid_add_lookup(&layout, grid_add_level(&layout, 3, 8, 14, 1), 0);
    grid_add_lookup(&layout, grid_add_level(&layout, 3, 31, 12, 1), 0);
    struct trainer_rates rates = {1e-2f, 3e-3f, 0.05f, steps};
    assert_int_equal(trainer_init(trainer, &layout, 32, 1, &rates, 42, NULL), STATUS_OK);
    double loss = 0;
    for (size_t step = 0; step < steps; step++) {
        struct problem problem = {step};
        loss = trainer_step(trainer, &(struct trainer_batch){n, &problem, problem_encode, problem_loss}, threads) /
               (double)n;
    }
    return loss;
}

static void test_training_converges(void **state) {
    (void)state;
    struct trainer trainer;
    double loss = train(1, 1000, 300, &trainer); // 1000: an odd tail
    trainer_fini(&trainer);
    assert_true(loss < 1e-3);
}

static void test_threads_do_not_matter(void **state) {
    (void)state;
    struct trainer a, b;
    train(1, 5003, 12, &a);
    train(3, 5003, 12, &b);
    assert_memory_equal(a.table, b.table, a.layout.entry_count * 2 * sizeof(float));
    assert_memory_equal(a.mlp, b.mlp, a.mlp_count * sizeof(float));
    trainer_fini(&a);
    trainer_fini(&b);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_grid_matches_reference),
        cmocka_unit_test(test_grid_is_linear),
        cmocka_unit_test(test_mlp_matches_reference),
        cmocka_unit_test(test_gradient_by_differences),
        cmocka_unit_test(test_exponential),
        cmocka_unit_test(test_training_converges),
        cmocka_unit_test(test_threads_do_not_matter),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
