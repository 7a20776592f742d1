// Guided scattering: lobes against the chi-square test, clusters against sources that are known, and whole renderings
// of a room lit by way of its ceiling, a mirror and a polished floor with and without the guide.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#include "chi_square.h"
#include "math/sampler.h"
#include "render_path.h"
#include "trace/guide.h"

enum { RECORDS = 20000 };

// A dim square of 4 x 4 at height 3 that faces down, with a bright spot of 0.5 x 0.5 round (1, 0), and as many records
// from a wall at x = 5.
static void fill(struct guide_record *records) {
    for (uint64_t i = 0; i < RECORDS; i++) {
        struct sampler sampler = sampler_make(3, 0, i);
        const vec2 u = sampler_2d(&sampler);
        struct guide_record *record = &records[i];
        if (i % 2) {
            *record = (struct guide_record){{5, 4 * u.x - 2, 3 * u.y}, {-1, 0, 0}, 0.1f, 0.1f};
            continue;
        }
        const vec3 p = {4 * u.x - 2, 4 * u.y - 2, 3};
        const bool bright = fabsf(p.x - 1) < 0.25f && fabsf(p.y) < 0.25f;
        *record = (struct guide_record){p, {0, 0, -1}, bright ? 50 : 0.5f, bright ? 50 : 0.5f};
    }
}

static void learn(struct guide *guide) {
    struct guide_record *records = calloc(RECORDS, sizeof *records);
    assert_non_null(records);
    fill(records);
    guide_learn(guide, records, RECORDS);
    free(records);
}

static void test_clusters(void **unused) {
    (void)unused;
    static struct guide guide, again;
    learn(&guide);
    learn(&again);
    assert_memory_equal(&guide, &again, sizeof guide);
    size_t bright = 0;
    for (size_t k = 0; k < GUIDE_CLUSTERS; k++) {
        if (guide.radiance[k] < 25) continue;
        bright++;
        assert_true(fabsf(guide.x[k] - 1) < 0.3f && fabsf(guide.y[k]) < 0.3f && fabsf(guide.z[k] - 3) < 1e-3f);
        assert_true(guide.radiance[k] < 51);
        assert_true(guide.nz[k] < -0.99f);
    }
    assert_true(bright >= 4); // most of the light is there
    // E L^2 / (E L)^2: an eighth of a 64th part of the records at 50, the rest of their half at 0.5, half at 0.1.
    const double p = 0.5 / 64, mean = p * 50 + (0.5 - p) * 0.5 + 0.05;
    const double contrast = (p * 2500 + (0.5 - p) * 0.25 + 0.005) / (mean * mean);
    assert_true(fabs((double)guide.contrast - contrast) < 0.25 * contrast);
}

struct viewpoint {
    const struct guide *guide;
    struct guide_view view;
};

static bool sample_place(void *user, uint64_t index, vec3 *w) {
    const struct viewpoint *place = user;
    struct sampler sampler = sampler_make(11, 0, index);
    const float u_lobe = sampler_1d(&sampler);
    *w = guide_sample(&place->view, u_lobe, sampler_2d(&sampler));
    return true;
}

static double pdf_place(void *user, vec3 w) {
    const struct viewpoint *place = user;
    float radiance;
    return (double)guide_pdf(place->guide, &place->view, w, &radiance);
}

static void test_density(void **unused) {
    (void)unused;
    static struct guide guide;
    learn(&guide);
    const vec3 places[] = {{0, 0, 0}, {1, 0.1f, 2.8f}, {-5, 3, 1}, {4.9f, 0, 2}}, up = {0, 0, 1};
    const double level = chi_square_sidak(0.01, sizeof places / sizeof *places);
    for (size_t i = 0; i < sizeof places / sizeof *places; i++) {
        struct viewpoint place = {.guide = &guide};
        assert_true(guide_look(&guide, places[i], up, &place.view));
        struct chi_square_direction test = {
            .sample = sample_place, .pdf_sa = pdf_place, .user = &place, .samples = 200000, .rows = 20, .columns = 40};
        const struct chi_square result = chi_square_test_directions(&test);
        if (result.p < level) fail_msg("place %zu: p = %g", i, result.p);
        float radiance;
        const vec3 to_spot = vec3_normalize(vec3_sub((vec3){1, 0, 3}, places[i]));
        assert_true(guide_pdf(&guide, &place.view, to_spot, &radiance) > 1 / (4 * PI_F));
        assert_true(radiance > 25);
    }
    struct guide_view view;
    assert_false(guide_look(&guide, (vec3){0, 0, 5}, up, &view)); // the sources face away
}

