// Scores of a light field that is still being trained; see training.h.
#include <stdlib.h>
#include <string.h>

#include "bake/training.h"
#include "base/parallel.h"

enum { BLOCK = 4096, FLUX_BATCH = 1 << 16 };
static const double flux_noise_goal = 0.0008;

struct eval_job {
    const struct light_field *field;
    size_t n;
    const float *point, *w; // of the first line
    size_t stride; // in floats
    float (*radiance)[3];
};

static void eval_block(void *user, size_t block, int worker) {
    (void)worker;
    const struct eval_job *job = user;
    float point[BLOCK][3], w[BLOCK][3];
    size_t begin = block * BLOCK, n = job->n - begin < BLOCK ? job->n - begin : BLOCK;
    for (size_t i = 0; i < n; i++) {
        memcpy(point[i], job->point + (begin + i) * job->stride, sizeof point[i]);
        memcpy(w[i], job->w + (begin + i) * job->stride, sizeof w[i]);
    }
    light_field_eval(job->field, n, (const float(*)[3])point, (const float(*)[3])w, job->radiance + begin);
}

static void eval_lines(const struct light_field *field, const struct line_sample *lines, size_t n, int threads,
                       float (*radiance)[3]) {
    struct eval_job job = {field, n, lines->point, lines->w, sizeof *lines / sizeof(float), radiance};
    parallel_for(threads, (n + BLOCK - 1) / BLOCK, eval_block, &job);
}

enum status held_out_create(struct held_out *held_out, const struct lamp *lamp, const struct line_guide *guide,
                            size_t n, struct error *error) {
    *held_out = (struct held_out){.line_count = n};
    enum status status = gather_exits(&held_out->exits, lamp, STREAM_HELD_OUT, 0, n, false, NULL, error);
    if (status != STATUS_OK) return status;
    held_out->lines = malloc(n * sizeof *held_out->lines);
    if (!held_out->lines) return error_set(error, STATUS_MEMORY, "out of memory for the held-out lines");
    gather_lines(held_out->lines, lamp, guide, STREAM_HELD_OUT, 0, n, false);
    return STATUS_OK;
}

void held_out_destroy(struct held_out *held_out) {
    exit_list_fini(&held_out->exits);
    free(held_out->lines);
    *held_out = (struct held_out){0};
}

enum status held_out_score(const struct held_out *held_out, const struct light_field *field, const struct lamp *lamp,
                           double *score, struct error *error) {
    const struct exit_list *exits = &held_out->exits;
    size_t most = exits->count > held_out->line_count ? exits->count : held_out->line_count;
    float(*radiance)[3] = malloc((most + 1) * sizeof *radiance);
    if (!radiance) return error_set(error, STATUS_MEMORY, "out of memory for the held-out score");
    double integral[3] = {0, 0, 0}, sum = 0, flux = 0;
    eval_lines(field, held_out->lines, held_out->line_count, lamp->threads, radiance);
    for (size_t i = 0; i < held_out->line_count; i++)
        for (int c = 0; c < 3; c++) integral[c] += (double)(radiance[i][c] * held_out->lines[i].mass);
    struct eval_job job = {
        field, exits->count, exits->exits->point, exits->exits->w, sizeof *exits->exits / sizeof(float), radiance};
    parallel_for(lamp->threads, (exits->count + BLOCK - 1) / BLOCK, eval_block, &job);
    double r2 = (double)lamp->proxy.radius * (double)lamp->proxy.radius;
    for (int c = 0; c < 3; c++) {
        double mean = integral[c] / (double)held_out->line_count / r2; // radiance unit: the score has no dimension
        if (!(mean > 0)) continue;
        for (size_t i = 0; i < exits->count; i++) {
            double y = (double)exits->exits[i].flux[c];
            sum -= y * log(fmax((double)radiance[i][c] / mean, 1e-9));
            flux += y;
        }
    }
    free(radiance);
    *score = flux > 0 ? sum / flux : 0;
    return STATUS_OK;
}

// The lines of a batch that cross the lamp, as if they were exits of one particle each.
static void keep_exits(struct exit_list *exits, const struct line_sample *lines, const float (*radiance)[3]) {
    for (size_t i = 0; i < FLUX_BATCH; i++) {
        if (!(lines[i].mass > 0)) continue;
        struct line_exit *exit = &exits->exits[exits->count++];
        memcpy(exit->point, lines[i].point, sizeof exit->point);
        memcpy(exit->w, lines[i].w, sizeof exit->w);
        for (int c = 0; c < 3; c++) exit->flux[c] = radiance[i][c] * lines[i].mass;
    }
    exits->emitted += FLUX_BATCH;
}

enum status light_field_exits(const struct light_field *field, const struct lamp *lamp, const struct line_guide *guide,
                              size_t least, size_t most, struct exit_list *exits, double flux[3], double noise[3],
                              struct error *error) {
    const size_t batches = (least + FLUX_BATCH - 1) / FLUX_BATCH, last = (most + FLUX_BATCH - 1) / FLUX_BATCH;
    struct line_sample *lines = malloc(FLUX_BATCH * sizeof *lines);
    float(*radiance)[3] = malloc(FLUX_BATCH * sizeof *radiance);
    *exits = (struct exit_list){.exits = malloc((batches * FLUX_BATCH + 1) * sizeof *exits->exits)};
    double sum[3] = {0, 0, 0}, squares[3] = {0, 0, 0}, largest = (double)INFINITY;
    for (size_t b = 0; b < (batches > last ? batches : last); b++) {
        if (!lines || !radiance || !exits->exits || (b >= batches && largest < flux_noise_goal)) break;
        gather_lines(lines, lamp, guide, STREAM_SCALE, b * FLUX_BATCH, FLUX_BATCH, false);
        eval_lines(field, lines, FLUX_BATCH, lamp->threads, radiance);
        if (b < batches) keep_exits(exits, lines, (const float(*)[3])radiance);
        for (size_t i = 0; i < FLUX_BATCH; i++)
            for (int c = 0; c < 3; c++) {
                double y = (double)(radiance[i][c] * lines[i].mass);
                sum[c] += y;
                squares[c] += y * y;
            }
        double n = (double)((b + 1) * FLUX_BATCH);
        largest = 0;
        for (int c = 0; c < 3; c++) {
            flux[c] = sum[c] / n;
            noise[c] = flux[c] > 0 ? sqrt(fmax(0, squares[c] / n - flux[c] * flux[c]) / n) / flux[c] : 0;
            largest = fmax(largest, noise[c]);
        }
    }
    enum status status = lines && radiance && exits->exits
                             ? STATUS_OK
                             : error_set(error, STATUS_MEMORY, "out of memory for the model's flux");
    free(lines);
    free(radiance);
    return status;
}
