// Goes through the table, figure by figure. After each the page is written anew from the kept files, so that it is
// whole at any moment.
#include "evidence/figures.h"

#include <glob.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "base/file.h"
#include "base/hash.h"
#include "evidence/figure_table.h"
#include "evidence/kept.h"
#include "evidence/name_list.h"

#define FIGURE_ENTRY(NAME) &figure_##NAME,
static const struct figure *const TABLE[] = {FIGURE_TABLE(FIGURE_ENTRY)};
enum { FIGURES = sizeof TABLE / sizeof TABLE[0] };

static const char ABLATIONS[] = "ablations"; // in --only: all figures whose names begin so

struct figure_progress {
    const struct run *outer;
    double start_s, all, done, cost; // of the whole run, before this figure, of this figure
    int step, steps; // the figure's steps so far, and all
    double fraction; // what was shown last: it never falls
    char what[100];
};

static void show_progress(struct figure_progress *p, double step_fraction) {
    double in_figure = p->steps ? fmin((p->step - 1 + step_fraction) / p->steps, 1) : 0;
    p->fraction = fmax(p->fraction, fmin((p->done + p->cost * fmax(in_figure, 0)) / p->all, 1));
    run_progress(p->outer, "figures", p->fraction, clock_wall_s() - p->start_s, p->what);
}

static void progress(void *user, const struct progress *inner) { show_progress(user, inner->fraction); }
static bool cancelled(void *user) { return run_cancelled(((struct figure_progress *)user)->outer); }
static void message(void *user, enum message_level level, const char *text) {
    if (level == MESSAGE_WARNING) run_warn(((struct figure_progress *)user)->outer, "%s", text);
}

void figure_steps(struct figure_kit *kit, int steps) { kit->progress->steps = steps; }

void figure_step(struct figure_kit *kit, const char *what) {
    struct figure_progress *p = kit->progress;
    p->step++;
    snprintf(p->what, sizeof p->what, "%s", what);
    show_progress(p, 0);
}

int figure_side(const struct figure_kit *kit, int pixels) {
    return (int)fmax(16, round(pixels * sqrt(fmin(kit->scale, 1))));
}
int figure_count(const struct figure_kit *kit, int count) { return (int)fmax(1, round(count * kit->scale)); }

int figure_lamps(const struct figure_kit *kit, char names[FIGURE_LAMPS][FIGURE_NAME]) {
    char pattern[PATH_MAX], geometry[PATH_MAX];
    glob_t baked;
    int count = 0;
    evidence_baked(pattern, &kit->data, "*");
    if (glob(pattern, 0, NULL, &baked)) return 0;
    for (size_t i = 0; i < baked.gl_pathc && count < FIGURE_LAMPS; i++) {
        const char *name = strrchr(baked.gl_pathv[i], '/') + 1;
        snprintf(names[count], FIGURE_NAME, "%.*s", (int)(strrchr(name, '.') - name), name);
        evidence_lamp(geometry, &kit->data, names[count]);
        if (!access(geometry, R_OK)) count++;
    }
    globfree(&baked);
    return count;
}

// What all figures are made from: a lamp that was baked again makes them anew, but only its own renderings.
static enum status key_make(char *key, size_t size, const struct figure_kit *kit, struct error *error) {
    char lamps[FIGURE_LAMPS][FIGURE_NAME], path[PATH_MAX];
    const int count = figure_lamps(kit, lamps);
    uint64_t hash = HASH_START;
    enum status status = STATUS_OK;
    for (int i = 0; i < count && !status; i++) {
        evidence_baked(path, &kit->data, lamps[i]);
        status = kept_hash_file(&hash, path, error);
    }
    if (!status && kit->paper) status = kept_hash_file(&hash, kit->paper, error);
    snprintf(key, size, "scale %g, seed %llu, baked lamps %016llx", kit->scale, (unsigned long long)kit->run.seed,
             (unsigned long long)hash);
    return status;
}

static bool is_ablation(const struct figure *figure) { return !strncmp(figure->name, "ablation", 8); }

static bool wanted(const struct figures_options *options, const struct figure *figure) {
    if (!options->only) return !is_ablation(figure);
    return name_listed(options->only, figure->name) || (is_ablation(figure) && name_listed(options->only, ABLATIONS));
}

