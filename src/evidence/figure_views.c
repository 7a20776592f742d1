// Figure 4: the lamps looked at, traced and as their baked files show them. The paper trains on such pictures.
#include <math.h>
#include <stdio.h>

#include "bake/lamp_picture.h"
#include "evidence/figure_table.h"
#include "evidence/studied_lamp.h"
#include "image/metric.h"

enum { PIXELS = 256, SAMPLES = 64 }; // at scale 1; samples of each half
static const struct sheet_column COLUMNS[] = {{"neural_db", "neural: dB over black", 2},
                                              {"neural_flip", "FLIP", 3},
                                              {"surface_db", "surface: dB over black", 2},
                                              {"surface_flip", "FLIP", 3},
                                              {"black_flip", "FLIP of black", 3},
                                              {"noise_flip", "FLIP of half the reference's samples", 3},
                                              {0}};

enum view { TRACED, NEURAL, SURFACE, VIEWS };

struct views { // of each two halves with samples of their own, and their mean
    struct image half[2][VIEWS], mean[VIEWS];
};

static enum status views_take(struct views *views, const struct studied_lamp *studied, int side, int samples,
                              struct error *error) {
    enum status status = STATUS_OK;
    for (int v = 0; v < VIEWS && !status; v++) {
        status = image_init(&views->mean[v], side, side, 3, error);
        for (int half = 0; half < 2 && !status; half++)
            status = image_init(&views->half[half][v], side, side, 3, error);
    }
    for (int half = 0; half < 2 && !status; half++)
        lamp_picture_take(
            &(struct lamp_picture){.luminaire = studied->luminaire,
                                   .lamp = &studied->lamp,
                                   .hull = studied->has_hull ? &studied->hull : NULL,
                                   .w = vec3_normalize((vec3){0.8f, -0.3f, 1}),
                                   .stream = (uint64_t)STREAM_EVALUATION << 56 | 6ull << 48 | (uint64_t)half << 40,
                                   .samples = (size_t)samples,
                                   .reference = &views->half[half][TRACED],
                                   .model = &views->half[half][NEURAL],
                                   .surface = &views->half[half][SURFACE]});
    for (int v = 0; v < VIEWS && !status; v++)
        for (int i = 0; i < 3 * side * side; i++)
            views->mean[v].pixels[i] = 0.5f * (views->half[0][v].pixels[i] + views->half[1][v].pixels[i]);
    return status;
}

static void views_fini(struct views *views) {
    for (int v = 0; v < VIEWS; v++) {
        image_fini(&views->mean[v]);
        image_fini(&views->half[0][v]);
        image_fini(&views->half[1][v]);
    }
}

// Mean squared error of log(1 + x) in dB below a black picture's. Products of two halves that share no samples have no
// noise in the mean.
static double gain_db(const struct views *views, enum view view) {
    const struct image *a = views->half[0], *b = views->half[1];
    double error = 0, black = 0;
    for (int i = 0; i < 3 * a[TRACED].width * a[TRACED].height; i++) {
        double ra = log1p((double)a[TRACED].pixels[i]), rb = log1p((double)b[TRACED].pixels[i]);
        error += (log1p((double)a[view].pixels[i]) - ra) * (log1p((double)b[view].pixels[i]) - rb);
        black += ra * rb;
    }
    return error > 0 && black > 0 ? 10 * log10(black / error) : (double)NAN;
}

static enum status flip_of(const struct views *views, const struct image *image, double *flip, struct error *error) {
    struct metrics metrics;
    const struct image *reference = &views->mean[TRACED];
    enum status status = metrics_compute(&metrics, image, reference, NULL, image_auto_exposure(reference), error);
    *flip = metrics.flip;
    return status;
}

static enum status show_lamp(const struct views *views, const char *name, bool has_surface, struct sheet *sheet,
                             double *values, struct error *error) {
    const float exposure = image_auto_exposure(&views->mean[TRACED]);
    struct image black = {0};
    char note[80];
    enum status status = image_init(&black, views->mean[TRACED].width, views->mean[TRACED].height, 3, error);
    if (!status) status = flip_of(views, &views->mean[NEURAL], &values[1], error);
    if (!status) status = flip_of(views, &views->mean[SURFACE], &values[3], error);
    if (!status) status = flip_of(views, &black, &values[4], error);
    if (!status) status = flip_of(views, &views->half[0][TRACED], &values[5], error);
    image_fini(&black);
    values[0] = gain_db(views, NEURAL);
    values[2] = gain_db(views, SURFACE);
    if (!has_surface) values[2] = values[3] = (double)NAN;
    sheet_row(sheet);
    if (!status) status = sheet_picture(sheet, &views->mean[TRACED], exposure, name, "traced", error);
    snprintf(note, sizeof note, "%+.1f dB over black, FLIP %.3f", values[0], values[1]);
    if (!status) status = sheet_picture(sheet, &views->mean[NEURAL], exposure, "neural", note, error);
    snprintf(note, sizeof note, "%+.1f dB over black, FLIP %.3f", values[2], values[3]);
    if (!status && has_surface) status = sheet_picture(sheet, &views->mean[SURFACE], exposure, "surface", note, error);
    return status;
}

static enum status make_views(struct figure_kit *kit, const struct figure *figure, struct sheet *sheet,
                              struct error *error) {
    (void)figure;
    double values[FIGURE_LAMPS][sizeof COLUMNS / sizeof COLUMNS[0]];
    char lamps[FIGURE_LAMPS][FIGURE_NAME];
    const int count = figure_lamps(kit, lamps);
    enum status status = STATUS_OK;
    figure_steps(kit, count);
    for (int i = 0; i < count && !status; i++) {
        struct studied_lamp studied;
        struct views views = {0};
        figure_step(kit, lamps[i]);
        if (run_cancelled(&kit->run)) return error_set(error, STATUS_CANCELLED, "cancelled");
        status = studied_lamp_open(&studied, kit, lamps[i], error);
        if (status) break;
        status = views_take(&views, &studied, figure_side(kit, PIXELS), SAMPLES, error);
        if (!status) status = show_lamp(&views, lamps[i], studied.has_hull, sheet, values[i], error);
        views_fini(&views);
        studied_lamp_close(&studied);
    }
    sheet_table(sheet, COLUMNS);
    for (int i = 0; i < count && !status; i++) sheet_line(sheet, lamps[i], values[i]);
    return status;
}

static const char CAPTION[] =
    "Orthographic views from one direction: traced lines through the geometry (what the paper trains on), the light "
    "field's prediction (appearance neural), and the hull with its view field (appearance surface). dB: mean squared "
    "error of log(1 + x) below that of a black picture, without the noise of either side; but glints that few samples "
    "find look darker to the logarithm than they are, which the dB of all lamps with clear glass suffer from. FLIP has "
    "the noise.";

const struct figure figure_views = {
    "4", "Figure 4: the lamps looked at, and what their baked files show", CAPTION, 260, make_views, NULL};
