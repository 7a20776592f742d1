// Figure 6: the images that light is sampled from, at 16 x 16 pixels as in the paper: the traced one beside the
// density's.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "evidence/cone_image.h"
#include "evidence/figure_table.h"
#include "evidence/studied_lamp.h"

enum { COARSE = 16, FINE = 512, TRACED = 128, TRACED_SAMPLES = 64 }; // sides of grids; lines a cell at scale 1

static const struct {
    vec3 out;
    float distance; // radii
} POINTS[] = {{{0.3f, -1, 0.2f}, 1.5f}, {{1, -0.4f, 0.6f}, 4}};
enum { POINT_COUNT = sizeof POINTS / sizeof POINTS[0] };

static const struct sheet_column COLUMNS[] = {{"ours", "our density", 2},
                                              {"exact_image", "exact 16x16 image", 2},
                                              {"paper", "preset paper", 2},
                                              {"uniform", "uniform", 1},
                                              {0}};

// A 16 x 16 picture of mean brightness 1.
static enum status show_grid(struct sheet *sheet, const struct cone_image *grid, const char *name, const char *note,
                             struct error *error) {
    float mean[COARSE * COARSE], sum = 0;
    struct image picture = {0};
    cone_image_average(grid, COARSE, mean);
    for (int i = 0; i < COARSE * COARSE; i++) sum += mean[i] / (COARSE * COARSE);
    enum status status = image_init(&picture, COARSE, COARSE, 3, error);
    for (int i = 0; i < 3 * COARSE * COARSE && !status; i++) picture.pixels[i] = mean[i / 3] / fmaxf(sum, 1e-30f);
    if (!status) status = sheet_picture(sheet, &picture, 0.2f, name, note, error);
    image_fini(&picture);
    return status;
}

// Densities on the fine grid: the average over its 16 x 16 blocks, as the paper's, with a uniform share of 5 %.
static void density_from_image(const struct cone_image *grid, float *density) {
    float mean[COARSE * COARSE];
    double sum = 0;
    cone_image_average(grid, COARSE, mean);
    for (int i = 0; i < COARSE * COARSE; i++) sum += (double)mean[i] / (COARSE * COARSE);
    const float whole = grid->solid_angle * (float)(grid->side * grid->side);
    const int block = grid->side / COARSE;
    for (int y = 0; y < grid->side; y++)
        for (int x = 0; x < grid->side; x++)
            density[y * grid->side + x] = (0.05f + 0.95f * mean[y / block * COARSE + x / block] / (float)sum) / whole;
}

struct point_grids {
    struct cone_image traced, predicted, density, paper;
    float *flat; // a density on the fine grid
};

static void grids_fini(struct point_grids *grids) {
    cone_image_fini(&grids->traced);
    cone_image_fini(&grids->predicted);
    cone_image_fini(&grids->density);
    cone_image_fini(&grids->paper);
    free(grids->flat);
}