// Every name in --only must be one of the table's.
static enum status check_names(const struct figures_options *options, struct error *error) {
    for (const char *p = options->only; p;) {
        const char *end = strchr(p, ',');
        char name[40], all[400] = "";
        snprintf(name, sizeof name, "%.*s", (int)(end ? end - p : (long)strlen(p)), p);
        bool known = !strcmp(name, ABLATIONS);
        for (int i = 0; i < FIGURES; i++) {
            known = known || !strcmp(name, TABLE[i]->name);
            snprintf(all + strlen(all), sizeof all - strlen(all), "%s, ", TABLE[i]->name);
        }
        if (!known)
            return error_set(error, STATUS_INVALID, "there is no figure '%s'; there are %s%s", name, all, ABLATIONS);
        p = end ? end + 1 : NULL;
    }
    return STATUS_OK;
}

static enum status page_write(const char *folder, char *path, struct error *error) {
    struct page page;
    snprintf(path, PATH_MAX, "%s/figures.html", folder);
    enum status status = page_init(&page, "Neural complex luminaires: the figures", error);
    if (status) return status;
    int shown = 0;
    for (int i = 0; i < FIGURES && !status; i++) {
        json_t *kept = sheet_load(folder, TABLE[i]->name, NULL);
        if (kept) status = sheet_show(kept, folder, &page, error);
        shown += kept != NULL;
        json_decref(kept);
    }
    if (!shown) page_paragraph(&page, "Nothing is finished yet.");
    if (!status) status = page_save(&page, path, error);
    page_fini(&page);
    return status;
}

static enum status figure_make(struct figure_kit *kit, const struct figure *figure, const char *key,
                               struct error *error) {
    struct sheet sheet;
    enum status status = sheet_init(&sheet, kit->folder, figure->name, error);
    if (status) return status;
    kit->progress->cost = figure->cost;
    kit->progress->step = kit->progress->steps = 0;
    status = figure->make(kit, figure, &sheet, error);
    if (!status) status = sheet_save(&sheet, figure->title, figure->caption, key, error);
    sheet_fini(&sheet);
    kit->progress->done += figure->cost;
    return status;
}

static char *result_json(const struct figures_options *options, const char *page) {
    json_t *list = json_array();
    for (int i = 0; i < FIGURES; i++) {
        json_t *kept = wanted(options, TABLE[i]) ? sheet_load(options->folder, TABLE[i]->name, NULL) : NULL;
        if (kept) json_array_append_new(list, kept);
    }
    json_t *root = json_pack("{s:s, s:o}", "page", page, "figures", list);
    char *text = root ? json_dumps(root, 0) : NULL;
    json_decref(root);
    return text;
}

enum status figures_make(const struct figures_options *options, const struct run *run, char **json,
                         struct error *error) {
    struct figure_progress state = {.outer = run, .start_s = clock_wall_s()};
    struct figure_kit kit = {.run = {.threads = run->threads,
                                     .seed = run->seed,
                                     .message = message,
                                     .progress = progress,
                                     .cancelled = cancelled,
                                     .user = &state},
                             .scale = options->scale,
                             .folder = options->folder,
                             .paper = options->paper,
                             .progress = &state};
    char page[PATH_MAX], kept_folder[PATH_MAX], key[200];
    *json = NULL;
    enum status status = check_names(options, error);
    if (!status) status = evidence_data_find(&kit.data, options->data, error);
    if (!status) status = folder_make(options->folder, error);
    snprintf(kept_folder, sizeof kept_folder, "%s/kept", options->folder);
    if (!status) status = folder_make(kept_folder, error);
    if (!status) status = key_make(key, sizeof key, &kit, error);
    bool todo[FIGURES] = {false};
    int finished = 0, all = 0;
    for (int i = 0; i < FIGURES && !status; i++) {
        if (!wanted(options, TABLE[i])) continue;
        json_t *kept = sheet_load(options->folder, TABLE[i]->name, key);
        todo[i] = kept == NULL;
        state.all += todo[i] ? TABLE[i]->cost : 0;
        finished += kept != NULL;
        all++;
        json_decref(kept);
    }
    for (int i = 0; i < FIGURES && !status; i++) {
        if (!todo[i]) continue;
        status = figure_make(&kit, TABLE[i], key, error);
        if (!status) status = page_write(options->folder, page, error);
        finished += !status;
    }
    if (!status || status == STATUS_CANCELLED) {
        enum status written = page_write(options->folder, page, status ? NULL : error);
        if (!status) status = written;
    }
    if (status == STATUS_CANCELLED)
        return error_set(error, status,
                         "stopped with %d of %d figures, which are in %s; the same command goes on from here", finished,
                         all, page);
    if (!status && !(*json = result_json(options, page))) status = error_set(error, STATUS_MEMORY, "out of memory");
    return status;
}
