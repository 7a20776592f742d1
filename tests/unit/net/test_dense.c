// The wide networks: counts of parameters, the gradient of the reference by differences, the fast forms against the
// reference at odd batch tails, training for any number of threads.
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#include "math/sampler.h"
#include "net/dense_trainer.h"
#include "net/kernel.h"

// Zhu et al. 2021, Table 1: 7.61 MB and 1.85 MB; 17.0 MB for two of the first and one of the second.
static void test_counts(void **state) {
    (void)state;
    const struct dense_shape eval = {120, 512, 7, 3}, sampling = {3, 256, 4, 768};
    assert_int_equal(dense_parameters(&eval), 1902083);
    assert_int_equal(dense_parameters(&sampling), 461568);
    int skips[2] = {0, 0};
    for (int l = 0; l < dense_layer_count(&eval); l++) skips[0] += dense_layer_at(&eval, l).skip;
    for (int l = 0; l < dense_layer_count(&sampling); l++) skips[1] += dense_layer_at(&sampling, l).skip;
    assert_int_equal(skips[0], 3);
    assert_int_equal(skips[1], 2);
}

static void random_numbers(float *to, size_t count, uint64_t seed) {
    struct sampler s = sampler_make(seed, 5, 0);
    for (size_t i = 0; i < count; i++) to[i] = 2 * sampler_1d(&s) - 1;
}

static const struct dense_shape shapes[] = {{5, 7, 0, 2}, {9, 24, 3, 3}, {33, 50, 4, 70}, {120, 96, 7, 3}};
enum { SHAPES = sizeof shapes / sizeof *shapes };

static double weighted_output(const struct dense_shape *shape, const float *parameters, float *x, const float *d_z) {
    dense_forward(shape, parameters, x);
    const float *z = x + dense_activations(shape) - shape->outputs;
    double sum = 0;
    for (int i = 0; i < shape->outputs; i++) sum += (double)(z[i] * d_z[i]);
    return sum;
}

static void test_gradient_by_differences(void **state) {
    (void)state;
    const struct dense_shape *shape = &shapes[1];
    const size_t count = dense_parameters(shape), activations = dense_activations(shape);
    float *p = malloc(count * 4), *d_p = calloc(count, 4), *x = malloc(activations * 4), *d_x = malloc(activations * 4);
    dense_init(shape, p, 3);
    random_numbers(x, activations, 1);
    for (size_t i = 0; i < count; i++) p[i] += 0.02f * sinf((float)i); // biases too
    float *d_z = d_x + activations - shape->outputs;
    random_numbers(d_z, 3, 2);
    const float given[3] = {d_z[0], d_z[1], d_z[2]};
    dense_forward(shape, p, x);
    dense_backward(shape, p, x, d_x, d_p);
    size_t agree = 0, compared = 0;
    for (size_t i = 0; i < count + (size_t)shape->inputs; i++) {
        float *at = i < count ? &p[i] : &x[i - count], kept = *at;
        double f[2];
        for (int side = 0; side < 2; side++) {
            *at = kept + (side ? -1e-3f : 1e-3f);
            f[side] = weighted_output(shape, p, x, given);
        }
        *at = kept;
        float expected = i < count ? d_p[i] : d_x[i - count];
        compared++;
        agree += fabs((f[0] - f[1]) / 2e-3 - (double)expected) < 2e-3 + 2e-3 * fabs((double)expected);
    }
    assert_true((double)agree > 0.99 * (double)compared); // the rest: a relu that changed sides
    free(p);
    free(d_p);
    free(x);
    free(d_x);
}

