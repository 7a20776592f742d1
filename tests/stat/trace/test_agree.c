// The three integrators share the scene but not their technique: path tracing, bidirectional and light tracing must
// give the same picture. A z-test for every block of the image and colour; the level is split over all of them by
// Sidak's correction (Subr and Arvo 2007, "Statistical Hypothesis Testing for Assessing Monte Carlo Estimators").
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "../../render_image.h"

extern const struct integrator_type path_integrator, bdpt_integrator, particle_integrator;

enum { block = 8, seed = 11 };
static const double level = 1e-3; // chance that a correct program fails a whole comparison

struct case_ {
    const char *name;
    int path_passes, bdpt_passes, particle_passes; // 0: this one cannot see the scene
    double
        worst; // a block's standard error may be this share of its own or the image's mean, else the test says nothing
};
static const struct case_ cases[] = {
    {"box_area", 128, 64, 512, 0.1},
    {"rough_lamp", 512, 128, 512, 0.1},
    {"glass_shell", 0, 384, 1024, 0.1},
    {"textured_lamp", 128, 64, 512, 0.1},
    {"spot", 128, 64, 512, 0.1},
    {"point", 128, 64, 512, 0.1},
    {"envmap", 256, 128, 1024, 0.1},
    {"constant", 128, 64, 1024, 0.1},
    {"thinlens", 128, 64, 512, 0.1},
    {"orthographic", 128, 64, 512, 0.1},
    {"mask", 128, 64, 512, 0.1},
    {"mirror", 512, 128, 512, 0.1},
    {"glass_shell_mirror", 0, 384, 1024, 0.1},
    {"mirrors_coat_mask", 512, 128, 0, 0.1},
};

static double z_limit(double chance, int tests) { // two-sided, by bisection of erfc
    double each = 1 - pow(1 - chance, 1.0 / tests), low = 0, high = 20;
    for (int i = 0; i < 80; i++) {
        double z = (low + high) / 2;
        if (erfc(z / sqrt(2)) > each)
            low = z;
        else
            high = z;
    }
    return low;
}

// The mean over a block of one channel and its variance.
static void block_mean(const struct rendering *r, int x0, int y0, int channel, double *mean, double *variance) {
    *mean = *variance = 0;
    for (int y = y0; y < y0 + block; y++)
        for (int x = x0; x < x0 + block; x++) {
            const float *pixel = r->image.pixels + 6 * ((size_t)y * (size_t)r->width + (size_t)x);
            *mean += pixel[channel];
            *variance += pixel[3 + channel];
        }
    *mean /= block * block;
    *variance /= (double)block * block * block * block;
}

static int compare(const char *scene, const char *a_name, const struct rendering *a, const char *b_name,
                   const struct rendering *b, double worst) {
    int nx = a->width / block, ny = a->height / block, failures = 0;
    double limit = z_limit(level, nx * ny * 3), largest = 0, largest_error = 0,
           scale = (a->mean[0] + a->mean[1] + a->mean[2]) / 3;
    for (int i = 0; i < nx * ny * 3; i++) {
        double am, av, bm, bv;
        block_mean(a, i / 3 % nx * block, i / 3 / nx * block, i % 3, &am, &av);
        block_mean(b, i / 3 % nx * block, i / 3 / nx * block, i % 3, &bm, &bv);
        double error = sqrt(av + bv), z = error > 0                      ? fabs(am - bm) / error
                                          : fabs(am - bm) > 1e-6 * scale ? INFINITY
                                                                         : 0;
        largest = fmax(largest, z);
        largest_error = fmax(largest_error, error / fmax(scale, am));
        if (z > limit || error > worst * fmax(scale, am)) {
            failures++;
            print_error("%s: block (%d, %d) channel %d: %s %g +- %g, %s %g +- %g\n", scene, i / 3 % nx, i / 3 / nx,
                        i % 3, a_name, am, sqrt(av), b_name, bm, sqrt(bv));
        }
    }
    print_message("%s: %s %.4f, %s %.4f (green), largest z %.2f of %.2f, largest standard error %.1f %%\n", scene,
                  a_name, a->mean[1], b_name, b->mean[1], largest, limit, 100 * largest_error);
    return failures;
}

static void test_scene(void **state) {
    const struct case_ *c = *state;
    const struct integrator_type *types[] = {&bdpt_integrator, &path_integrator, &particle_integrator};
    const int passes[] = {c->bdpt_passes, c->path_passes, c->particle_passes};
    struct rendering r[3] = {0};
    int failures = 0;
    for (int i = 0; i < 3; i++) {
        char path[512];
        struct error error = {0};
        snprintf(path, sizeof path, SOURCE_DIR "/tests/scenes/%s.xml", c->name);
        if (passes[i] && render_file(path, types[i], passes[i], 1, seed + (uint64_t)i, &r[i], &error) != STATUS_OK)
            fail_msg("%s", error.text);
        if (i && passes[i]) failures += compare(c->name, types[0]->name, &r[0], types[i]->name, &r[i], c->worst);
    }
    for (int i = 0; i < 3; i++) image_fini(&r[i].image);
    assert_int_equal(failures, 0);
}

int main(void) {
    enum { count = sizeof cases / sizeof *cases };
    struct CMUnitTest tests[count];
    for (int i = 0; i < count; i++)
        tests[i] = (struct CMUnitTest){cases[i].name, test_scene, NULL, NULL, (void *)&cases[i]};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
