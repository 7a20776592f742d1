// Every BSDF of the table, in several settings, against independent numerical integration:
// samples follow the density (chi-square); densities integrate to the share of smooth samples; weights, values and
// densities belong together; nothing gains energy; value and adjoint are each other's mirror (Veach 1997, 5.2).
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "math/sampler.h"
#include "../../bsdf_from_xml.h"
#include "../../chi_square.h"

#define GGX(alpha) "<string name='distribution' value='ggx'/><float name='alpha' value='" alpha "'/>"
#define BECKMANN(alpha) "<string name='distribution' value='beckmann'/><float name='alpha' value='" alpha "'/>"
#define MATT "<bsdf type='diffuse'><rgb name='reflectance' value='0.2 0.5 0.9'/></bsdf>"
#define METAL "<bsdf type='roughconductor'>" GGX("0.3") "<string name='material' value='Au'/></bsdf>"
#define FROSTED "<bsdf type='roughdielectric'>" GGX("0.4") "</bsdf>"
#define THIN "<bsdf type='thindielectric'><rgb name='specular_transmittance' value='0.7 0.9 1'/></bsdf>"
// The shadowing function dims by the side of the light only: radiance and importance are not in a fixed ratio.
#define UNSHADOWED "<boolean name='use_shadowing_function' value='false'/>"
#define PRINCIPLED(settings) "<bsdf type='principled'><rgb name='base_color' value='0.2 0.5 0.9'/>" settings "</bsdf>"
#define CHECKER                                                                                                        \
    "<texture type='checkerboard'><float name='color0' value='0.2'/><float name='color1' value='0.7'/></texture>"

