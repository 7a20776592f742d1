// Path tracer: guided scattering. Records of where paths got light from after their first scattering are collected from
// an even choice of the pixels, learned from between passes (guide.h), and then a share of the paths at every surface
// that scatters broadly takes its direction from there. A pass depends on earlier passes only, as with the roulette.
// The weights between light samples and scattering use the density of the BSDF alone, whoever drew the direction: any
// weights that sum to one are right, and the guide knows of scattered light only.
#include "trace/path_state.h"

#include <stdlib.h>

enum { REPORTS_A_PASS = 1 << 13, RECORDS_KEPT = 1 << 15, FIRST_LESSON = 1 << 12 };
enum { LEAST_STRIDE = 2 }; // recording every path would cost a tenth of the time
static const double outlier = 10; // of a path, relative to its pixel: more counts as this
static const double least_gain = 0.2; // of the variance, for which the guide is worth its time
static const float most_guided = 0.6f; // of the paths

struct moments {
    double sum, squares;
};

struct path_guide {
    struct guide guide;
    struct path_report *fresh; // of the running pass, for one of `stride` pixels
    size_t stride, phase; // stride 0: no pass has run; recorded are pixels with phase = index modulo stride
    struct guide_record *kept; // a ring
    struct guide_record *lesson; // a copy to be sorted
    size_t recorded, next_lesson;
    struct moments scattered, direct; // of the light in the paths heard of, relative to their pixels
    size_t heard;
    float share; // guided, of the paths at a broadly scattering surface
};

enum status path_guide_create(struct path_guide **result, struct error *error) {
    struct path_guide *guide = calloc(1, sizeof *guide);
    *result = guide;
    if (guide) {
        guide->fresh = calloc(REPORTS_A_PASS + 1, sizeof *guide->fresh);
        guide->kept = calloc(RECORDS_KEPT, sizeof *guide->kept);
        guide->lesson = calloc(RECORDS_KEPT, sizeof *guide->lesson);
    }
    if (!guide || !guide->fresh || !guide->kept || !guide->lesson)
        return error_set(error, STATUS_MEMORY, "out of memory for the guide");
    guide->next_lesson = FIRST_LESSON;
    return STATUS_OK;
}

void path_guide_destroy(struct path_guide *guide) {
    if (!guide) return;
    free(guide->fresh);
    free(guide->kept);
    free(guide->lesson);
    free(guide);
}

// --- Lessons ---
// The share of the paths that the guide may direct: less for deltas and narrow lobes, which it would miss; none for
// what transmits, whose other side it does not look at.
static float guided_at(const struct path_tracer *tracer, const struct surface *surface) {
    const struct lobe_shape lobes = path_lobes_at(tracer, surface);
    return lobes.smooth * lobes.broadness;
}

bool path_guide_listens(const struct path_tracer *tracer, const struct path *path) {
    const struct path_guide *guide = tracer->guide;
    return path->pixel % guide->stride == guide->phase && guided_at(tracer, &path->surface) > 0;
}

struct path_report *path_guide_report(const struct path_tracer *tracer, const struct path *path) {
    return &tracer->guide->fresh[path->pixel / tracer->guide->stride];
}

static float expected_at(const struct path_tracer *tracer, size_t pixel, float typical) {
    const size_t width = (size_t)tracer->film->width;
    if (tracer->expected[pixel] > 0) return tracer->expected[pixel];
    return path_expected_luminance(tracer->film, (int)(pixel % width), (int)(pixel / width), typical);
}

static void moments_add(struct moments *moments, double relative) {
    const double x = fmin(relative, outlier);
    moments->sum += x;
    moments->squares += x * x;
}

static double variance(const struct moments *moments, size_t count) {
    const double mean = moments->sum / (double)count;
    return fmax(moments->squares / (double)count - mean * mean, 0);
}

static void keep_fresh(struct path_tracer *tracer, struct path_guide *guide) {
    const float typical = tracer->typical > 0 ? tracer->typical : path_typical_luminance(tracer->film);
    const size_t pixels = (size_t)tracer->film->width * (size_t)tracer->film->height;
    for (size_t pixel = guide->phase; pixel < pixels; pixel += guide->stride) {
        const struct path_report *report = &guide->fresh[pixel / guide->stride];
        if (!(report->whole >= 0) || !isfinite(report->whole)) continue;
        const float expected = expected_at(tracer, pixel, typical);
        double scattered = 0;
        for (size_t part = 0; part < RECORD_PARTS; part++) {
            struct guide_record record = report->parts[part];
            if (!(record.radiance >= 0) || !isfinite(record.radiance) || !vec3_is_finite(record.p)) continue;
            record.share /= expected;
            scattered += (double)record.share;
            guide->kept[guide->recorded++ % RECORDS_KEPT] = record;
        }
        moments_add(&guide->scattered, scattered);
        moments_add(&guide->direct, (double)(report->whole / expected) - scattered);
        guide->heard++;
    }
}

