// Every figure of a row stands once in the list of columns, with its name in the JSON and its words in the table.
#include "evidence/table1_output.h"

#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>

#define FIELD(name) #name, offsetof(struct table1_row, name)

const struct table1_column table1_columns[] = {
    {FIELD(speedup), 1, "speed-up at equal error", "%.1f", 1},
    {FIELD(target), 1, "asked for", "%.0f", 1},
    {FIELD(paper_speedup), 1, "the paper's", "%.2f", 1},
    {FIELD(bdpt_spp), 1, "bdpt samples", "%.0f", 1},
    {FIELD(bdpt_cpu_s), 1, "bdpt CPU seconds", "%.4g", 1},
    {FIELD(bdpt_relmse), 1, "bdpt relMSE", "%.3g", 1},
    {FIELD(bdpt_relmse_fireflies), 1, "with its fireflies", "%.3g", 1},
    {FIELD(bdpt_relmse_whole), 1, "bdpt relMSE, whole", "%.3g", 1},
    {FIELD(bdpt_flip), 1, "bdpt FLIP", "%.3f", 1},
    {FIELD(ours_spp), 1, "ours samples", "%.0f", 1},
    {FIELD(ours_cpu_s), 1, "ours CPU seconds", "%.4g", 1},
    {FIELD(ours_relmse), 1, "ours relMSE", "%.3g", 1},
    {FIELD(ours_relmse_whole), 1, "ours relMSE, whole", "%.3g", 1},
    {FIELD(ours_flip), 1, "ours FLIP", "%.3f", 1},
    {FIELD(common_bdpt_spp), 1, "bdpt to that, samples", "%.4g", 1},
    {FIELD(common_bdpt_cpu_s), 1, "bdpt to that, CPU s", "%.4g", 1},
    {FIELD(common_speedup), 1, "speed-up at that error", "%.1f", 1},
    {FIELD(fixed_spp), 1, "like the paper, samples", "%.0f", 1},
    {FIELD(fixed_cpu_s), 1, "like the paper, CPU s", "%.4g", 1},
    {FIELD(fixed_relmse), 1, "like the paper, relMSE", "%.3g", 1},
    {FIELD(fixed_flip), 1, "like the paper, FLIP", "%.3f", 1},
    {FIELD(fixed_speedup), 1, "like the paper, x faster", "%.1f", 1},
    {FIELD(bias_spp), 1, NULL, NULL, 1},
    {FIELD(bias_cpu_s), 1, NULL, NULL, 1},
    {FIELD(bias), 1, "bias (noise-free relMSE)", "%.2g", 1},
    {FIELD(bias_error), 1, "bias, standard error", "%.1g", 1},
    {FIELD(bias_share), 1, "bias / bdpt relMSE, %", "%.0f", 100},
    {FIELD(unbiased_speedup), 1, "speed-up without bias", "%.1f", 1},
    {FIELD(noise_ratio), 1, "less noise a sample, x", "%.1f", 1},
    {FIELD(sample_cost_ratio), 1, "cheaper samples, x", "%.1f", 1},
    {FIELD(bdpt_worst_share), 1, "bdpt, in 0.1 % pixels, %", "%.0f", 100},
    {FIELD(ours_worst_share), 1, "ours, in 0.1 % pixels, %", "%.0f", 100},
    {FIELD(mean_error), 3, "picture's mean, worst %", "%+.2f", 100},
    {FIELD(flux_error), 3, "lamp's flux, worst %", "%+.2f", 100},
    {FIELD(reference_spp), 1, "reference samples", "%.0f", 1},
    {FIELD(reference_cpu_s), 1, "reference CPU seconds", "%.4g", 1},
    {FIELD(reference_noise), 1, "reference noise (relMSE)", "%.2g", 1},
    {FIELD(geometry_bytes), 1, "geometry, MB", "%.2f", 1e-6},
    {FIELD(apl_bytes), 1, "APL (the paper's), MB", "%.0f", 1e-6},
    {FIELD(file_bytes), 1, "baked lamp, MB", "%.2f", 1e-6},
    {FIELD(width), 1, NULL, NULL, 1},
    {FIELD(height), 1, NULL, NULL, 1},
    {0},
};

static const double *column_values(const struct table1_column *column, const struct table1_row *row) {
    return (const double *)(const void *)((const char *)row + column->offset);
}

void table1_cell(char *text, size_t size, const struct table1_column *column, const struct table1_row *row) {
    const double *values = column_values(column, row);
    double worst = values[0];
    for (int i = 1; i < column->count; i++)
        if (fabs(values[i]) > fabs(worst)) worst = values[i];
    if (isnan(worst))
        snprintf(text, size, "-");
    else
        snprintf(text, size, column->format, column->factor * worst);
}

static json_t *json_figure(double value) { return isfinite(value) ? json_real(value) : json_null(); }

static json_t *json_row(const struct table1_row *row) {
    char limits[TABLE1_LIMITS];
    table1_limits(row, limits, sizeof limits);
    json_t *json = json_pack("{s:s, s:s, s:s, s:s, s:s}", "name", row->entry->name, "luminaire", row->entry->luminaire,
                             "scene", row->entry->scene, "room", row->entry->room, "lamp", row->entry->lamp);
    for (const struct table1_column *column = table1_columns; column->key; column++) {
        const double *values = column_values(column, row);
        json_t *value = column->count > 1 ? json_array() : json_figure(values[0]);
        for (int i = 0; column->count > 1 && i < column->count; i++)
            json_array_append_new(value, json_figure(values[i]));
        json_object_set_new(json, column->key, value);
    }
    json_object_set_new(json, "limits", json_string(limits));
    return json;
}

json_t *table1_json(const struct table1_kit *kit, const struct table1_row *rows, int count) {
    json_t *array = json_array();
    for (int i = 0; i < count; i++) json_array_append_new(array, json_row(&rows[i]));
    return json_pack("{s:o, s:{s:f, s:f, s:i, s:I, s:s, s:s, s:s}}", "rows", array, "settings", "scale", kit->scale,
                     "reference", kit->reference, "threads", kit->run->threads, "seed", (json_int_t)kit->run->seed,
                     "version", SCONCE_VERSION, "error",
                     "relMSE (eps 1e-3) outside the lamp, less the reference's noise", "folder", kit->folder);
}

char *table1_markdown(const struct table1_row *rows, int count) {
    char *text = NULL, cell[64];
    size_t length;
    FILE *file = open_memstream(&text, &length);
    if (!file) return NULL;
    fprintf(file, "| %-24s |", "");
    for (int i = 0; i < count; i++) fprintf(file, " %8s |", rows[i].entry->name);
    fputs("\n|--------------------------|", file);
    for (int i = 0; i < count; i++) fputs("---------:|", file);
    for (const struct table1_column *column = table1_columns; column->key; column++) {
        if (!column->label) continue;
        fprintf(file, "\n| %-24s |", column->label);
        for (int i = 0; i < count; i++) {
            table1_cell(cell, sizeof cell, column, &rows[i]);
            fprintf(file, " %8s |", cell);
        }
    }
    fputs("\n\n", file);
    for (int i = 0; i < count; i++) {
        char limits[TABLE1_LIMITS];
        table1_limits(&rows[i], limits, sizeof limits);
        fprintf(file, "- %s, %s: %s\n", rows[i].entry->luminaire, rows[i].entry->scene, limits);
    }
    if (fclose(file)) {
        free(text);
        return NULL;
    }
    return text;
}