static const struct bsdf_case {
    const char *xml;
    bool coarse; // a lobe too narrow for the grid of the chi-square test
    bool not_mirrored; // shading normals, or a cosine of another frame: no symmetry to test
    bool lossless; // all light comes back or goes through, in delta parts
    bool generous; // an artists' model that can return more than it gets
} cases[] = {
    {.xml = MATT},
    {.xml = "<bsdf type='conductor'><string name='material' value='Cu'/></bsdf>"},
    {.xml = "<bsdf type='roughconductor'>" GGX("0.5") "</bsdf>"},
    {.xml = "<bsdf type='roughconductor'>" GGX("0.1") "<string name='material' value='Cu'/></bsdf>"},
    {.xml = "<bsdf type='roughconductor'>" BECKMANN("0.5") "</bsdf>"},
    {.xml = "<bsdf type='roughconductor'>" BECKMANN("0.1") "</bsdf>"},
    {.xml = "<bsdf type='roughconductor'><string name='distribution' value='ggx'/><float name='alpha_u' value='0.1'/>"
            "<float name='alpha_v' value='0.5'/></bsdf>"},
    {.xml =
         "<bsdf type='roughconductor'><string name='distribution' value='beckmann'/><float name='alpha_u' value='0.6'/>"
         "<float name='alpha_v' value='0.2'/></bsdf>"},
    {.xml = "<bsdf type='roughconductor'>" GGX("0.001") "</bsdf>", .coarse = true},
    {.xml = "<bsdf type='dielectric'/>", .lossless = true},
    {.xml = "<bsdf type='thindielectric'/>", .lossless = true},
    {.xml = THIN},
    {.xml = "<bsdf type='roughdielectric'>" GGX("0.5") "</bsdf>"},
    {.xml = "<bsdf type='roughdielectric'>" GGX("1") "<float name='int_ior' value='2.4'/></bsdf>"},
    {.xml = "<bsdf type='roughdielectric'>" GGX("0.1") "<rgb name='specular_reflectance' value='1 0.9 0.5'/></bsdf>"},
    {.xml = "<bsdf type='roughdielectric'>" GGX(
         "0.4") "<string name='int_ior' value='air'/><string name='ext_ior' value='water'/></bsdf>"},
    {.xml = "<bsdf type='roughdielectric'>" BECKMANN("0.3") "</bsdf>"},
    {.xml = "<bsdf type='roughdielectric'>" GGX("0.01") "</bsdf>", .coarse = true},
    {.xml = "<bsdf type='roughdielectric'>" GGX("0.001") "</bsdf>", .coarse = true},
    {.xml = "<bsdf type='roughdielectric'>" BECKMANN("0.01") "</bsdf>", .coarse = true},
    {.xml = "<bsdf type='difftrans'><rgb name='transmittance' value='0.1 0.5 1'/></bsdf>"},
    {.xml = "<bsdf type='mixturebsdf'><string name='weights' value='0.4 0.6'/>" MATT "<bsdf type='difftrans'/></bsdf>"},
    {.xml = "<bsdf type='plastic'><rgb name='diffuse_reflectance' value='0.1 0.5 1'/></bsdf>"},
    {.xml = "<bsdf type='plastic'><boolean name='nonlinear' value='true'/><float name='int_ior' value='1.9'/></bsdf>"},
    {.xml = "<bsdf type='roughplastic'>" GGX("0.3") "<rgb name='diffuse_reflectance' value='0.1 0.5 0.9'/></bsdf>"},
    {.xml = "<bsdf type='roughplastic'>" BECKMANN("0.15") "<boolean name='nonlinear' value='true'/></bsdf>"},
    {.xml = PRINCIPLED("")},
    {.xml = PRINCIPLED("<float name='roughness' value='0.3'/><float name='metallic' value='0.7'/>"
                       "<float name='anisotropic' value='0.8'/><float name='spec_tint' value='0.5'/>")},
    {.xml = PRINCIPLED("<float name='sheen' value='1'/><float name='sheen_tint' value='0.5'/><float name='flatness' "
                       "value='0.5'/>"),
     .generous = true},
    {.xml = PRINCIPLED("<float name='clearcoat' value='1'/><float name='specular' value='0'/>"), .generous = true},
    {.xml = PRINCIPLED("<float name='spec_trans' value='1'/><float name='roughness' value='0.6'/>")},
    {.xml = PRINCIPLED("<float name='spec_trans' value='1'/><float name='roughness' value='0.1'/>"), .coarse = true},
    {.xml =
         PRINCIPLED("<float name='spec_trans' value='0.6'/><float name='roughness' value='0.7'/><float name='metallic' "
                    "value='0.3'/><float name='eta' value='1.33'/><float name='clearcoat' value='0.7'/>"),
     .generous = true},
    {.xml = "<bsdf type='twosided'>" MATT METAL "</bsdf>"},
    {.xml = "<bsdf type='null'/>"},
    {.xml = "<bsdf type='mask'><rgb name='opacity' value='0.3 0.6 1'/>" MATT "</bsdf>"},
    {.xml = "<bsdf type='mask'><float name='opacity' value='0.4'/>" THIN "</bsdf>"},
    {.xml = "<bsdf type='blendbsdf'><float name='weight' value='0.3'/>" MATT METAL "</bsdf>"},
    {.xml = "<bsdf type='blendbsdf'><float name='weight' value='0.6'/>" FROSTED "<bsdf type='plastic'/></bsdf>"},
    {.xml = "<bsdf type='mixturebsdf'><string name='weights' value='0.2, 0.3 0.4'/>" FROSTED THIN MATT "</bsdf>"},
    {.xml = "<bsdf type='mixturebsdf'><string name='weights' value='0.5 0.5'/>" METAL "<bsdf type='mask'>" MATT
            "</bsdf></bsdf>"},
    {.xml = "<bsdf type='blendbsdf'><float name='weight' value='0.3'/><bsdf type='dielectric'/><bsdf "
            "type='thindielectric'/></bsdf>",
     .lossless = true},
    {.xml = "<bsdf type='mixturebsdf'><string name='weights' value='0.2 0.5 0.3'/><bsdf type='null'/><bsdf type='mask'>"
            "<rgb name='opacity' value='0.3 0.6 1'/><bsdf type='dielectric'/></bsdf><bsdf type='twosided'><bsdf "
            "type='conductor'/></bsdf>"
            "</bsdf>",
     .lossless = true},
    {.xml = "<bsdf type='bumpmap'>" CHECKER UNSHADOWED "<float name='scale' value='0.001'/>" METAL "</bsdf>",
     .not_mirrored = true},
    {.xml = "<bsdf type='mask'><bsdf type='twosided'><bsdf type='bumpmap'>" CHECKER UNSHADOWED
            "<float name='scale' value='0.002'/>" MATT "</bsdf></bsdf></bsdf>",
     .not_mirrored = true},
    {.xml = "<bsdf type='normalmap'><rgb name='normalmap' value='0.7 0.4 0.9'/>" UNSHADOWED FROSTED "</bsdf>",
     .not_mirrored = true},
};
enum { CASES = sizeof cases / sizeof *cases, SAMPLES = 60000 };