// c = relu(a b + bias + add) for odd rows and depths, every number of columns, both kernels.
static void test_gemm(void **state) {
    (void)state;
    enum { ROWS = 29, DEPTH = 37, COLUMNS = 80, STRIDE = 96 };
    static _Alignas(64) float a[ROWS * DEPTH], b[DEPTH * STRIDE], bias[ROWS], add[ROWS * STRIDE], c[ROWS * STRIDE];
    random_numbers(a, ROWS * DEPTH, 1);
    random_numbers(b, DEPTH * STRIDE, 2);
    random_numbers(bias, ROWS, 3);
    random_numbers(add, ROWS * STRIDE, 4);
    const struct kernel *kernels[] = {&kernel_avx2, kernel_best()};
    for (int i = 0; i < 2; i++)
        for (size_t columns = NET_LANES; columns <= COLUMNS; columns += NET_LANES)
            for (int relu = 0; relu < 2; relu++) {
                float *packed = malloc(gemm_packed_count(kernels[i]->gemm_tile, ROWS, DEPTH) * sizeof(float));
                gemm_pack(kernels[i]->gemm_tile, ROWS, DEPTH, a, DEPTH, 1, packed);
                for (int k = 0; k < ROWS * STRIDE; k++) c[k] = 77;
                struct gemm gemm = {ROWS, DEPTH, columns, packed, b, STRIDE, bias, add, relu, c, STRIDE};
                kernels[i]->gemm(&gemm);
                for (size_t r = 0; r < ROWS; r++)
                    for (size_t s = 0; s < STRIDE; s++) {
                        double sum = (double)(bias[r] + add[r * STRIDE + s]);
                        for (size_t k = 0; k < DEPTH; k++) sum += (double)(a[r * DEPTH + k] * b[k * STRIDE + s]);
                        if (relu) sum = fmax(sum, 0);
                        assert_float_equal(c[r * STRIDE + s], s < columns ? (float)sum : 77, 2e-5);
                    }
                free(packed);
            }
}

static void test_packed_matches_reference(void **state) {
    (void)state;
    static const int counts[] = {1, 3, 16, 17, 31, 47, 63, DENSE_SLICE};
    static _Alignas(64) float x[120 * DENSE_SLICE], z[DENSE_MAX_OUTPUTS * DENSE_SLICE];
    for (int t = 0; t < SHAPES; t++) {
        const struct dense_shape *shape = &shapes[t];
        float *p = malloc(dense_parameters(shape) * 4), *one = malloc(dense_activations(shape) * 4);
        dense_init(shape, p, 3);
        for (size_t i = 0; i < dense_parameters(shape); i++) p[i] += 0.01f * sinf((float)i);
        struct dense_packed packed;
        assert_int_equal(dense_packed_init(&packed, shape, NULL), 0);
        dense_packed_set(&packed, p);
        random_numbers(x, 120 * DENSE_SLICE, 9);
        for (size_t k = 0; k < sizeof counts / sizeof *counts; k++) {
            dense_packed_forward(&packed, counts[k], x, z);
            for (int s = 0; s < counts[k]; s++) {
                for (int i = 0; i < shape->inputs; i++) one[i] = x[i * DENSE_SLICE + s];
                dense_forward(shape, p, one);
                const float *expected = one + dense_activations(shape) - shape->outputs;
                for (int o = 0; o < shape->outputs; o++)
                    assert_float_equal(z[o * DENSE_SLICE + s], expected[o], 2e-5f * (1 + fabsf(expected[o])));
            }
        }
        dense_packed_fini(&packed);
        free(p);
        free(one);
    }
}

struct problem {
    const struct dense_shape *shape;
    size_t n;
};

static void problem_inputs(const void *user, size_t first, int count, float *x) {
    const struct problem *problem = user;
    for (int s = 0; s < count; s++) {
        struct sampler sampler = sampler_make(4, problem->n, first + (size_t)s);
        for (int i = 0; i < problem->shape->inputs; i++) x[i * DENSE_SLICE + s] = 2 * sampler_1d(&sampler) - 1;
    }
}

static float problem_target(const float *x, int output) {
    return sinf(2 * x[0] + (float)output) * x[DENSE_SLICE] + 0.3f * x[2 * DENSE_SLICE];
}

static double problem_loss(const void *user, size_t first, int count, const float *z, float *d_z) {
    const struct problem *problem = user;
    static _Thread_local float x[120 * DENSE_SLICE];
    problem_inputs(user, first, count, x);
    double loss = 0;
    for (int o = 0; o < problem->shape->outputs; o++)
        for (int s = 0; s < count; s++) {
            float difference = z[o * DENSE_SLICE + s] - problem_target(x + s, o);
            d_z[o * DENSE_SLICE + s] = 2 * difference / (float)problem->n;
            loss += (double)(difference * difference) / (double)problem->n;
        }
    return loss;
}

