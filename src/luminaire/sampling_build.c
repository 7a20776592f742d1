// Builds a sampling density from exits, or anew from what the light field itself shows along the lines that an earlier
// density draws: so it is told of what that one misses. Lines that pass near an anchor belong to the anchors, all
// others to the map.
#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"
#include "luminaire/proxy.h"
#include "luminaire/sampling_sums.h"
#include "math/sampler.h"
#include "math/warp.h"

enum { FEW_DIRECTIONS = 8, MOST_DIRECTIONS = 16 };
enum { PROFILE_BINS = 96, BLOCK = 4096, BATCH = 64 * BLOCK };
enum { FEW_EXITS = 100000, MANY_EXITS = 4000000 }; // of many, each at one distance; of fewer, at two
static const float profile_first = 5e-4f, profile_last = 0.15f; // perpendicular distances, in radii
static const float nearest_view = 1.02f, farthest_view = 8; // from where lines are drawn, in radii

static float profile_radius(int bin) { // outer radius of a bin, in radii of the proxy
    return profile_first * powf(profile_last / profile_first, (float)(bin + 1) / PROFILE_BINS);
}

// Cone radii and shares from the flux per perpendicular distance: the anchors' reach ends where the flux per area falls
// below a twentieth of its mean within; a falling step profile is exactly a mixture of nested disks.
static bool fit_cones(struct sampling_density *density, const double *flux) {
    double total = 0, inside = 0;
    for (int k = 0; k < PROFILE_BINS; k++) total += flux[k];
    if (!(total > 0)) return false;
    int last = 0;
    for (int k = 0; k < PROFILE_BINS; k++) {
        double outer = profile_radius(k), inner = k ? profile_radius(k - 1) : 0;
        bool sparse = flux[k] / (outer * outer - inner * inner) < 0.05 * inside / (inner > 0 ? inner * inner : 1);
        if (inside > 0.1 * total && sparse) break;
        inside += flux[k];
        last = k;
    }
    static const double quantiles[CONE_COUNT] = {0.5, 0.85, 1};
    double ring[CONE_COUNT + 1] = {0}, radius2[CONE_COUNT], sum = 0;
    int bin = 0;
    for (int c = 0; c < CONE_COUNT; c++) {
        double before = sum, inner2 = c ? radius2[c - 1] : 0;
        while (bin <= last && (c == CONE_COUNT - 1 || sum < quantiles[c] * inside)) sum += flux[bin++];
        double outer = profile_radius(bin > 0 ? bin - 1 : 0);
        radius2[c] = outer * outer;
        ring[c] = radius2[c] > inner2 ? (sum - before) / (radius2[c] - inner2) : 0;
        density->cone_radius[c] = (float)(outer * (double)density->radius);
    }
    double shares = 0, share[CONE_COUNT];
    for (int c = CONE_COUNT - 2; c >= 0; c--) ring[c] = ring[c] > ring[c + 1] ? ring[c] : ring[c + 1];
    for (int c = 0; c < CONE_COUNT; c++) shares += share[c] = (ring[c] - ring[c + 1]) * radius2[c];
    for (int c = 0; c < CONE_COUNT; c++) density->cone_share[c] = (float)(share[c] / shares);
    return true;
}

struct finding { // each line's nearest anchor
    const struct sampling_density *density;
    struct sampling_line *lines;
    float *distance;
    size_t count;
};

static void find_block(void *user, size_t block, int worker) {
    (void)worker;
    const struct finding *f = user;
    const size_t end = (block + 1) * BLOCK < f->count ? (block + 1) * BLOCK : f->count;
    for (size_t i = block * BLOCK; i < end; i++)
        f->lines[i].anchor = sampling_nearest_anchor(f->density, f->lines[i].point, f->lines[i].w, &f->distance[i]);
}

