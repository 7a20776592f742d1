// Every light of the table, in one or more scenes: the directions of sample_light against pdf_light (chi-square), the
// emission densities against pdf_emission, the emitted flux against `power`, and irradiance from light samples against
// irradiance from traced particles.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "../../chi_square.h"
#include "../../scene_from_text.h"
#include "image/image.h"
#include "math/sampler.h"

static const struct light_case {
    const char *type, *text;
    vec3 p;

} cases[] = {
    {"area",
     "<shape type='rectangle'><emitter type='area'><rgb name='radiance' value='1 2 3'/></emitter></shape>",
     {0.3f, 0.2f, 0.8f}},
    {"area", "<shape type='sphere'><float name='radius' value='0.7'/><emitter type='area'/></shape>", {0.3f, 0.2f, 2}},
    {"area",
     "<shape type='sphere'><float name='radius' value='0.7'/><boolean name='flip_normals' value='true'/><emitter "
     "type='area'/></shape>",
     {0.3f, 0.2f, 0.4f}},
    {"area",
     "<shape type='disk'><transform name='to_world'><scale x='1' y='0.5' z='1'/></transform><emitter "
     "type='area'/></shape>",
     {0.3f, 0.2f, 0.5f}},
    {"area", "<shape type='cylinder'><emitter type='area'/></shape>", {1.9f, 0.2f, 0.8f}},
    {"area", "<shape type='cube'><emitter type='area'/></shape>", {1.9f, 0.2f, 1.8f}},
    {"point",
     "<emitter type='point'><point name='position' x='0.1' y='0.2' z='3'/></emitter><shape type='sphere'/>",
     {0, 0, 2}},
    {"spot",
     "<emitter type='spot'><float name='cutoff_angle' value='50'/><transform name='to_world'><lookat origin='1,2,3' "
     "target='0,0,0' up='0,1,0'/></transform></emitter><shape type='sphere'/>",
     {0, 0, 2}},
    {"directional",
     "<emitter type='directional'><vector name='direction' x='1' y='-1' z='0.2'/></emitter><shape type='sphere'/>",
     {0, 0, 1.3f}},
    {"constant", "<emitter type='constant'/><shape type='sphere'/>", {0, 0, 1.3f}},
    {"envmap",
     "<emitter type='envmap'><string name='filename' value='/tmp/sconce_test_env.exr'/><transform "
     "name='to_world'><rotate x='1' y='2' z='3' angle='40'/></transform></emitter><shape type='sphere'/>",
     {0, 0, 1.3f}},
};
enum { CASES = sizeof cases / sizeof *cases };

struct target {
    const struct scene *scene;
    const struct emitter *emitter;
    vec3 p;
};

static void write_envmap(void) {
    struct image image;
    struct error error;
    assert_int_equal(image_init(&image, 8, 5, 3, &error), STATUS_OK);
    struct sampler s = sampler_make(3, 0, 0);
    for (int i = 0; i < 8 * 5 * 3; ++i) image.pixels[i] = sampler_1d(&s);
    for (int i = 0; i < 9; ++i) image.pixels[24 + i] = i < 3 ? 6 : 0;
    assert_int_equal(image_save(&image, "/tmp/sconce_test_env.exr", 1, &error), STATUS_OK);
    image_fini(&image);
}

static void load_case(struct scene *scene, const struct light_case *c) {
    struct error error = {0};
    if (scene_from_text(scene, c->text, &error) != STATUS_OK) fail_msg("%s: %s", c->type, error.text);
    assert_int_equal(scene->emitter_count, 1);
}

static bool sample_direction(void *user, uint64_t index, vec3 *w) {
    const struct target *t = user;
    struct sampler s = sampler_make(7, 0, index);
    struct light_sample sample;
    if (!t->emitter->type->sample_light(t->emitter, t->p, sampler_2d(&s), &sample)) return false;
    *w = sample.direction;
    return true;
}

static double direction_pdf(void *user, vec3 w) {
    const struct target *t = user;
    w = vec3_normalize(w);
    struct ray ray = {t->p, w, 0, INFINITY};
    struct surface surface, *hit = NULL;
    if (t->emitter->shape) {
        if (!scene_intersect(t->scene, &ray, -1, &surface)) return 0;
        hit = &surface;
    }
    if (rgb_is_black(t->emitter->type->eval(t->emitter, hit, vec3_neg(w)))) return 0;
    return (double)t->emitter->type->pdf_light(t->emitter, t->p, hit, w);
}