// After one step from zero moments every parameter has moved by about the rate against its gradient's sign, and the
// moments hold the gradient itself: compared with the reference's.
static void test_training_gradient_matches_reference(void **state) {
    (void)state;
    static const size_t sizes[] = {1, 63, 300, 512};
    for (int t = 0; t < SHAPES; t++)
        for (size_t k = 0; k < sizeof sizes / sizeof *sizes; k++) {
            const struct dense_shape *shape = &shapes[t];
            struct problem problem = {shape, sizes[k]};
            struct dense_trainer trainer;
            assert_int_equal(dense_trainer_init(&trainer, shape, 512, 8, NULL), 0);
            const size_t count = dense_parameters(shape), activations = dense_activations(shape);
            float *before = malloc(count * 4), *d_p = calloc(count, 4);
            float *x = malloc(activations * 4), *d_x = malloc(activations * 4);
            memcpy(before, trainer.parameters, count * 4);
            struct dense_batch batch = {sizes[k], &problem, problem_inputs, problem_loss};
            double loss = dense_trainer_step(&trainer, &batch, 1), expected_loss = 0;
            for (size_t i = 0; i < sizes[k]; i++) {
                static float slice[120 * DENSE_SLICE];
                problem_inputs(&problem, i, 1, slice);
                for (int j = 0; j < shape->inputs; j++) x[j] = slice[j * DENSE_SLICE];
                dense_forward(shape, before, x);
                for (int o = 0; o < shape->outputs; o++) {
                    float difference = x[activations - (size_t)shape->outputs + (size_t)o] - problem_target(slice, o);
                    d_x[activations - (size_t)shape->outputs + (size_t)o] = 2 * difference / (float)sizes[k];
                    expected_loss += (double)(difference * difference) / (double)sizes[k];
                }
                dense_backward(shape, before, x, d_x, d_p);
            }
            assert_float_equal(loss, expected_loss, 1e-4 * expected_loss);
            for (size_t i = 0; i < count; i++) {
                float gradient = trainer.moments[i] / 0.5f;
                assert_float_equal(gradient, d_p[i], 2e-5f + 1e-4f * fabsf(d_p[i]));
                if (fabsf(d_p[i]) > 1e-3f)
                    assert_float_equal(trainer.parameters[i] - before[i], copysignf(1e-4f, -d_p[i]), 2e-6);
            }
            free(before);
            free(d_p);
            free(x);
            free(d_x);
            dense_trainer_fini(&trainer);
        }
}

static double train(struct dense_trainer *trainer, const struct dense_shape *shape, size_t n, int steps, int threads) {
    assert_int_equal(dense_trainer_init(trainer, shape, n, 8, NULL), 0);
    double loss = 0;
    struct problem problem = {shape, n};
    struct dense_batch batch = {n, &problem, problem_inputs, problem_loss};
    for (int step = 0; step < steps; step++) loss = dense_trainer_step(trainer, &batch, threads);
    return loss;
}

static void test_training_converges(void **state) {
    (void)state;
    struct dense_trainer trainer;
    double first = train(&trainer, &shapes[1], 300, 1, 1);
    dense_trainer_fini(&trainer);
    double last = train(&trainer, &shapes[1], 300, 3000, 1);
    dense_trainer_fini(&trainer);
    printf("loss %.5f, then %.5f\n", first, last);
    assert_true(last < 0.1 * first);
}

static void test_threads_do_not_matter(void **state) {
    (void)state;
    struct dense_trainer a, b;
    train(&a, &shapes[2], 777, 3, 1);
    train(&b, &shapes[2], 777, 3, 3);
    assert_memory_equal(a.parameters, b.parameters, dense_parameters(&shapes[2]) * sizeof(float));
    dense_trainer_fini(&a);
    dense_trainer_fini(&b);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_counts),
        cmocka_unit_test(test_gradient_by_differences),
        cmocka_unit_test(test_gemm),
        cmocka_unit_test(test_packed_matches_reference),
        cmocka_unit_test(test_training_gradient_matches_reference),
        cmocka_unit_test(test_training_converges),
        cmocka_unit_test(test_threads_do_not_matter),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
