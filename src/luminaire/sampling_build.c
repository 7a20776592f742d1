// Builds the sampling density from exits. A distance is chosen freely for every exit in every distance bin: the
// point there on its ray is a shading point that sees it, so the counts of a cell are proportional to L, whatever the
// cell's size. Exits that pass near an anchor belong to the anchors, all others to the map.
#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"
#include "luminaire/sampling.h"
#include "math/sampler.h"
#include "math/warp.h"

enum { PROFILE_BINS = 96 };
static const double spread_exits = 100; // among the pixels of a cell
static const float profile_first = 5e-4f, profile_last = 0.15f; // perpendicular distances, in radii
static const float distance_low[DISTANCE_BINS] = {1.01f, 1.4f, 2.5f}, distance_high[DISTANCE_BINS] = {1.4f, 2.5f, 8};

struct build {
    struct sampling_density *density;
    const struct line_exit *exits;
    size_t count;
    const int16_t *owner; // anchor of each exit, -1: the map
    uint64_t seed;
    float *image; // [cell][MAP_PIXELS] flux
    double *near_anchors; // [cell] flux of the anchors' exits
    double *squares; // [cell] of the map's exits' flux
};

static vec3 vec3_from(const float v[3]) { return vec3_make(v[0], v[1], v[2]); }

// All channels count alike, so that no colour goes unsampled.
static float exit_flux(const struct line_exit *exit) {
    float flux = (exit->flux[0] + exit->flux[1] + exit->flux[2]) / 3;
    return flux > 0 && isfinite(flux) ? flux : 0;
}

static int nearest_anchor(const struct sampling_density *density, const struct line_exit *exit, float *distance) {
    vec3 p = vec3_from(exit->point), w = vec3_from(exit->w);
    float best = INFINITY;
    int nearest = -1;
    for (int i = 0; i < density->anchor_count; i++) {
        vec3 d = vec3_sub(p, vec3_from(density->anchors[i]));
        vec3 across = vec3_mad(w, -vec3_dot(d, w), d);
        float d2 = vec3_dot(across, across);
        if (d2 < best) best = d2, nearest = i;
    }
    *distance = sqrtf(best);
    return nearest;
}

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

// Gives every exit near an anchor to it and sums the anchors' intensities.
static void assign_anchors(struct sampling_density *density, const struct line_exit *exits, size_t count,
                           int16_t *owner, float *distance) {
    double flux[PROFILE_BINS] = {0};
    for (size_t i = 0; i < count; i++) {
        owner[i] = (int16_t)nearest_anchor(density, &exits[i], &distance[i]);
        float relative = distance[i] / density->radius;
        if (!(relative < profile_last)) continue;
        float place = logf(fmaxf(relative, profile_first) / profile_first) / logf(profile_last / profile_first);
        int bin = (int)(place * PROFILE_BINS);
        flux[bin < PROFILE_BINS ? bin : PROFILE_BINS - 1] += (double)exit_flux(&exits[i]);
    }
    bool any = density->anchor_count > 0 && fit_cones(density, flux);
    if (!any) density->anchor_count = 0;
    float reach = any ? density->cone_radius[CONE_COUNT - 1] : 0;
    double total = 0;
    for (size_t i = 0; i < count; i++) {
        if (!any || !(distance[i] <= reach)) {
            owner[i] = -1;
            continue;
        }
        vec2 square = octahedral_from_direction(vec3_from(exits[i].w));
        int x = (int)(square.x * INTENSITY_SIDE), y = (int)(square.y * INTENSITY_SIDE);
        x = x < INTENSITY_SIDE ? x : INTENSITY_SIDE - 1, y = y < INTENSITY_SIDE ? y : INTENSITY_SIDE - 1;
        density->intensity[owner[i] * INTENSITY_CELLS + y * INTENSITY_SIDE + x] += exit_flux(&exits[i]);
        total += (double)exit_flux(&exits[i]);
    }
    // A tenth of the mean everywhere: no direction of an anchor goes unsampled.
    float floor_value = any ? (float)(0.1 * total / (density->anchor_count * INTENSITY_CELLS)) : 0;
    for (int i = 0; i < density->anchor_count * INTENSITY_CELLS; i++)
        density->intensity[i] = (density->intensity[i] + floor_value) / (float)(total > 0 ? total : 1);
}

static void splat(struct build *build, size_t exit, vec3 s, float flux) {
    struct sampling_view view = sampling_view_make(build->density, s);
    vec2 p;
    if (!sampling_image_from_direction(&view, vec3_neg(vec3_from(build->exits[exit].w)), &p)) return;
    if (build->owner[exit] >= 0) {
        build->near_anchors[view.cell] += (double)flux;
        return;
    }
    int x = (int)(p.x * MAP_SIDE), y = (int)(p.y * MAP_SIDE);
    x = x < MAP_SIDE ? x : MAP_SIDE - 1, y = y < MAP_SIDE ? y : MAP_SIDE - 1;
    build->image[view.cell * MAP_PIXELS + (size_t)(y * MAP_SIDE + x)] += flux;
    build->squares[view.cell] += (double)flux * (double)flux;
}

