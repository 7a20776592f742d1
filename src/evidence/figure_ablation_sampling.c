// Ablations of the paper's sampling images: how many pixels they have, and weights taken straight from them. Both need
// no bake: an image is the light field's own mean over each pixel, which is the best that a network could predict.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "evidence/cone_image.h"
#include "evidence/figure_table.h"
#include "evidence/studied_lamp.h"
#include "math/warp.h"

enum { FINE = 512, POINTS = 8, EDGES = 8, LOBES = 8, LARGEST = 32 };
static const int SIDES[] = {8, 16, LARGEST};
enum { SIDE_COUNT = sizeof SIDES / sizeof SIDES[0] };
static const float lobe_width = 0.125f; // standard deviation, of the cone's radius

static const struct sheet_column COLUMNS[] = {{"variance", "variance, unbiased weights", 2},
                                              {"shadow_bias", "biased weights: error at a shadow's edge, %", 2},
                                              {"glossy_bias", "in a glossy lobe, %", 2},
                                              {0}};

// The share of each direction that a receiver takes in: behind an edge through the lamp, or in a lobe about a
// direction. (x, y): on the cone's disk, from -1 to 1.
static float behind_edge(float x, float y, int edge) {
    const float angle = 2 * PI_F * ((float)edge + 0.37f) / EDGES;
    return x * cosf(angle) + y * sinf(angle) > 0 ? 1 : 0;
}

static float in_lobe(float x, float y, int lobe) {
    const float angle = 2 * PI_F * ((float)lobe + 0.37f) / LOBES, at = lobe % 2 ? 0.6f : 0.3f;
    const float distance2 = sqrf(x - at * cosf(angle)) + sqrf(y - at * sinf(angle));
    return expf(-0.5f * distance2 / sqrf(lobe_width));
}

// What biased weights expect, every pixel's light spread evenly over it, against the truth; both summed over receivers.
static void add_bias(const struct cone_image *grid, const float *mean, int side, float (*receiver)(float, float, int),
                     int receivers, double *difference, double *truth) {
    const int block = FINE / side;
    for (int r = 0; r < receivers; r++) {
        double biased = 0, exact = 0;
        for (int i = 0; i < FINE * FINE; i++) {
            const vec3 d = {grid->direction[i][0], grid->direction[i][1], grid->direction[i][2]};
            const float sine = sqrtf(grid->view.rim * (2 - grid->view.rim));
            const float share =
                receiver(vec3_dot(d, grid->view.frame.s) / sine, vec3_dot(d, grid->view.frame.t) / sine, r);
            biased += (double)(mean[i / FINE / block * side + i % FINE / block] * share);
            exact += (double)(grid->value[i] * share);
        }
        *difference += fabs(biased - exact);
        *truth += exact;
    }
}

struct sums {
    double variance, shadow[2], glossy[2]; // [0]: differences, [1]: truths
};

static void add_point(const struct cone_image *grid, float *density, struct sums sums[SIDE_COUNT]) {
    const float whole = grid->solid_angle * FINE * FINE;
    for (int s = 0; s < SIDE_COUNT; s++) {
        float mean[LARGEST * LARGEST];
        const int side = SIDES[s], block = FINE / side;
        double all = 0;
        cone_image_average(grid, side, mean);
        for (int i = 0; i < side * side; i++) all += (double)mean[i] / (side * side);
        for (int i = 0; i < FINE * FINE; i++)
            density[i] = (0.05f + 0.95f * mean[i / FINE / block * side + i % FINE / block] / (float)all) / whole;
        sums[s].variance += cone_image_variance(grid, density) / POINTS;
        add_bias(grid, mean, side, behind_edge, EDGES, &sums[s].shadow[0], &sums[s].shadow[1]);
        add_bias(grid, mean, side, in_lobe, LOBES, &sums[s].glossy[0], &sums[s].glossy[1]);
    }
}

static enum status study_lamp(const struct luminaire *luminaire, struct sums sums[SIDE_COUNT], double *ours,
                              struct error *error) {
    float *density = malloc((size_t)FINE * FINE * sizeof *density);
    enum status status = density ? STATUS_OK : error_set(error, STATUS_MEMORY, "out of memory for an ablation");
    for (int i = 0; i < POINTS && !status; i++) {
        struct cone_image grid, own;
        const vec3 out = warp_uniform_sphere((vec2){((float)i + 0.5f) / POINTS, fmodf(0.618f * (float)i, 1)});
        const float distance = 1.5f * powf(4, (float)i / (POINTS - 1));
        status = cone_image_init(&grid, luminaire, out, distance, FINE, error);
        if (status) break;
        cone_image_predict(&grid, luminaire);
        add_point(&grid, density, sums);
        status = cone_image_init(&own, luminaire, out, distance, FINE, error);
        if (!status) {
            cone_image_density(&own, luminaire);
            *ours += cone_image_variance(&grid, own.value) / POINTS;
            cone_image_fini(&own);
        }
        cone_image_fini(&grid);
    }
    free(density);
    return status;
}

static enum status make_ablation(struct figure_kit *kit, const struct figure *figure, struct sheet *sheet,
                                 struct error *error) {
    (void)figure;
    char lamps[FIGURE_LAMPS][FIGURE_NAME];
    const int count = figure_lamps(kit, lamps);
    enum status status = STATUS_OK;
    figure_steps(kit, count);
    sheet_table(sheet, COLUMNS);
    for (int i = 0; i < count && !status; i++) {
        char path[PATH_MAX], name[100];
        struct luminaire *luminaire;
        struct sums sums[SIDE_COUNT] = {0};
        double ours = 0;
        figure_step(kit, lamps[i]);
        if (run_cancelled(&kit->run)) return error_set(error, STATUS_CANCELLED, "cancelled");
        evidence_baked(path, &kit->data, lamps[i]);
        status = luminaire_load(&luminaire, path, error);
        if (status) break;
        status = study_lamp(luminaire, sums, &ours, error);
        luminaire_destroy(luminaire);
        for (int s = 0; s < SIDE_COUNT && !status; s++) {
            snprintf(name, sizeof name, "%.60s, image of %dx%d", lamps[i], SIDES[s], SIDES[s]);
            sheet_line(sheet, name,
                       (double[]){sums[s].variance, 100 * sums[s].shadow[0] / sums[s].shadow[1],
                                  100 * sums[s].glossy[0] / sums[s].glossy[1]});
        }
        snprintf(name, sizeof name, "%.60s, our density", lamps[i]);
        if (!status) sheet_line(sheet, name, (double[]){ours, (double)NAN, (double)NAN});
    }
    return status;
}

const struct figure figure_ablation_sampling = {
    "ablation_sampling",
    "Ablation: sampling images of 8, 16 and 32 pixels, and weights straight from them",
    "Means over eight shading points from 1.5 to 6 radii, with exact images of the light field. The paper weights a "
    "sample by "
    "the image's own value: no variance in open sight, but the pixel's light is spread evenly over it, so what cuts "
    "through "
    "a pixel (a shadow's edge through the lamp's centre, a glossy lobe of an eighth of the lamp's width) gets a wrong "
    "share; "
    "the figures are mean absolute errors relative to the light received. Our weights divide the light field by the "
    "exact density "
    "and have no such error.",
    60,
    make_ablation,
    NULL};
