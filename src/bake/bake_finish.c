// The last stage: the light field is scaled to the particles' flux, the sampling density is built, everything is put
// together, measured on held-out light and written. The file is measured as it will be read: after quantisation.
#include <libgen.h>
#include <limits.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bake/bake_job.h"
#include "bake/lamp_proxy.h"
#include "format/safetensors.h"

enum { VALUE_SIZE = 4400, KEYS = 12 };
static const char *const quality_names[] = {"draft", "standard", "high"};

// Fills `exits` with lines as the field shows them.
static enum status scale_light(struct bake_job *job, struct exit_list *exits, float scale[3], struct error *error) {
    double flux[3], noise[3];
    enum status status = light_field_finish(job->light.field, error);
    if (status != STATUS_OK) return status;
    status = light_field_exits(job->light.field, &job->lamp, job->guide, job->field_lines, job->most_field_lines, exits,
                               flux, noise, error);
    if (status != STATUS_OK) return status;
    for (int c = 0; c < 3; c++) {
        scale[c] = flux[c] > 0 ? (float)(job->survey.flux[c] / flux[c]) : 1;
        if (job->survey.flux[c] > 0 && fabs((double)scale[c] - 1) > 0.25)
            run_warn(job->run,
                     "channel %d of the light field had %.0f %% of the traced flux before it was scaled; bake longer",
                     c, 100 / (double)scale[c]);
        if (noise[c] > 0.003 || job->survey.flux_noise[c] > 0.003)
            run_warn(job->run, "the flux of channel %d is known to %.2f %% only (of the lamp: %.2f %%)", c,
                     100 * noise[c], 100 * job->survey.flux_noise[c]);
    }
    light_field_set_scale(job->light.field, scale);
    for (size_t i = 0; i < exits->count; i++)
        for (int c = 0; c < 3; c++) exits->exits[i].flux[c] *= scale[c];
    return STATUS_OK;
}

// `to` as seen from the folder of `from_file`; absolute where the two share no folder.
static void path_relative(char *result, size_t size, const char *from_file, const char *to) {
    char folder[PATH_MAX], from[PATH_MAX], target[PATH_MAX];
    snprintf(folder, sizeof folder, "%s", from_file);
    if (!realpath(dirname(folder), from) || !realpath(to, target)) {
        snprintf(result, size, "%s", to);
        return;
    }
    size_t common = 0, i = 0; // length up to and with the last shared slash
    if (strcmp(from, "/") != 0) strncat(from, "/", sizeof from - strlen(from) - 1);
    for (; from[i] && from[i] == target[i]; i++)
        if (from[i] == '/') common = i + 1;
    size_t used = 0;
    result[0] = 0;
    for (const char *p = from + common; *p; p++)
        if (*p == '/' && used + 4 < size) used += (size_t)snprintf(result + used, size - used, "../");
    snprintf(result + used, size - used, "%s", target + common);
}

struct metadata {
    const char *keys[KEYS], *values[KEYS];
    char text[KEYS][VALUE_SIZE];
    size_t count;
};

__attribute__((format(printf, 3, 4))) static void metadata_add(struct metadata *m, const char *key, const char *format,
                                                               ...) {
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(m->text[m->count], VALUE_SIZE, format, arguments);
    va_end(arguments);
    m->keys[m->count] = key;
    m->values[m->count] = m->text[m->count];
    m->count++;
}

static void describe_bake(struct metadata *m, const struct bake_job *job, const struct bake_report *report) {
    char source[PATH_MAX];
    path_relative(source, sizeof source, job->options->output_path, job->scene.path);
    metadata_add(m, "bake.source", "%s", source);
    metadata_add(m, "bake.source_hash", "%016llx", (unsigned long long)job->identity);
    metadata_add(m, "bake.units", "lengths and radiance as in the source");
    metadata_add(m, "bake.seed", "%llu", (unsigned long long)job->run->seed);
    if (job->options->seconds > 0)
        metadata_add(m, "bake.quality", "%g seconds", job->options->seconds);
    else
        metadata_add(m, "bake.quality", "%s", quality_names[job->options->quality]);
    if (job->paper) metadata_add(m, "bake.preset", "paper");
    metadata_add(m, "bake.proxy", "%s", report->proxy);
    metadata_add(m, "bake.encoding", "%s", report->encoding);
    metadata_add(m, "bake.data", "%s", report->data);
    metadata_add(m, "bake.clear_share", "%.3f", (double)report->clear_share);
    metadata_add(m, "bake.work", "%zu steps, %zu traced lines and particles", report->steps, report->traced);
}

// Adds what is known only after the luminaire was measured to the file.
static enum status add_measurements(const char *path, const struct evaluation *evaluation, struct error *error) {
    struct safetensors file;
    enum status status = safetensors_load(&file, path, error);
    if (status != STATUS_OK) return status;
    char *json = evaluation_json(evaluation);
    size_t n = file.metadata_count;
    const char **keys = calloc(n + 1, sizeof *keys), **values = calloc(n + 1, sizeof *values);
    if (!json || !keys || !values)
        status = error_set(error, STATUS_MEMORY, "out of memory for the metadata");
    else {
        memcpy(keys, file.metadata_keys, n * sizeof *keys);
        memcpy(values, file.metadata_values, n * sizeof *values);
        keys[n] = "bake.evaluation";
        values[n] = json;
        struct safetensors measured = file;
        measured.metadata_keys = keys;
        measured.metadata_values = values;
        measured.metadata_count = n + 1;
        status = safetensors_save(&measured, path, error);
    }
    free(keys);
    free(values);
    free(json);
    safetensors_fini(&file);
    return status;
}

