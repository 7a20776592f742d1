// The transparency on uniform lines. T of one line of glass is a mean over random paths (which surface reflects, where
// rough glass sends them), so a line's reference is a mean of many: one estimate's own error would be taken for the
// luminaire's.
#include <math.h>
#include <stdlib.h>

#include "bake/evaluate_private.h"

enum { LINE_REPEATS = 512, ROUNDS = 2 };

enum status evaluate_transparency(const struct luminaire *luminaire, const struct lamp *lamp, size_t count,
                                  struct evaluation *evaluation, struct error *error) {
    struct line_sample *lines = malloc(ROUNDS * count * sizeof *lines), *again = lines + count;
    if (!lines) return error_set(error, STATUS_MEMORY, "out of memory for the evaluation");
    gather_transmittance(lines, lamp, STREAM_EVALUATION, 0, count, LINE_REPEATS, 0, NULL);
    gather_transmittance(again, lamp, STREAM_EVALUATION, 0, count, LINE_REPEATS, 1, NULL);
    double error_sum = 0, reference_sum = 0, noise_sum = 0;
    for (size_t i = 0; i < count; i++) {
        float t[3];
        luminaire_transmittance(luminaire, 1, (const float(*)[3])lines[i].point, (const float(*)[3])lines[i].w, &t);
        for (int c = 0; c < 3; c++) {
            double reference = 0.5 * (double)(lines[i].target[c] + again[i].target[c]);
            error_sum += fabs((double)t[c] - reference);
            reference_sum += reference;
            noise_sum += 0.5 * fabs((double)(lines[i].target[c] - again[i].target[c]));
        }
    }
    evaluation->transparency_error = (float)(error_sum / (3 * (double)count));
    evaluation->transparency_error_opaque = (float)(reference_sum / (3 * (double)count));
    evaluation->transparency_noise = (float)(noise_sum / (3 * (double)count));
    free(lines);
    return STATUS_OK;
}