// A lamp that only lights the ceiling, a mirror on the left and a polished floor.
static const char *const room =
    "<scene version='3.0.0'><integrator type='path'><integer name='max_depth' value='6'/></integrator>"
    "<sensor type='perspective'><float name='fov' value='70'/><transform name='to_world'><lookat origin='0,-1.9,0' "
    "target='0,2,-0.2' up='0,0,1'/></transform><film type='hdrfilm'><integer name='width' value='32'/><integer "
    "name='height' value='32'/><rfilter type='box'/></film></sensor>"
    "<bsdf type='diffuse' id='white'><rgb name='reflectance' value='0.6'/></bsdf>"
    "<shape type='cube'><transform name='to_world'><scale x='2' y='2' z='1.5'/></transform><boolean "
    "name='flip_normals' value='true'/><ref id='white'/></shape>"
    "<shape type='rectangle'><transform name='to_world'><scale x='1.9' y='1.9'/><translate z='-1.49'/></transform>"
    "<bsdf type='roughplastic'><float name='alpha' value='0.08'/><rgb name='diffuse_reflectance' value='0.3'/></bsdf>"
    "</shape>"
    "<shape type='rectangle'><transform name='to_world'><scale x='1' y='1.2'/><rotate y='1' angle='90'/><translate "
    "x='-1.98'/></transform><bsdf type='conductor'/></shape>"
    "<shape type='rectangle'><transform name='to_world'><scale x='0.15' y='0.15'/><translate x='0.8' y='0.8' "
    "z='1.2'/></transform><emitter type='area'><rgb name='radiance' value='200'/></emitter></shape></scene>";

static void render(struct rendering *result, bool forgetful, int threads) {
    size_t dropped;
    render_path(room, &(struct path_test){PATH_MIS, 512, threads, .seed = 5, .forgetful = forgetful}, result, &dropped);
    assert_int_equal(dropped, 0);
}

static void test_room(void **unused) {
    (void)unused;
    struct rendering with, without, twice;
    render(&with, false, 1);
    render(&without, true, 1);
    render(&twice, false, 2);
    const size_t count = (size_t)with.width * (size_t)with.height;
    assert_memory_equal(with.image.pixels, twice.image.pixels, 6 * count * sizeof(float));
    double relative[2] = {0}, chi2 = 0;
    for (size_t i = 0; i < count; i++) {
        const float *a = &with.image.pixels[6 * i], *b = &without.image.pixels[6 * i];
        const double level = 0.25 * ((double)a[1] + (double)b[1]) * ((double)a[1] + (double)b[1]) + 1e-3;
        relative[0] += (double)a[4] / level, relative[1] += (double)b[4] / level;
        const double difference = (double)a[1] - (double)b[1], noise = (double)a[4] + (double)b[4];
        if (noise > 0) chi2 += difference * difference / noise / (double)count;
    }
    const double error = hypot(with.error[1], without.error[1]);
    if (fabs(with.mean[1] - without.mean[1]) > 4 * error)
        fail_msg("mean %g guided, %g not (standard error %g)", with.mean[1], without.mean[1], error);
    assert_true(error < 0.02 * without.mean[1]); // else that says nothing
    assert_true(chi2 < 1.3);
    if (!(relative[0] < 0.7 * relative[1])) fail_msg("relative variance %g guided, %g not", relative[0], relative[1]);
    image_fini(&with.image);
    image_fini(&without.image);
    image_fini(&twice.image);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_clusters), cmocka_unit_test(test_density),
                                       cmocka_unit_test(test_room)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