// The sampling density is of the light field, not of the lamp: where the field is blurred, light is drawn there too.
static enum status assemble_compact(struct bake_job *job, const struct exit_list *exits,
                                    const struct metadata *metadata, const float flux[3], struct luminaire **luminaire,
                                    struct error *error) {
    float anchors[SURVEY_CLUSTERS][3];
    for (size_t i = 0; i < job->survey.cluster_count; i++)
        memcpy(anchors[i], &job->survey.clusters[i].center, sizeof anchors[i]);
    struct sampling_density *density;
    enum status status =
        sampling_density_build(&density, &job->lamp.proxy, (const float(*)[3])anchors, job->survey.cluster_count,
                               exits->exits, exits->count, job->lamp.seed, job->run->threads, error);
    if (status != STATUS_OK) return status;
    struct light_field *field = job->light.field;
    struct transparency *transparency = job->transparency;
    job->light.field = NULL; // the luminaire owns them now
    job->transparency = NULL;
    return luminaire_assemble(luminaire, &job->lamp.proxy, field, transparency, density, flux, metadata->keys,
                              metadata->values, metadata->count, error);
}

static enum status assemble_paper(struct bake_job *job, const struct metadata *metadata, const float flux[3],
                                  struct luminaire **luminaire, struct error *error) {
    struct paper *paper = job->paper;
    job->paper = NULL; // the luminaire owns it now
    return luminaire_assemble_paper(luminaire, &job->lamp.proxy, paper, flux, metadata->keys, metadata->values,
                                    metadata->count, error);
}

static enum status assemble(struct bake_job *job, const struct exit_list *exits, const struct bake_report *report,
                            struct luminaire **luminaire, struct error *error) {
    struct metadata *metadata = calloc(1, sizeof *metadata);
    if (!metadata) return error_set(error, STATUS_MEMORY, "out of memory for the metadata");
    describe_bake(metadata, job, report);
    const float flux[3] = {(float)job->survey.flux[0], (float)job->survey.flux[1], (float)job->survey.flux[2]};
    enum status status = job->paper ? assemble_paper(job, metadata, flux, luminaire, error)
                                    : assemble_compact(job, exits, metadata, flux, luminaire, error);
    if (status == STATUS_OK && job->view.hull) {
        status = luminaire_set_view(*luminaire, job->view.hull, job->view.field, error);
        job->view = (struct view_result){NULL, NULL};
    }
    free(metadata);
    return status;
}

enum status bake_finish(struct bake_job *job, struct bake_report *report, struct error *error) {
    const double start = clock_wall_s();
    run_progress(job->run, "finishing", 0, 0, NULL);
    *report = (struct bake_report){
        .proxy = proxy_kind_name(job->lamp.proxy.kind),
        .encoding = job->paper ? "frequencies" : encoding_choices[job->light.recipe.encoding].name,
        .data = data_source_names[job->light.recipe.data],
        .anchor_count = job->survey.cluster_count,
        .clear_share = job->survey.clear_share,
        .steps = job->checkpoint.light_chunks * CHUNK_STEPS,
        .traced = job->light.traced + job->survey.exits.emitted,
        .scale = {1, 1, 1},
    };
    struct luminaire *luminaire = NULL;
    struct exit_list exits = {0};
    enum status status =
        job->paper ? STATUS_OK : scale_light(job, &exits, report->scale, error); // the published are not scaled
    run_progress(job->run, "finishing", 0.4, clock_wall_s() - start, NULL);
    if (status == STATUS_OK) status = assemble(job, &exits, report, &luminaire, error);
    exit_list_fini(&exits);
    run_progress(job->run, "finishing", 0.8, clock_wall_s() - start, NULL);
    if (status == STATUS_OK) status = luminaire_save(luminaire, job->options->output_path, error);
    run_progress(job->run, "finishing", 1, clock_wall_s() - start, NULL);
    exit_list_fini(&job->survey.exits);
    if (status == STATUS_OK)
        status =
            evaluate_luminaire(luminaire, &job->scene, &job->plan.evaluation, job->run, &report->evaluation, error);
    if (status == STATUS_CANCELLED)
        error_set(error, status, "cancelled; %s is complete but was not measured", job->options->output_path);
    report->seconds = clock_wall_s() - job->start_s;
    if (status == STATUS_OK) status = add_measurements(job->options->output_path, &report->evaluation, error);
    luminaire_destroy(luminaire);
    if (status == STATUS_OK) status = luminaire_load(&luminaire, job->options->output_path, error);
    if (status == STATUS_OK) {
        report->bytes = luminaire_bytes(luminaire);
        luminaire_destroy(luminaire);
    }
    return status;
}
