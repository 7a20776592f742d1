// Drafts: what is compared differs in one thing, and each takes a minute.
#include "evidence/kept_bake.h"

#include <stdio.h>

#include "evidence/kept.h"
#include "evidence/scene_files.h"

const struct sheet_column bake_columns[BAKE_MEASURES + 1] = {
    [BAKE_MEGABYTES] = {"megabytes", "MB", 2},
    [BAKE_STEPS] = {"kilosteps", "thousand steps", 2},
    [BAKE_TRACED] = {"traced_millions", "million lines traced", 1},
    [BAKE_SECONDS] = {"cpu_s", "CPU seconds", 0},
    [BAKE_FLUX_KEPT] = {"flux_kept", "flux before scaling, %", 1},
    [BAKE_IRRADIANCE_NEAR] = {"irradiance_near", "irradiance error at 1.2 radii, %", 2},
    [BAKE_IRRADIANCE_FAR] = {"irradiance_far", "at 10 radii, %", 2},
    [BAKE_IRRADIANCE_NOISE] = {"irradiance_noise", "of which noise, %", 2},
    [BAKE_LIGHT_FIELD] = {"light_field", "light field error", 4},
    [BAKE_TRANSPARENCY] = {"transparency", "transparency error", 3},
    [BAKE_VARIANCE] = {"sample_variance", "variance of a light sample", 2},
};

static void measure(const struct bake_report *report, double cpu_s, double values[BAKE_MEASURES]) {
    const struct evaluation *e = &report->evaluation;
    double kept = 0;
    for (int c = 0; c < 3; c++) kept += 100 / (3 * (double)report->scale[c]);
    values[BAKE_MEGABYTES] = 1e-6 * (double)report->bytes;
    values[BAKE_STEPS] = 1e-3 * (double)report->steps;
    values[BAKE_TRACED] = 1e-6 * (double)report->traced;
    values[BAKE_SECONDS] = cpu_s;
    values[BAKE_FLUX_KEPT] = kept;
    values[BAKE_IRRADIANCE_NEAR] = 100 * (double)e->irradiance_error[0];
    values[BAKE_IRRADIANCE_FAR] = 100 * (double)e->irradiance_error[EVALUATION_DISTANCES - 1];
    values[BAKE_IRRADIANCE_NOISE] = 100 * (double)e->irradiance_noise[0];
    values[BAKE_LIGHT_FIELD] = (double)e->light_field_error;
    values[BAKE_TRANSPARENCY] = (double)e->transparency_error;
    values[BAKE_VARIANCE] = (double)e->sample_variance;
}

static enum status bake_now(struct figure_kit *kit, const struct bake_request *r, const char *lamp, const char *key,
                            const char *numbers, double values[BAKE_MEASURES], struct error *error) {
    char output[PATH_MAX];
    snprintf(output, sizeof output, "%s/kept/%s.safetensors", kit->folder, r->name);
    const struct bake_options options = {
        .lamp_path = lamp, .output_path = output, .quality = BAKE_DRAFT, .size = r->size};
    struct bake_plan plan = bake_plan_work(&options);
    struct bake_report report;
    if (r->change) r->change(&plan, r->amount);
    const double start = clock_cpu_s();
    enum status status = bake_lamp_plan(&options, &plan, &kit->run, &report, error);
    if (status) return status;
    measure(&report, clock_cpu_s() - start, values);
    json_t *object = json_pack("{s:s}", "key", key);
    for (int i = 0; i < BAKE_MEASURES; i++) json_object_set_new(object, bake_columns[i].key, json_real(values[i]));
    return kept_save(numbers, object, error);
}

enum status kept_bake(struct figure_kit *kit, const struct bake_request *r, double values[BAKE_MEASURES],
                      struct error *error) {
    char lamp[PATH_MAX], numbers[PATH_MAX], key[200];
    struct scene_files files;
    evidence_lamp(lamp, &kit->data, r->lamp);
    snprintf(numbers, sizeof numbers, "%s/kept/%s.json", kit->folder, r->name);
    figure_step(kit, r->name);
    enum status status = scene_files_measure(&files, lamp, NULL, 0, error);
    if (status) return status;
    snprintf(key, sizeof key, "draft of size %d, amount %g, seed %llu, files %016llx", (int)r->size, r->amount,
             (unsigned long long)kit->run.seed, (unsigned long long)files.hash);
    json_t *kept = kept_load(numbers, key);
    if (!kept) return bake_now(kit, r, lamp, key, numbers, values, error);
    for (int i = 0; i < BAKE_MEASURES; i++) values[i] = json_number_value(json_object_get(kept, bake_columns[i].key));
    json_decref(kept);
    return STATUS_OK;
}