// Just left of a border of the checkerboard, so that its finite difference sees the step.
static const struct bsdf_point point = {{0.49995f, 0.2f}, {{1, 0.2f}, {-0.3f, 1}}};

static const float wi_angles[][2] = {{0.001f, 0}, {0.35f, 1}, {0.9f, 3}, {1.4f, 5}, {2.0f, 2}, {2.7f, 4}};
enum { ANGLES = sizeof wi_angles / sizeof *wi_angles };

static vec3 direction(double theta, double phi) {
    return vec3_normalize((vec3){(float)(sin(theta) * cos(phi)), (float)(sin(theta) * sin(phi)), (float)cos(theta)});
}

struct setting {
    const struct bsdf_case *c;
    const struct bsdf *bsdf;
    vec3 wi;
    enum transport transport;
    rgb through;
};

static bool setting_sample(const struct setting *s, uint64_t index, struct bsdf_sample *sample) {
    struct sampler sampler = sampler_make(7, 1, index);
    vec2 u = sampler_2d(&sampler);
    *sample = (struct bsdf_sample){.eta = NAN};
    return bsdf_sample(s->bsdf, &point, s->wi, (vec3){u.x, u.y, sampler_1d(&sampler)}, s->transport, sample);
}

static bool smooth_sample(void *user, uint64_t index, vec3 *w) {
    struct bsdf_sample sample;
    if (!setting_sample(user, index, &sample) || sample.delta) return false;
    *w = sample.wo;
    return true;
}

static double smooth_pdf(void *user, vec3 w) {
    const struct setting *s = user;
    return bsdf_pdf(s->bsdf, &point, s->wi, w, s->transport);
}

// The integrals over the sphere of the density and of the value's channels: in each hemisphere polar coordinates about
// `pole`, where its lobe is, with the logarithm of the angle, so that a lobe of any width is resolved.
struct integrals {
    double pdf, value[3];
};

static void integrate_hemisphere(const struct setting *s, vec3 pole, struct integrals *sum) {
    enum { rings = 500, sectors = 96 };
    const double lowest = log(1e-6), span = log(M_PI) - lowest;
    struct frame frame = frame_from_normal(pole);
    for (int i = 0; i < rings; ++i) {
        double theta = exp(lowest + (i + 0.5) / rings * span),
               area = sin(theta) * theta * span / rings * 2 * M_PI / sectors;
        for (int j = 0; j < sectors; ++j) {
            vec3 wo = frame_world_from_local(&frame, direction(theta, (j + 0.5) * 2 * M_PI / sectors));
            if ((wo.z > 0) != (pole.z > 0)) continue;
            rgb f = bsdf_eval(s->bsdf, &point, s->wi, wo, s->transport);
            sum->pdf += area * bsdf_pdf(s->bsdf, &point, s->wi, wo, s->transport);
            sum->value[0] += area * f.r;
            sum->value[1] += area * f.g;
            sum->value[2] += area * f.b;
        }
    }
}