static enum status show_point(struct figure_kit *kit, const struct studied_lamp *studied, const char *name, int point,
                              const struct luminaire *paper, struct sheet *sheet, double *values, struct error *error) {
    const vec3 out = vec3_normalize(POINTS[point].out);
    const float distance = POINTS[point].distance;
    struct point_grids grids = {.flat = malloc((size_t)FINE * FINE * sizeof *grids.flat)};
    enum status status = grids.flat ? STATUS_OK : error_set(error, STATUS_MEMORY, "out of memory for figure 6");
    if (!status) status = cone_image_init(&grids.traced, studied->luminaire, out, distance, TRACED, error);
    if (!status) status = cone_image_init(&grids.predicted, studied->luminaire, out, distance, FINE, error);
    if (!status) status = cone_image_init(&grids.density, studied->luminaire, out, distance, FINE, error);
    if (!status && paper) status = cone_image_init(&grids.paper, paper, out, distance, FINE, error);
    if (!status) {
        const uint64_t stream = (uint64_t)STREAM_EVALUATION << 56 | 7ull << 48 | (uint64_t)point << 40;
        cone_image_trace(&grids.traced, &studied->lamp, figure_count(kit, TRACED_SAMPLES), stream);
        cone_image_predict(&grids.predicted, studied->luminaire);
        cone_image_density(&grids.density, studied->luminaire);
        values[0] = cone_image_variance(&grids.predicted, grids.density.value);
        density_from_image(&grids.predicted, grids.flat);
        values[1] = cone_image_variance(&grids.predicted, grids.flat);
        values[2] = (double)NAN;
        if (paper) cone_image_density(&grids.paper, paper);
        if (paper) values[2] = cone_image_variance(&grids.predicted, grids.paper.value);
        const float whole = grids.predicted.solid_angle * FINE * FINE;
        for (int i = 0; i < FINE * FINE; i++) grids.flat[i] = 1 / whole;
        values[3] = cone_image_variance(&grids.predicted, grids.flat);
        char note[60];
        snprintf(note, sizeof note, "traced, from %g radii", (double)distance);
        status = show_grid(sheet, &grids.traced, name, note, error);
        snprintf(note, sizeof note, "relative variance %.2f", values[0]);
        if (!status) status = show_grid(sheet, &grids.density, "our density", note, error);
        snprintf(note, sizeof note, "relative variance %.2f", values[2]);
        if (!status && paper) status = show_grid(sheet, &grids.paper, "preset paper", note, error);
    }
    grids_fini(&grids);
    return status;
}

// Whether the paper's file was baked from the lamp of this name.
static bool is_baked_from(const struct luminaire *paper, const char *lamp) {
    const char *source = paper ? luminaire_metadata(paper, "bake.source") : NULL;
    if (!source) return false;
    const char *slash = strrchr(source, '/'), *file = slash ? slash + 1 : source;
    return !strncmp(file, lamp, strlen(lamp)) && !strcmp(file + strlen(lamp), ".xml");
}

static enum status make_sampling(struct figure_kit *kit, const struct figure *figure, struct sheet *sheet,
                                 struct error *error) {
    (void)figure;
    double values[FIGURE_LAMPS][POINT_COUNT][4];
    char lamps[FIGURE_LAMPS][FIGURE_NAME];
    const int count = figure_lamps(kit, lamps);
    struct luminaire *paper = NULL;
    enum status status = kit->paper ? luminaire_load(&paper, kit->paper, error) : STATUS_OK;
    figure_steps(kit, count);
    for (int i = 0; i < count && !status; i++) {
        struct studied_lamp studied;
        figure_step(kit, lamps[i]);
        if (run_cancelled(&kit->run)) status = error_set(error, STATUS_CANCELLED, "cancelled");
        if (!status) status = studied_lamp_open(&studied, kit, lamps[i], error);
        if (status) break;
        sheet_row(sheet);
        for (int k = 0; k < POINT_COUNT && !status; k++)
            status = show_point(kit, &studied, lamps[i], k, is_baked_from(paper, lamps[i]) ? paper : NULL, sheet,
                                values[i][k], error);
        studied_lamp_close(&studied);
    }
    luminaire_destroy(paper);
    sheet_table(sheet, COLUMNS);
    for (int i = 0; i < count * POINT_COUNT && !status; i++) {
        char name[100];
        snprintf(name, sizeof name, "%s, %g radii", lamps[i / POINT_COUNT], (double)POINTS[i % POINT_COUNT].distance);
        sheet_line(sheet, name, values[i / POINT_COUNT][i % POINT_COUNT]);
    }
    return status;
}

const struct figure figure_sampling = {"6",
                                       "Figure 6: the lamp from shading points, and the densities that sample it",
                                       "Luminance times cosine over the cone of the lamp's bounding sphere, traced, in "
                                       "16x16 pixels of equal solid angle, and the density "
                                       "of our light samples in the same pixels. The table has the relative variance "
                                       "of L cos / p of one sample, with the light "
                                       "field's L on a grid of 512x512 directions; an exact image in 16x16 pixels is "
                                       "what the paper's network can reach at best.",
                                       60,
                                       make_sampling,
                                       NULL};