// The density of a lamp jumps at its silhouette and grows there without bound, so each cell's expectation is the mean
// over a stratified grid instead of a quadrature; cells where few are expected are counted together.
static struct chi_square test_directions(struct target *target) {
    enum { ROWS = 12, COLUMNS = 24, FINE = 64, SAMPLES = 100000 };
    static struct chi_square_cell cells[ROWS * COLUMNS + 2];
    memset(cells, 0, sizeof cells);
    double integral = 0, failed = 0;
    struct sampler s = sampler_make(5, 0, 0);
    for (int cell = 0; cell < ROWS * COLUMNS; ++cell) {
        double sum = 0;
        for (int k = 0; k < FINE * FINE; ++k) {
            vec2 u = sampler_2d(&s);
            double z = -1 + 2 * (cell / COLUMNS + (k / FINE + (double)u.x) / FINE) / ROWS;
            double phi = 2 * M_PI * (cell % COLUMNS + (k % FINE + (double)u.y) / FINE) / COLUMNS, r = sqrt(1 - z * z);
            sum += direction_pdf(target, vec3_make((float)(r * cos(phi)), (float)(r * sin(phi)), (float)z));
        }
        double share = sum / (FINE * FINE) * 4 * M_PI / (ROWS * COLUMNS);
        cells[cell].expected = share * SAMPLES;
        integral += share;
    }
    for (uint64_t i = 0; i < SAMPLES; ++i) {
        vec3 w;
        if (!sample_direction(target, i, &w)) {
            ++failed;
            continue;
        }
        int row = (int)((w.z + 1) * 0.5f * ROWS),
            column = (int)((atan2f(w.y, w.x) * 0.5f * INV_PI_F + 1) * COLUMNS) % COLUMNS;
        ++cells[(row < ROWS ? row : ROWS - 1) * COLUMNS + column].observed;
    }
    struct chi_square_cell *rare = cells + ROWS * COLUMNS, *none = rare + 1;
    *none = (struct chi_square_cell){failed, fmax(0, 1 - integral) * SAMPLES};
    for (int cell = 0; cell < ROWS * COLUMNS; ++cell) {
        if (cells[cell].expected >= 50) continue;
        rare->expected += cells[cell].expected;
        rare->observed += cells[cell].observed;
        cells[cell] = (struct chi_square_cell){0, 0};
    }
    if (failed < 1 && integral < 1.01) *none = (struct chi_square_cell){0, 0}; // within the grid's error
    struct chi_square result = chi_square_counts(cells, sizeof cells / sizeof *cells);
    result.sampled = 1 - failed / SAMPLES;
    result.integral = integral;
    return result;
}

static void directions_follow_pdf(void **state) {
    (void)state;
    double level = chi_square_sidak(1e-3, CASES);
    bool passes = true;
    for (int i = 0; i < CASES; ++i) {
        struct scene scene;
        load_case(&scene, &cases[i]);
        struct target target = {&scene, scene.emitters[0], cases[i].p};
        if (!(target.emitter->flags & (EMITTER_DELTA_POSITION | EMITTER_DELTA_DIRECTION)))
            passes = chi_square_passes(cases[i].text, test_directions(&target), level) && passes;
        scene_fini(&scene);
    }
    assert_true(passes);
}

static void close_to(const char *what, const char *text, double a, double b, double tolerance) {
    if (!(fabs(a - b) <= tolerance)) fail_msg("%s: %g instead of %g (+- %g) for %s", what, a, b, tolerance, text);
}

// Samples' own figures agree with eval and the pdf functions; flux agrees with `power`.
static void samples_are_consistent(void **state) {
    (void)state;
    for (int i = 0; i < CASES; ++i) {
        struct scene scene;
        load_case(&scene, &cases[i]);
        const struct emitter *e = scene.emitters[0];
        bool delta = e->flags & (EMITTER_DELTA_POSITION | EMITTER_DELTA_DIRECTION);
        double flux = 0, flux2 = 0;
        int count = 40000;
        for (int k = 0; k < count; ++k) {
            struct sampler s = sampler_make(9, 1, (uint64_t)k);
            struct light_sample light;
            vec2 u = sampler_2d(&s), v = sampler_2d(&s);
            if (!delta && e->type->sample_light(e, cases[i].p, u, &light)) {
                const struct surface *on = e->shape ? &light.surface : NULL;
                // Near an environment map's poles the density is 1 / sin(theta): a direction's rounding changes it.
                double pdf = (double)e->type->pdf_light(e, cases[i].p, on, light.direction);
                close_to("light pdf", cases[i].text, pdf, (double)light.pdf_sa, 2e-3 * pdf + 3e-6 * pdf * pdf);
                rgb radiance = e->type->eval(e, on, vec3_neg(light.direction));
                close_to("light radiance", cases[i].text, (double)radiance.g, (double)light.radiance.g, 1e-3);
            }
            struct emission_sample sample;
            if (!e->type->sample_emission(e, u, v, &sample)) continue;
            float pdf_position, pdf_direction;
            e->type->pdf_emission(e, e->shape ? &sample.surface : NULL, sample.ray.direction, &pdf_position,
                                  &pdf_direction);
            close_to("emission pdf", cases[i].text, (double)pdf_direction, (double)sample.pdf_direction,
                     2e-3 * (double)pdf_direction + 3e-6 * (double)(pdf_direction * pdf_direction));
            close_to("position pdf", cases[i].text, (double)pdf_position, (double)sample.pdf_position,
                     1e-6 * (double)pdf_position);
            double weight =
                (double)(sample.radiance.g * sample.cos_theta / (sample.pdf_position * sample.pdf_direction));
            flux += weight / count;
            flux2 += weight * weight / count;
        }
        double sigma = sqrt(fmax(0, flux2 - flux * flux) / count);
        close_to("flux", cases[i].text, flux, (double)e->power.g, 4 * sigma + 2e-3 * flux);
        scene_fini(&scene);
    }
}