static struct integrals integrate(const struct setting *s) {
    struct integrals sum = {0};
    vec3 mirror = {-s->wi.x, -s->wi.y, s->wi.z}, refracted = {-s->wi.x, -s->wi.y, -s->wi.z};
    for (uint64_t i = 0; i < 50; ++i) { // a smooth sample on the other side is near that lobe
        struct bsdf_sample sample;
        if (setting_sample(s, i, &sample) && sample.wo.z * s->wi.z < 0) refracted = sample.wo;
    }
    if (s->c->coarse) { // the lobe's own centre: Snell's law
        float eta = 1;
        for (uint64_t i = 0; i < 50; ++i) {
            struct bsdf_sample sample;
            if (setting_sample(s, i, &sample) && sample.wo.z * s->wi.z < 0) eta = sample.eta;
        }
        float x = -s->wi.x / eta, y = -s->wi.y / eta;
        refracted = (vec3){x, y, copysignf(sqrtf(fmaxf(0, 1 - x * x - y * y)), -s->wi.z)};
    }
    integrate_hemisphere(s, mirror, &sum);
    integrate_hemisphere(s, vec3_normalize(refracted), &sum);
    return sum;
}

static bool near_to(const struct setting *s, const char *what, double ours, double wanted, double tolerance) {
    if (fabs(ours - wanted) <= tolerance) return true;
    printf("%s wi %g %g %g, %s: %.6g, should be %.6g +- %.2g\n", s->c->xml, s->wi.x, s->wi.y, s->wi.z, what, ours,
           wanted, tolerance);
    return false;
}

// Samples against the integrals.
static int check_means(const struct setting *s) {
    double share = 0, sum[3] = {0}, square[3] = {0}, energy[3] = {0}, energy_square[3] = {0};
    const float *through = &s->through.r;
    for (uint64_t i = 0; i < SAMPLES; ++i) {
        struct bsdf_sample sample;
        if (!setting_sample(s, i, &sample)) continue;
        share += !sample.delta;
        for (int c = 0; c < 3; ++c) {
            double w = (&sample.weight.r)[c] * (1 - through[c]);
            sum[c] += sample.delta ? 0 : w;
            square[c] += sample.delta ? 0 : w * w;
            energy[c] += w;
            energy_square[c] += w * w;
        }
    }
    int bad = 0;
    struct integrals integrals = integrate(s);
    share /= SAMPLES;
    bad += !near_to(s, "integral of the density", integrals.pdf, share, 5 * sqrt(share * (1 - share) / SAMPLES) + 4e-3);
    for (int c = 0; c < 3; ++c) {
        double mean = sum[c] / SAMPLES, error = sqrt(fmax(0, square[c] / SAMPLES - mean * mean) / SAMPLES);
        bad += !near_to(s, "integral of the value", integrals.value[c], mean, 5 * error + 4e-3 * (1 + mean));
        mean = energy[c] / SAMPLES;
        error = sqrt(fmax(0, energy_square[c] / SAMPLES - mean * mean) / SAMPLES);
        if (s->transport == TRANSPORT_IMPORTANCE && s->c->lossless)
            bad += !near_to(s, "energy of a lossless bsdf", mean + through[c], 1, 5 * error + 1e-4);
        if (s->transport == TRANSPORT_IMPORTANCE && !s->c->generous && mean + through[c] > 1 + 5 * error + 1e-4) {
            printf("%s wi %g %g %g gains energy: %g\n", s->c->xml, s->wi.x, s->wi.y, s->wi.z, mean + through[c]);
            ++bad;
        }
    }
    return bad;
}