// Gives every line near an anchor to it and sums the anchors' intensities.
static void assign_anchors(struct sampling_density *density, struct sampling_line *lines, size_t count, float *distance,
                           int threads) {
    double flux[PROFILE_BINS] = {0};
    parallel_for(threads, (count + BLOCK - 1) / BLOCK, find_block, &(struct finding){density, lines, distance, count});
    for (size_t i = 0; i < count; i++) {
        float relative = distance[i] / density->radius;
        if (!(relative < profile_last)) continue;
        float place = logf(fmaxf(relative, profile_first) / profile_first) / logf(profile_last / profile_first);
        int bin = (int)(place * PROFILE_BINS);
        flux[bin < PROFILE_BINS ? bin : PROFILE_BINS - 1] += (double)lines[i].flux;
    }
    bool any = density->anchor_count > 0 && fit_cones(density, flux);
    if (!any) density->anchor_count = 0;
    float reach = any ? density->cone_radius[CONE_COUNT - 1] : 0;
    for (size_t i = 0; i < count; i++) {
        if (any && distance[i] <= reach)
            sampling_add_intensity(density, &lines[i]);
        else
            lines[i].anchor = -1;
    }
    sampling_end_intensities(density);
}

static size_t lines_from_exits(const struct line_exit *exits, size_t count, struct sampling_line *lines) {
    size_t kept = 0;
    for (size_t i = 0; i < count; i++) {
        const float flux = sampling_mean(exits[i].flux);
        if (flux > 0)
            lines[kept++] =
                (struct sampling_line){.point = vec3_from(exits[i].point), .w = vec3_from(exits[i].w), .flux = flux};
    }
    return kept;
}

size_t sampling_density_bytes(size_t anchor_count) {
    const struct sampling_density largest = {.directions = MOST_DIRECTIONS};
    return sampling_cell_count(&largest) * (MAP_BYTES + 1) + anchor_count * (3 + INTENSITY_CELLS) * sizeof(float);
}

enum status sampling_density_build(struct sampling_density **density, const struct proxy *proxy,
                                   const float (*anchors)[3], size_t anchor_count, const struct line_exit *exits,
                                   size_t exit_count, uint64_t seed, int threads, struct error *error) {
    *density = NULL;
    if (anchor_count > SAMPLING_MAX_ANCHORS)
        return error_set(error, STATUS_INVALID, "%zu anchors; at most %d are possible", anchor_count,
                         SAMPLING_MAX_ANCHORS);
    if (!(proxy->radius > 0)) return error_set(error, STATUS_INVALID, "the proxy's radius must be positive");
    const int directions = exit_count < FEW_EXITS ? FEW_DIRECTIONS : MOST_DIRECTIONS;
    struct sampling_density *d;
    struct sampling_sums sums;
    enum status status = sampling_allocate(&d, proxy, directions, (int)anchor_count, error);
    if (status) return status;
    if (anchor_count) memcpy(d->anchors, anchors, anchor_count * sizeof *anchors);
    struct sampling_line *lines = malloc((exit_count + 1) * sizeof *lines);
    float *distance = malloc((exit_count + 1) * sizeof *distance);
    status = sampling_sums_init(&sums, d, error);
    if (!status && (!lines || !distance))
        status = error_set(error, STATUS_MEMORY, "out of memory for a sampling density of %zu exits", exit_count);
    if (!status) {
        const size_t count = lines_from_exits(exits, exit_count, lines);
        assign_anchors(d, lines, count, distance, threads);
        sampling_sums_add(&sums, lines, count, 0, exit_count < MANY_EXITS ? 2 : 1, seed, threads);
        sampling_sums_encode(&sums);
        *density = d;
    } else {
        sampling_density_destroy(d);
    }
    sampling_sums_fini(&sums);
    free(lines);
    free(distance);
    return status;
}

// --- From the light field ---
struct drawing { // of a batch of lines
    const struct sampling_density *density; // that draws them
    const struct light_field *field;
    const struct proxy_shape *shape;
    uint64_t seed, round;
    size_t first; // line of the batch
    struct sampling_line *lines; // flux 0: none
};

