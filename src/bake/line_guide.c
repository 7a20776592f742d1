// The guide's three parts: uniform lines, a histogram over cells of equal measure, and lines past the emission clusters
// (a direction uniform on the sphere, an offset uniform on one of two disks: one just holds the cluster's emission
// points, one catches what the glass round it deflects).
#include "bake/line_guide.h"

#include <stdlib.h>

#include "math/distribution.h"
#include "math/warp.h"

enum { CELLS_Z = 20, CELLS_PHI = 50, CELLS = CELLS_Z * CELLS_PHI, DISKS = 2 };
static const float uniform_share = 0.3f;
static const float disk_scale[DISKS] = {1.1f, 3.0f}, disk_share[DISKS] = {0.6f, 0.4f};

struct line_guide {
    vec3 center;
    float radius, histogram_share, cluster_share;
    struct distribution2d cells; // x: entry cell, y: exit cell
    struct emission_cluster *clusters;
    size_t cluster_count;
    struct distribution pick; // of a cluster, by share
};

static size_t cell_from_direction(vec3 d) {
    float z = clampf(0.5f * (d.z + 1), 0, 0.999999f) * CELLS_Z, phi = atan2f(d.y, d.x) * (0.5f * INV_PI_F);
    float column = (phi < 0 ? phi + 1 : phi) * CELLS_PHI;
    int c = (int)column;
    return (size_t)z * CELLS_PHI + (size_t)(c < CELLS_PHI ? c : CELLS_PHI - 1);
}

static vec3 direction_in_cell(size_t cell, vec2 u) {
    float z = 2 * ((float)(cell / CELLS_PHI) + u.x) / CELLS_Z - 1;
    float phi = 2 * PI_F * ((float)(cell % CELLS_PHI) + u.y) / CELLS_PHI, s = sqrtf(fmaxf(0, 1 - z * z));
    return (vec3){s * cosf(phi), s * sinf(phi), z};
}

// Entry and exit of a line as unit vectors from the sphere's centre. False: it misses the sphere.
static bool line_ends(const struct line_guide *guide, vec3 point, vec3 w, vec3 *entry, vec3 *exit) {
    vec3 p = vec3_scale(vec3_sub(point, guide->center), 1 / guide->radius);
    vec3 middle = vec3_mad(w, -vec3_dot(p, w), p);
    float h2 = 1 - vec3_dot(middle, middle);
    if (h2 <= 0) return false;
    float h = sqrtf(h2);
    *entry = vec3_mad(w, -h, middle);
    *exit = vec3_mad(w, h, middle);
    return true;
}

static enum status build_cells(struct line_guide *guide, const struct line_guide_options *options,
                               struct error *error) {
    float *weights = calloc((size_t)CELLS * CELLS, sizeof *weights);
    if (!weights) return error_set(error, STATUS_MEMORY, "out of memory for the line guide");
    for (size_t i = 0; i < options->exit_count; i++) {
        const struct line_exit *x = &options->exits[i];
        vec3 entry, exit;
        if (!line_ends(guide, (vec3){x->point[0], x->point[1], x->point[2]}, (vec3){x->w[0], x->w[1], x->w[2]}, &entry,
                       &exit))
            continue;
        weights[cell_from_direction(exit) * CELLS + cell_from_direction(entry)] +=
            (x->flux[0] + x->flux[1] + x->flux[2]) * (1.0f / 3);
    }
    double largest = 0;
    for (size_t i = 0; i < (size_t)CELLS * CELLS; i++) largest = fmax(largest, (double)weights[i]);
    for (size_t i = 0; i < (size_t)CELLS * CELLS && largest > 0; i++)
        weights[i] = powf(weights[i] / (float)largest, options->exponent);
    enum status status = distribution2d_init(&guide->cells, weights, CELLS, CELLS, error);
    free(weights);
    return status;
}

static enum status copy_clusters(struct line_guide *guide, const struct line_guide_options *options,
                                 struct error *error) {
    size_t n = options->cluster_count;
    guide->clusters = calloc(n, sizeof *guide->clusters);
    float *shares = calloc(n, sizeof *shares);
    enum status status = guide->clusters && shares
                             ? STATUS_OK
                             : error_set(error, STATUS_MEMORY, "out of memory for %zu emission clusters", n);
    for (size_t i = 0; i < n && status == STATUS_OK; i++) {
        guide->clusters[i] = options->clusters[i];
        guide->clusters[i].radius = fmaxf(guide->clusters[i].radius, 1e-3f * guide->radius);
        shares[i] = guide->clusters[i].share;
    }
    if (status == STATUS_OK) status = distribution_init(&guide->pick, shares, n, error);
    guide->cluster_count = n;
    free(shares);
    return status;
}