// What a perfect guide would take from the variance: of the share that scattered light has in it, all that comes from
// the contrast of its sources. Once it pays it goes on paying, though from then on nobody can tell.
static void decide(struct path_guide *guide) {
    const double even = 1 / (double)guide->guide.contrast, scattered = variance(&guide->scattered, guide->heard);
    const double gain = (1 - even) * scattered / (scattered + variance(&guide->direct, guide->heard));
    if (guide->share > 0 || gain > least_gain) guide->share = minf((float)(1 - even), most_guided);
}

void path_guide_learn(struct path_tracer *tracer) {
    struct path_guide *guide = tracer->guide;
    const struct film *film = tracer->film;
    const size_t pixels = (size_t)film->width * (size_t)film->height;
    if (film->pass_count && guide->stride) keep_fresh(tracer, guide);
    guide->stride = (pixels + REPORTS_A_PASS - 1) / REPORTS_A_PASS;
    if (guide->stride < LEAST_STRIDE) guide->stride = LEAST_STRIDE;
    guide->phase = (size_t)tracer->pass % guide->stride;
    for (size_t i = 0; i < pixels / guide->stride + 1; i++) guide->fresh[i].whole = -1;
    if (guide->recorded < guide->next_lesson) return;
    while (guide->next_lesson <= guide->recorded) guide->next_lesson *= 2;
    const size_t count = guide->recorded < RECORDS_KEPT ? guide->recorded : RECORDS_KEPT;
    for (size_t i = 0; i < count; i++) guide->lesson[i] = guide->kept[i];
    guide_learn(&guide->guide, guide->lesson, count);
    if (guide->guide.contrast > 0) decide(guide);
}

// --- Scattering ---
static bool sample_bsdf(const struct path *path, vec3 u, struct bsdf_sample *sample) {
    if (!surface_sample_bsdf(&path->surface, vec3_neg(path->ray.direction), u, TRANSPORT_RADIANCE, sample))
        return false;
    sample->weight = rgb_mul(sample->weight, path->fork.weight);
    return true;
}

bool path_scatter_sample(const struct path_tracer *tracer, const struct path *path, struct bsdf_sample *sample,
                         float *incoming) {
    struct sampler sampler = path_sampler(path, PATH_DIMENSION_BSDF);
    vec2 u = sampler_2d(&sampler);
    const uint64_t more = sampler_bits(&sampler);
    const float u_third = sampler_float_from_bits((uint32_t)(more >> 32));
    const float u_guide = sampler_float_from_bits((uint32_t)more);
    const struct guide *guide = &tracer->guide->guide;
    const float share = tracer->guide->share * guided_at(tracer, &path->surface);
    const vec3 wi = vec3_neg(path->ray.direction), ng = path->surface.ng;
    struct guide_view view;
    *incoming = 0;
    if (!(share > 0) || !guide_look(guide, path->surface.p, vec3_dot(ng, wi) < 0 ? vec3_neg(ng) : ng, &view))
        return sample_bsdf(path, (vec3){u.x, u.y, u_third}, sample);
    if (u.x >= share) {
        u.x = minf((u.x - share) / (1 - share), 0x1.fffffep-1f);
        if (!sample_bsdf(path, (vec3){u.x, u.y, u_third}, sample)) return false;
        float guided = 0; // the guide's density, relative to the BSDF's
        if (!sample->delta) guided = guide_pdf(guide, &view, sample->wo, incoming) / sample->pdf;
        sample->weight = rgb_scale(sample->weight, 1 / (1 - share + share * guided));
        return true;
    }
    u.x = minf(u.x / share, 0x1.fffffep-1f);
    const vec3 wo = guide_sample(&view, u_guide, u);
    float pdf_bsdf;
    const rgb response = surface_eval_pdf_bsdf(&path->surface, wi, wo, &pdf_bsdf);
    if (rgb_is_black(response) || !(pdf_bsdf > 0)) return false;
    const float pdf = (1 - share) * pdf_bsdf + share * guide_pdf(guide, &view, wo, incoming);
    *sample = (struct bsdf_sample){wo, rgb_scale(response, path->fork.inverse_share / pdf), pdf_bsdf, 1, false};
    return true;
}