// One sample against eval and pdf, and eval against its mirror image.
static int check_pairs(const struct setting *s) {
    int bad = 0;
    double tolerance = s->c->coarse ? 0.05 : 2e-3; // rounding of directions against the lobe's width
    for (uint64_t i = 0; i < 400 && bad < 5; ++i) {
        struct bsdf_sample sample;
        if (!setting_sample(s, i, &sample)) continue;
        bad += !near_to(s, "length of wo", vec3_length(sample.wo), 1, 1e-4);
        bad +=
            !isfinite(rgb_mean(sample.weight)) || !(sample.pdf > 0) || !(sample.eta > 0) || rgb_max(sample.weight) < 0;
        if (sample.delta) continue;
        bool shallow = fabsf(sample.wo.z) < 1e-3f;
        double pdf = bsdf_pdf(s->bsdf, &point, s->wi, sample.wo, s->transport);
        rgb f = bsdf_eval(s->bsdf, &point, s->wi, sample.wo, s->transport);
        if (!shallow) bad += !near_to(s, "pdf of the sample", sample.pdf, pdf, tolerance * pdf);
        for (int c = 0; c < 3 && !shallow; ++c) {
            double value = (&f.r)[c], weight = (&sample.weight.r)[c] * (1 - (&s->through.r)[c]);
            bad += !near_to(s, "weight * pdf", weight * pdf, value, tolerance * (value + 1e-4));
        }
        if (s->c->not_mirrored || shallow) continue;
        enum transport other = s->transport == TRANSPORT_RADIANCE ? TRANSPORT_IMPORTANCE : TRANSPORT_RADIANCE;
        rgb g = bsdf_eval(s->bsdf, &point, sample.wo, s->wi, other);
        for (int c = 0; c < 3; ++c) {
            double value = (&f.r)[c] / fabsf(sample.wo.z), mirrored = (&g.r)[c] / fabsf(s->wi.z);
            bad += !near_to(s, "adjoint", mirrored, value, tolerance * (value + 1e-4));
        }
    }
    return bad;
}

// Radiance against importance: the same samples, weights in the ratio of the squared indices.
static int check_transport(struct setting s) {
    int bad = 0;
    for (uint64_t i = 0; i < 400 && bad < 5; ++i) {
        struct bsdf_sample radiance, importance;
        s.transport = TRANSPORT_RADIANCE;
        bool got = setting_sample(&s, i, &radiance);
        s.transport = TRANSPORT_IMPORTANCE;
        if (got != setting_sample(&s, i, &importance)) ++bad;
        if (!got || bad) continue;
        double scale = radiance.eta * radiance.eta, w = importance.weight.g;
        bad += !near_to(&s, "eta^2 between radiance and importance", radiance.weight.g * scale, w, 1e-4 * w + 1e-7);
        bool other_side = radiance.wo.z * s.wi.z < 0;
        if (!other_side) bad += !near_to(&s, "eta of a reflection", radiance.eta, 1, 0);
    }
    return bad;
}

static void test_table(void **state) {
    (void)state;
    int bad = 0, tests = 0;
    double level = chi_square_sidak(0.01, CASES * ANGLES);
    for (int i = 0; i < CASES; ++i) {
        struct xml_plugins plugins = {0};
        struct error error;
        struct setting s = {.c = &cases[i]};
        s.bsdf = xml_bsdf(&plugins, cases[i].xml, &error);
        if (!s.bsdf) xml_fail(&error);
        for (int a = 0; a < ANGLES; ++a) {
            s.wi = direction(wi_angles[a][0], wi_angles[a][1]);
            s.through = bsdf_through(s.bsdf, &point, s.wi);
            s.transport = a & 1 ? TRANSPORT_RADIANCE : TRANSPORT_IMPORTANCE;
            bad += check_means(&s) + check_pairs(&s) + check_transport(s);
            struct integrals integrals = integrate(&s);
            if (cases[i].coarse || integrals.pdf < 1e-3) continue;
            struct chi_square_direction test = {smooth_sample,      smooth_pdf, &s,
                                                .samples = SAMPLES, .rows = 20, .columns = 40};
            char name[500];
            snprintf(name, sizeof name, "%s angle %d", cases[i].xml, a);
            bad += !chi_square_passes(name, chi_square_test_directions(&test), level);
            ++tests;
        }
        xml_fini(&plugins);
    }
    printf("%d chi-square tests, %d findings\n", tests, bad);
    assert_true(tests > 60);
    assert_int_equal(bad, 0);
}

static void test_every_type_is_tested(void **state) {
    (void)state;
    for (size_t t = 0; bsdf_table[t]; ++t) {
        char wanted[100];
        snprintf(wanted, sizeof wanted, "<bsdf type='%s'", bsdf_table[t]->name);
        int found = 0;
        for (int i = 0; i < CASES; ++i) found += strstr(cases[i].xml, wanted) != NULL;
        if (!found) fail_msg("no setting of %s is tested", bsdf_table[t]->name);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_every_type_is_tested), cmocka_unit_test(test_table)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
