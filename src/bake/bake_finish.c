// The last stage: everything is put together, written and measured on held-out light. The file is measured as it will
// be read: after quantisation.
#include <jansson.h>
#include <libgen.h>
#include <limits.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bake/bake_job.h"
#include "bake/lamp_proxy.h"
#include "bake/lamp_scattering.h"
#include "format/safetensors.h"

enum { VALUE_SIZE = 4400, KEYS = 12 };
static const char *const quality_names[] = {"draft", "standard", "high"};

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
static enum status add_measurements(const char *path, const struct evaluation *evaluation, const char *groups,
                                    struct error *error) {
    struct safetensors file;
    enum status status = safetensors_load(&file, path, error);
    if (status != STATUS_OK) return status;
    char *json = evaluation_json(evaluation);
    size_t n = file.metadata_count;
    const char **keys = calloc(n + 2, sizeof *keys), **values = calloc(n + 2, sizeof *values);
    if (!json || !keys || !values)
        status = error_set(error, STATUS_MEMORY, "out of memory for the metadata");
    else {
        memcpy(keys, file.metadata_keys, n * sizeof *keys);
        memcpy(values, file.metadata_values, n * sizeof *values);
        keys[n] = "bake.evaluation";
        values[n++] = json;
        if (groups) {
            keys[n] = "bake.groups";
            values[n++] = groups;
        }
        struct safetensors measured = file;
        measured.metadata_keys = keys;
        measured.metadata_values = values;
        measured.metadata_count = n;
        status = safetensors_save(&measured, path, error);
    }
    free(keys);
    free(values);
    free(json);
    safetensors_fini(&file);
    return status;
}

static void take_group(struct baked_group *from, struct baked_group *to) { // who takes it owns it
    *to = *from;
    *from = (struct baked_group){0};
}

static enum status assemble_compact(struct bake_job *job, const struct metadata *metadata, struct luminaire **luminaire,
                                    struct error *error) {
    struct baked_group baked;
    struct transparency *transparency = job->transparency;
    struct hull *hull = job->view.hull;
    job->transparency = NULL;
    take_group(&job->baked[0], &baked);
    enum status status = luminaire_assemble(luminaire, &job->lamp.proxy, baked.field, transparency, baked.density,
                                            baked.flux, metadata->keys, metadata->values, metadata->count, error);
    if (status == STATUS_OK && hull) {
        job->view.hull = NULL;
        status = luminaire_set_view(*luminaire, hull, baked.view, error);
    } else
        view_field_destroy(baked.view);
    for (size_t g = 1; g < job->groups.count && status == STATUS_OK; g++) {
        take_group(&job->baked[g], &baked);
        if (!hull) view_field_destroy(baked.view);
        status =
            luminaire_add_group(*luminaire, baked.field, baked.density, hull ? baked.view : NULL, baked.flux, error);
    }
    return status == STATUS_OK && job->groups.count ? luminaire_name_groups(*luminaire, job->groups.names, error)
                                                    : status;
}

static enum status assemble_paper(struct bake_job *job, const struct metadata *metadata, struct luminaire **luminaire,
                                  struct error *error) {
    struct paper *paper = job->paper;
    job->paper = NULL; // the luminaire owns it now
    return luminaire_assemble_paper(luminaire, &job->lamp.proxy, paper, job->baked[0].flux, metadata->keys,
                                    metadata->values, metadata->count, error);
}

static enum status assemble(struct bake_job *job, const struct bake_report *report, struct luminaire **luminaire,
                            struct error *error) {
    struct metadata *metadata = calloc(1, sizeof *metadata);
    if (!metadata) return error_set(error, STATUS_MEMORY, "out of memory for the metadata");
    describe_bake(metadata, job, report);
    enum status status = job->paper ? assemble_paper(job, metadata, luminaire, error)
                                    : assemble_compact(job, metadata, luminaire, error);
    free(metadata);
    return status;
}

// Of each group alone: its flux against the traced one, and its irradiance. *json is freed by the caller.
static enum status evaluate_groups(struct bake_job *job, const struct luminaire *luminaire, char **json,
                                   struct error *error) {
    const struct evaluation_effort effort = {.particles = job->plan.evaluation.particles / 4,
                                             .lines = job->plan.evaluation.lines / 4};
    const size_t count = job->groups.count;
    json_t *list = json_array();
    enum status status = STATUS_OK;
    for (size_t g = 0; g < count && status == STATUS_OK; g++) {
        float factors[LUMINAIRE_MAX_GROUPS][3] = {{0}};
        for (int c = 0; c < 3; c++) factors[g][c] = 1;
        struct luminaire *alone;
        struct evaluation evaluation;
        status = luminaire_dim(&alone, luminaire, (const float(*)[3])factors, error);
        if (status != STATUS_OK) break;
        bake_light_group(job, (int)g);
        status = evaluate_luminaire(alone, &job->scene, &effort, job->run, &evaluation, error);
        luminaire_destroy(alone);
        if (status != STATUS_OK) break;
        char *text = evaluation_json(&evaluation);
        json_t *one = text ? json_loads(text, 0, NULL) : NULL;
        free(text);
        json_object_set_new(one, "name", json_string(job->groups.names[g]));
        json_array_append_new(list, one);
    }
    bake_light_group(job, -1);
    if (status == STATUS_OK && !(*json = json_dumps(list, JSON_COMPACT | JSON_REAL_PRECISION(6))))
        status = error_set(error, STATUS_MEMORY, "out of memory for the groups' measurements");
    json_decref(list);
    return status;
}

enum status bake_finish(struct bake_job *job, struct bake_report *report, struct error *error) {
    const double start = clock_wall_s();
    run_progress(job->run, "finishing", 0, 0, NULL);
    *report = (struct bake_report){
        .proxy = proxy_kind_name(job->lamp.proxy.kind),
        .encoding = job->paper ? "frequencies" : encoding_choices[job->recipe.encoding].name,
        .data = data_source_names[job->recipe.data],
        .anchor_count = job->work.anchor_count,
        .clear_share = job->work.clear_share,
        .steps = job->work.steps,
        .traced = job->work.traced,
        .scale = {job->work.scale[0], job->work.scale[1], job->work.scale[2]},
    };
    struct luminaire *luminaire = NULL;
    enum status status = assemble(job, report, &luminaire, error);
    if (status == STATUS_OK) status = lamp_scattering_measure(luminaire, &job->lamp, error);
    run_progress(job->run, "finishing", 0.8, clock_wall_s() - start, NULL);
    if (status == STATUS_OK) status = luminaire_save(luminaire, job->options->output_path, error);
    run_progress(job->run, "finishing", 1, clock_wall_s() - start, NULL);
    if (status == STATUS_OK)
        status =
            evaluate_luminaire(luminaire, &job->scene, &job->plan.evaluation, job->run, &report->evaluation, error);
    char *groups = NULL;
    if (status == STATUS_OK && job->groups.count) status = evaluate_groups(job, luminaire, &groups, error);
    if (status == STATUS_CANCELLED)
        error_set(error, status, "cancelled; %s is complete but was not measured", job->options->output_path);
    report->seconds = clock_wall_s() - job->start_s;
    if (status == STATUS_OK) status = add_measurements(job->options->output_path, &report->evaluation, groups, error);
    free(groups);
    luminaire_destroy(luminaire);
    if (status == STATUS_OK) status = luminaire_load(&luminaire, job->options->output_path, error);
    if (status == STATUS_OK) {
        report->bytes = luminaire_bytes(luminaire);
        luminaire_destroy(luminaire);
    }
    return status;
}