enum status line_guide_create(struct line_guide **guide, const struct line_guide_options *options,
                              struct error *error) {
    struct line_guide *g = calloc(1, sizeof *g);
    if (!g) return error_set(error, STATUS_MEMORY, "out of memory for the line guide");
    g->center = options->center;
    g->radius = options->radius;
    g->cluster_share = options->cluster_count ? options->cluster_share : 0;
    g->histogram_share = 1 - uniform_share - g->cluster_share;
    enum status status = build_cells(g, options, error);
    if (status == STATUS_OK && g->cluster_share > 0) status = copy_clusters(g, options, error);
    if (status != STATUS_OK) {
        line_guide_destroy(g);
        return status;
    }
    *guide = g;
    return STATUS_OK;
}

void line_guide_destroy(struct line_guide *guide) {
    if (!guide) return;
    distribution2d_fini(&guide->cells);
    distribution_fini(&guide->pick);
    free(guide->clusters);
    free(guide);
}

// [1/(length^2 sr)] of a line by the clusters.
static float cluster_density(const struct line_guide *guide, vec3 point, vec3 w) {
    float density = 0;
    for (size_t i = 0; i < guide->cluster_count; i++) {
        const struct emission_cluster *cluster = &guide->clusters[i];
        vec3 d = vec3_sub(point, cluster->center);
        d = vec3_mad(w, -vec3_dot(d, w), d);
        float offset2 = vec3_dot(d, d), pmf = distribution_pmf(&guide->pick, i);
        for (int k = 0; k < DISKS; k++) {
            float r2 = sqrf(disk_scale[k] * cluster->radius);
            if (offset2 <= r2) density += pmf * disk_share[k] * INV_PI_F / r2;
        }
    }
    return density * (0.25f * INV_PI_F);
}

float line_guide_density(const struct line_guide *guide, vec3 point, vec3 w) {
    vec3 entry, exit;
    if (!line_ends(guide, point, w, &entry, &exit)) return 0;
    float uniform = 0.25f * INV_PI_F * INV_PI_F / sqrf(guide->radius); // 1 / (4 pi^2 R^2)
    vec2 at = {((float)cell_from_direction(entry) + 0.5f) / CELLS, ((float)cell_from_direction(exit) + 0.5f) / CELLS};
    float density = uniform * (uniform_share + guide->histogram_share * distribution2d_pdf(&guide->cells, at));
    if (guide->cluster_share > 0) density += guide->cluster_share * cluster_density(guide, point, w);
    return density;
}

static void sample_cluster_line(const struct line_guide *guide, struct sampler *sampler, vec3 *point, vec3 *w) {
    const struct emission_cluster *cluster =
        &guide->clusters[distribution_sample(&guide->pick, sampler_1d(sampler), NULL)];
    *w = warp_uniform_sphere(sampler_2d(sampler));
    int disk = sampler_1d(sampler) < disk_share[0] ? 0 : 1;
    vec2 offset = warp_concentric_disk(sampler_2d(sampler));
    struct frame frame = frame_from_normal(*w);
    float r = disk_scale[disk] * cluster->radius;
    *point = vec3_mad(frame.s, offset.x * r, vec3_mad(frame.t, offset.y * r, cluster->center));
}

float line_guide_sample(const struct line_guide *guide, struct sampler *sampler, vec3 *point, vec3 *w) {
    float choice = sampler_1d(sampler);
    vec3 entry, exit;
    if (choice < guide->cluster_share) {
        sample_cluster_line(guide, sampler, point, w);
        if (!line_ends(guide, *point, *w, &entry, &exit)) return 0;
    } else {
        if (choice < guide->cluster_share + guide->histogram_share) {
            float pdf;
            vec2 at = distribution2d_sample(&guide->cells, sampler_2d(sampler), &pdf);
            size_t x = (size_t)fminf(at.x * CELLS, CELLS - 1), y = (size_t)fminf(at.y * CELLS, CELLS - 1);
            entry = direction_in_cell(x, sampler_2d(sampler));
            exit = direction_in_cell(y, sampler_2d(sampler));
        } else {
            entry = warp_uniform_sphere(sampler_2d(sampler));
            exit = warp_uniform_sphere(sampler_2d(sampler));
        }
        *w = vec3_sub(exit, entry);
        float length = vec3_length(*w);
        if (!(length > 1e-4f)) return 0; // rounding would leave no direction
        *w = vec3_scale(*w, 1 / length);
    }
    *point = vec3_mad(exit, guide->radius, guide->center);
    return line_guide_density(guide, *point, *w);
}