// Flux through a small sphere-shaped probe: every light gives pi R^2 times the integral of radiance over directions
// (fluence), whether measured by light samples at the probe's centre averaged over the probe or by particles crossing
// it.
static void particles_agree_with_light_samples(void **state) {
    (void)state;
    for (int i = 0; i < CASES; ++i) {
        struct scene scene;
        load_case(&scene, &cases[i]);
        const struct emitter *e = scene.emitters[0];
        float radius = 0.15f;
        double volume = 4.0 / 3 * M_PI * pow((double)radius, 3), sums[2] = {0}, squares[2] = {0};
        int count = 400000;
        for (int k = 0; k < count; ++k) {
            struct sampler s = sampler_make(11, 2, (uint64_t)k);
            vec2 u = sampler_2d(&s), v = sampler_2d(&s), a = sampler_2d(&s);
            float r = radius * cbrtf(sampler_1d(&s)), z = 1 - 2 * a.x, q = sqrtf(fmaxf(0, 1 - z * z));
            vec3 p = vec3_mad(vec3_make(q * cosf(2 * PI_F * a.y), q * sinf(2 * PI_F * a.y), z), r, cases[i].p);
            double value[2] = {0};
            struct light_sample light;
            if (e->type->sample_light(e, p, u, &light)) {
                struct ray ray = {p, light.direction, 0, light.distance * (1 - 1e-4f)};
                value[0] = (double)(light.radiance.g * scene_visibility(&scene, &ray, -1).g / light.pdf_sa);
            }
            struct emission_sample emission;
            if (e->type->sample_emission(e, u, v, &emission)) { // fluence = track length of flux per volume
                vec3 o = vec3_sub(emission.ray.origin, cases[i].p);
                float middle = -vec3_dot(o, emission.ray.direction), gap = vec3_dot(o, o) - middle * middle;
                struct surface hit;
                if (gap < radius * radius) {
                    float half = sqrtf(radius * radius - gap), t0 = fmaxf(middle - half, 0), t1 = middle + half;
                    if (scene_intersect(&scene, &emission.ray, -1, &hit)) t1 = fminf(t1, hit.t);
                    double weight = (double)(emission.radiance.g * emission.cos_theta /
                                             (emission.pdf_position * emission.pdf_direction));
                    value[1] = weight * fmax(0, (double)(t1 - t0)) / volume;
                }
            }
            for (int m = 0; m < 2; ++m) sums[m] += value[m] / count, squares[m] += value[m] * value[m] / count;
        }
        double sigma = 0;
        for (int m = 0; m < 2; ++m) sigma += fmax(0, squares[m] - sums[m] * sums[m]) / count;
        assert_true(sums[0] > 0);
        if (!(4 * sqrt(sigma) < 0.3 * sums[0]))
            print_message("weak test: %g of %g, %s\n", 4 * sqrt(sigma), sums[0], cases[i].text);
        close_to("fluence by particles", cases[i].text, sums[1], sums[0], 4 * sqrt(sigma) + 1e-3 * sums[0]);
        scene_fini(&scene);
    }
}

static void every_type_has_a_case(void **state) {
    (void)state;
    for (const struct emitter_type *const *type = emitter_table; *type; ++type) {
        bool found = false;
        for (int i = 0; i < CASES; ++i) found = found || strcmp(cases[i].type, (*type)->name) == 0;
        if (!found) fail_msg("no case for %s", (*type)->name);
    }
}

int main(void) {
    write_envmap();
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_type_has_a_case),
        cmocka_unit_test(directions_follow_pdf),
        cmocka_unit_test(samples_are_consistent),
        cmocka_unit_test(particles_agree_with_light_samples),
    };
    int result = cmocka_run_group_tests(tests, NULL, NULL);
    remove("/tmp/sconce_test_env.exr");
    return result;
}
