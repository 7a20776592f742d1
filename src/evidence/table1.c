// Row after row, in the paper's order; after each the table on disk is whole again.
#include "evidence/table1.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "evidence/name_list.h"
#include "evidence/table1_output.h"

static enum status rows_choose(bool chosen[TABLE1_ROWS], const char *only, struct error *error) {
    char all[200] = "";
    size_t found = 0, named = 1;
    for (int i = 0; i < TABLE1_ROWS; i++) {
        chosen[i] = !only || name_listed(only, table1_entries[i].name);
        found += chosen[i];
        snprintf(all + strlen(all), sizeof all - strlen(all), "%s%s", i ? ", " : "", table1_entries[i].name);
    }
    for (const char *p = only; p && (p = strchr(p, ',')); p++) named++;
    if (!only || found == named) return STATUS_OK;
    return error_set(error, STATUS_INVALID, "'%s' is not a list of the table's rows; they are %s", only, all);
}

// What is missing is said before hours go by.
static enum status rows_check(struct table1_kit *kit, const bool chosen[TABLE1_ROWS], struct error *error) {
    enum status status = folder_make(kit->folder, error);
    for (int i = 0; !status && i < TABLE1_ROWS; i++) {
        const struct table1_entry *entry = &table1_entries[i];
        char path[PATH_MAX];
        if (!chosen[i]) continue;
        status = evidence_baked_check(path, &kit->data, entry->lamp, error);
        if (status) return status;
        kit->total += table1_work(kit, entry);
        table1_path(path, kit, entry, "");
        status = folder_make(path, error);
    }
    return status;
}

static enum status rows_write(const struct table1_kit *kit, const struct table1_row *rows, int count, char **json,
                              char **markdown, struct error *error) {
    char path[PATH_MAX];
    free(*json);
    free(*markdown);
    json_t *tree = table1_json(kit, rows, count);
    *json = tree ? json_dumps(tree, JSON_INDENT(1) | JSON_REAL_PRECISION(10)) : NULL;
    *markdown = table1_markdown(rows, count);
    json_decref(tree);
    if (!*json || !*markdown) return error_set(error, STATUS_MEMORY, "out of memory for the table");
    snprintf(path, sizeof path, "%s/table1.json", kit->folder);
    enum status status = file_write_atomic(path, *json, strlen(*json), error);
    snprintf(path, sizeof path, "%s/table1.md", kit->folder);
    if (!status) status = file_write_atomic(path, *markdown, strlen(*markdown), error);
    return status ? status : table1_page(kit, rows, count, error);
}

enum status table1_make(const struct table1_options *options, const struct run *run, char **json, char **markdown,
                        struct error *error) {
    *json = *markdown = NULL;
    struct table1_kit kit = {.run = run,
                             .folder = options->folder,
                             .scale = options->scale,
                             .reference = options->reference,
                             .start_s = clock_wall_s()};
    bool chosen[TABLE1_ROWS];
    struct table1_row rows[TABLE1_ROWS];
    int count = 0;
    if (!(options->scale >= 0.01 && options->scale <= 4))
        return error_set(error, STATUS_INVALID, "the scale is %g; it must lie between 0.01 and 4", options->scale);
    if (!(options->reference >= 1 && options->reference <= 64))
        return error_set(error, STATUS_INVALID,
                         "the reference has %g times the samples of bdpt; it must have 1 to 64 times as many",
                         options->reference);
    enum status status = rows_choose(chosen, options->only, error);
    if (!status) status = evidence_data_find(&kit.data, options->data, error);
    if (!status) status = rows_check(&kit, chosen, error);
    for (int i = 0; !status && i < TABLE1_ROWS; i++) {
        if (!chosen[i]) continue;
        status = table1_measure(&kit, &table1_entries[i], &rows[count], error);
        if (!status) status = rows_write(&kit, rows, ++count, json, markdown, error);
    }
    if (status == STATUS_CANCELLED)
        error_set(error, status, "stopped after %d rows; the same command goes on from here", count);
    if (status && status != STATUS_CANCELLED) {
        free(*json);
        free(*markdown);
        *json = *markdown = NULL;
    }
    if (!status) run_progress(run, "table 1", 1, clock_wall_s() - kit.start_s, NULL);
    return status;
}
