#include "bake/lamp_scattering.h"

#include <math.h>
#include <stdlib.h>

enum { LINES = 1 << 15 };

static void mean_target(const struct line_sample *lines, double mean[3]) {
    for (int c = 0; c < 3; c++) {
        double sum = 0;
        for (size_t i = 0; i < LINES; i++) sum += (double)lines[i].target[c];
        mean[c] = sum / LINES;
    }
}

static void mean_transmittance(const struct luminaire *luminaire, const struct line_sample *lines, double mean[3]) {
    double sum[3] = {0};
    for (size_t i = 0; i < LINES; i++) {
        float t[1][3];
        luminaire_transmittance(luminaire, 1, &lines[i].point, &lines[i].w, t);
        for (int c = 0; c < 3; c++) sum[c] += (double)t[0][c];
    }
    for (int c = 0; c < 3; c++) mean[c] = sum[c] / LINES;
}

enum status lamp_scattering_measure(struct luminaire *luminaire, const struct lamp *lamp, struct error *error) {
    struct line_sample *lines = calloc(LINES, sizeof *lines);
    if (!lines) return error_set(error, STATUS_MEMORY, "out of memory for the lamp's scattering");
    double all[3], onward[3], through[3];
    gather_escapes(lines, lamp, STREAM_SCATTERING, LINES, false);
    mean_target(lines, all);
    gather_escapes(lines, lamp, STREAM_SCATTERING, LINES, true);
    mean_target(lines, onward);
    mean_transmittance(luminaire, lines, through);
    free(lines);
    float shares[2][3]; // back, onward
    for (int c = 0; c < 3; c++) {
        const double stopped = fmax(1 - through[c], 1e-6);
        const double back = fmin(fmax((all[c] - onward[c]) / stopped, 0), 1);
        shares[0][c] = (float)back;
        shares[1][c] = (float)fmin(fmax((onward[c] - through[c]) / stopped, 0), 1 - back) * (1 - 1e-6f);
    }
    return luminaire_set_scattering(luminaire, shares[0], shares[1], error);
}