static void draw_block(void *user, size_t block, int worker) {
    (void)worker;
    const struct drawing *drawing = user;
    const struct sampling_density *density = drawing->density;
    float s[BLOCK][3], u[BLOCK][3], direction[BLOCK][3], w[BLOCK][3], pdf_sa[BLOCK], radiance[BLOCK][3];
    for (size_t i = 0; i < BLOCK; i++) {
        struct sampler sampler =
            sampler_make(drawing->seed, 0x72656669 + drawing->round, drawing->first + block * BLOCK + i);
        const vec3 out = warp_uniform_sphere(sampler_2d(&sampler));
        const float distance = nearest_view * powf(farthest_view / nearest_view, sampler_1d(&sampler));
        vec3_store(s[i], vec3_mad(out, distance * density->radius, density->center));
        for (int c = 0; c < 3; c++) u[i][c] = sampler_1d(&sampler);
    }
    sampling_sample_batch(density, BLOCK, (const float(*)[3])s, (const float(*)[3])u, direction, pdf_sa);
    for (size_t i = 0; i < BLOCK; i++)
        for (int c = 0; c < 3; c++) w[i][c] = -direction[i][c];
    light_field_eval(drawing->field, BLOCK, (const float(*)[3])s, (const float(*)[3])w, radiance);
    for (size_t i = 0; i < BLOCK; i++) {
        struct sampling_line *line = &drawing->lines[block * BLOCK + i];
        *line = (struct sampling_line){.point = vec3_from(s[i]), .w = vec3_from(w[i])};
        const vec3 out = vec3_sub(line->point, density->center);
        float t_near, t_far;
        if (!(pdf_sa[i] > 0) || !proxy_shape_span(drawing->shape, s[i], direction[i], &t_near, &t_far)) continue;
        line->radiance = sampling_mean(radiance[i]);
        // Of the lines through the sphere about the view: its area, and the cosine there.
        const float area_cosine = fmaxf(vec3_dot(out, line->w), 0) * vec3_length(out);
        const float flux = line->radiance * area_cosine / pdf_sa[i];
        if (isfinite(flux)) line->flux = flux;
        line->anchor = sampling_anchor_of(density, line->point, line->w);
    }
}

static size_t keep_bright(struct sampling_line *lines, size_t count) {
    size_t kept = 0;
    for (size_t i = 0; i < count; i++)
        if (lines[i].flux > 0) lines[kept++] = lines[i];
    return kept;
}

static enum status make_round(struct drawing *drawing, const struct sampling_refinement *plan, size_t count,
                              struct sampling_density **result, struct error *error) {
    const struct sampling_density *old = drawing->density;
    const struct proxy *proxy = &drawing->shape->proxy;
    struct sampling_density *d;
    struct sampling_sums sums;
    enum status status = sampling_allocate(&d, proxy, old->directions, old->anchor_count, error);
    if (status) return status;
    memcpy(d->anchors, old->anchors, (size_t)old->anchor_count * sizeof *old->anchors);
    memcpy(d->cone_radius, old->cone_radius, sizeof d->cone_radius);
    memcpy(d->cone_share, old->cone_share, sizeof d->cone_share);
    status = sampling_sums_init(&sums, d, error);
    for (drawing->first = 0; !status && drawing->first < count; drawing->first += BATCH) {
        parallel_for(plan->threads, BATCH / BLOCK, draw_block, drawing);
        const size_t kept = keep_bright(drawing->lines, BATCH);
        for (size_t i = 0; i < kept; i++)
            if (drawing->lines[i].anchor >= 0) sampling_add_intensity(d, &drawing->lines[i]);
        sampling_sums_add(&sums, drawing->lines, kept, drawing->first, 1, drawing->seed ^ drawing->round,
                          plan->threads);
    }
    if (!status) {
        sampling_end_intensities(d);
        sampling_sums_encode(&sums);
        *result = d;
    } else {
        sampling_density_destroy(d);
    }
    sampling_sums_fini(&sums);
    return status;
}

enum status sampling_density_refine(struct sampling_density **density, const struct light_field *field,
                                    const struct proxy_shape *shape, const struct sampling_refinement *plan,
                                    struct error *error) {
    struct drawing drawing = {.field = field, .shape = shape, .seed = plan->seed};
    if (plan->lines == 0) return STATUS_OK;
    drawing.lines = malloc(BATCH * sizeof *drawing.lines);
    if (!drawing.lines) return error_set(error, STATUS_MEMORY, "out of memory for the lines of a sampling density");
    enum status status = STATUS_OK;
    for (int round = 0; !status && round < SAMPLING_ROUNDS; round++) {
        const bool last = round == SAMPLING_ROUNDS - 1;
        struct sampling_density *next;
        drawing.density = *density;
        drawing.round = (uint64_t)round;
        status = make_round(&drawing, plan, last ? plan->lines : plan->lines / 4, &next, error);
        if (status) break;
        sampling_density_destroy(*density);
        *density = next;
    }
    free(drawing.lines);
    return status;
}