// One distance bin (DISTANCE_BINS: the inside): its cells are written by this call alone.
static void fill_bin(void *user, size_t bin, int worker) {
    (void)worker;
    struct build *build = user;
    const struct sampling_density *density = build->density;
    float radius2 = density->radius * density->radius;
    const int repeats = build->count < 4000000 ? 2 : 1; // few exits: each at two distances
    for (size_t i = 0; i < build->count; i++) {
        float flux = exit_flux(&build->exits[i]);
        if (flux == 0) continue;
        struct sampler sampler = sampler_make(build->seed, 0x73616d70 + bin, i);
        vec3 w = vec3_from(build->exits[i].w), p = vec3_sub(vec3_from(build->exits[i].point), density->center);
        float along = vec3_dot(p, w);
        vec3 q = vec3_mad(w, -along, p);
        float q2 = vec3_dot(q, q);
        if (!(q2 < radius2)) continue;
        for (int k = 0; k < repeats; k++) {
            float u = sampler_1d(&sampler);
            if (bin == DISTANCE_BINS) { // anywhere on the chord, by its length
                float half = sqrtf(radius2 - q2);
                vec3 s = vec3_add(density->center, vec3_mad(w, half * (2 * u - 1), q));
                splat(build, i, s, flux * half);
            } else { // a sphere of this radius is crossed at a cosine: fluence is flux over it
                float distance =
                    density->radius * (distance_low[bin] * powf(distance_high[bin] / distance_low[bin], u));
                float t = sqrtf(distance * distance - q2);
                splat(build, i, vec3_add(density->center, vec3_mad(w, t, q)), flux * distance / t);
            }
        }
    }
}

static void encode_cells(struct build *build) {
    struct sampling_density *density = build->density;
    for (size_t cell = 0; cell < sampling_cell_count(density); cell++) {
        float *image = build->image + cell * MAP_PIXELS;
        float largest = 0;
        double sum = 0;
        for (int i = 0; i < MAP_PIXELS; i++) sum += (double)image[i];
        // Where few exits are known, chance alone would leave pixels dark that are not: as if a few more were known,
        // spread evenly.
        double known = build->squares[cell] > 0 ? sum * sum / build->squares[cell] : 0;
        float spread = (float)(sum * spread_exits / ((known + 1) * MAP_PIXELS));
        for (int i = 0; i < MAP_PIXELS; i++) {
            image[i] += spread;
            largest = fmaxf(largest, image[i]);
        }
        for (int i = 0; i < MAP_PIXELS; i++) {
            int code = image[i] > 0 ? (int)lrintf(15 * sqrtf(image[i] / largest)) : 0;
            code = image[i] > 0 && code == 0 ? 1 : code;
            density->codes[cell * MAP_BYTES + (size_t)i / 2] |= (uint8_t)(code << (i & 1 ? 4 : 0));
        }
        double total = sum + build->near_anchors[cell], share = total > 0 ? sum / total : 0.5;
        density->residual_share[cell] = (uint8_t)lrint(255 * (share < 0.03 ? 0.03 : share > 0.97 ? 0.97 : share));
    }
}

enum status sampling_density_build(struct sampling_density **density, const struct proxy *proxy,
                                   const float (*anchors)[3], size_t anchor_count, const struct line_exit *exits,
                                   size_t exit_count, uint64_t seed, int threads, struct error *error) {
    *density = NULL;
    if (anchor_count > SAMPLING_MAX_ANCHORS)
        return error_set(error, STATUS_INVALID, "%zu anchors; at most %d are possible", anchor_count,
                         SAMPLING_MAX_ANCHORS);
    if (!(proxy->radius > 0)) return error_set(error, STATUS_INVALID, "the proxy's radius must be positive");
    int directions = exit_count < 100000 ? 8 : exit_count < 4000000 ? 16 : 24;
    struct sampling_density *d;
    enum status status = sampling_allocate(&d, proxy, directions, (int)anchor_count, error);
    if (status) return status;
    if (anchor_count) memcpy(d->anchors, anchors, anchor_count * sizeof *anchors);
    struct build build = {d, exits, exit_count, NULL, seed, NULL, NULL, NULL};
    int16_t *owner = malloc((exit_count + 1) * sizeof *owner);
    float *distance = malloc((exit_count + 1) * sizeof *distance);
    build.image = calloc(sampling_cell_count(d) * MAP_PIXELS, sizeof(float));
    build.near_anchors = calloc(sampling_cell_count(d), sizeof(double));
    build.squares = calloc(sampling_cell_count(d), sizeof(double));
    build.owner = owner;
    if (owner && distance && build.image && build.near_anchors && build.squares) {
        assign_anchors(d, exits, exit_count, owner, distance);
        parallel_for(threads, DISTANCE_BINS + 1, fill_bin, &build);
        encode_cells(&build);
        sampling_derive(d);
        *density = d;
    } else {
        sampling_density_destroy(d);
        status = error_set(error, STATUS_MEMORY, "out of memory for a sampling density of %zu exits", exit_count);
    }
    free(owner);
    free(distance);
    free(build.image);
    free(build.near_anchors);
    free(build.squares);
    return status;
}
