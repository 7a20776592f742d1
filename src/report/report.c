// The report, from EXR files and the JSON that the verbs printed to one HTML page with the pictures inside it.
#include "report/report.h"

#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "report/compare.h"
#include "report/page.h"
#include "report/picture.h"

static json_t *json_open(const char *path) {
    return path ? json_load_file(path, 0, NULL) : NULL; // figures that are not there are left out of the page
}

static double json_figure(const json_t *json, const char *key) {
    const json_t *value = json_object_get(json, key);
    return json_is_number(value) ? json_number_value(value) : NAN;
}

static void entry_row(struct page *page, const struct report_entry *entry, const struct comparison *comparison) {
    json_t *json = json_open(entry->json_path);
    page_table_row(page, entry->name);
    page_cell_number(page, "%.1f", json_figure(json, "cpu_s"));
    page_cell_number(page, "%.0f", json_figure(json, "samples"));
    page_cell_number(page, "%.5f", comparison ? comparison->metrics.rel_mse : (double)NAN);
    page_cell_number(page, "%.5f", comparison ? comparison->rel_mse_corrected : (double)NAN);
    page_cell_number(page, "%.3f", comparison ? comparison->metrics.flip : (double)NAN);
    page_cell_number(page, "%.2f %%", comparison ? 100 * comparison->metrics.block_error_max : (double)NAN);
    json_decref(json);
}

static void bake_table(struct page *page, const char *path) {
    json_t *json = json_open(path);
    if (!json) return;
    page_heading(page, "The baked lamp");
    page_table_begin(page, (const char *[]){NULL});
    const char *key;
    json_t *value;
    json_object_foreach(json, key, value) {
        char *text = json_dumps(value, JSON_ENCODE_ANY | JSON_REAL_PRECISION(4) | JSON_COMPACT);
        if (!text) continue;
        page_table_row(page, key);
        page_cell(page, text);
        free(text);
    }
    page_table_end(page);
    json_decref(json);
}

struct report_images { // what all entries are held against
    struct image reference, mask;
    bool has_mask;
    float exposure;
};

static enum status entry_pictures(struct page *page, const struct report_images *images,
                                  const struct report_entry *entry, struct comparison *comparison,
                                  struct image *difference, struct error *error) {
    struct image image = {0};
    char note[80];
    enum status status = image_load(&image, entry->image_path, false, error);
    if (!status)
        status = compare_images(&image, &images->reference, images->has_mask ? &images->mask : NULL, comparison, error);
    if (!status) status = image_difference(difference, &image, &images->reference, error);
    if (!status) {
        snprintf(note, sizeof note, "relMSE %.5f, FLIP %.3f", comparison->metrics.rel_mse, comparison->metrics.flip);
        status = page_picture(page, &image, images->exposure, entry->name, note, error);
    }
    image_fini(&image);
    return status;
}

static enum status report_entries(struct page *page, const struct report_images *images,
                                  const struct report_options *options, struct comparison *comparisons,
                                  struct image *differences, struct error *error) {
    const char *heads[] = {"",
                           "CPU seconds",
                           "samples per pixel",
                           "relMSE",
                           "relMSE less the reference's noise",
                           "FLIP",
                           "worst of 16 blocks",
                           NULL};
    page_row_begin(page);
    enum status status =
        page_picture(page, &images->reference, images->exposure, options->reference.name, "reference", error);
    for (size_t i = 0; !status && i < options->entry_count; i++)
        status = entry_pictures(page, images, &options->entries[i], &comparisons[i], &differences[i], error);
    page_row_end(page);
    page_heading(page, "Differences from the reference, 16 times brighter");
    page_row_begin(page);
    for (size_t i = 0; !status && i < options->entry_count; i++)
        status = page_picture(page, &differences[i], DIFFERENCE_GAIN * images->exposure, options->entries[i].name, "",
                              error);
    page_row_end(page);
    page_heading(page, "Figures");
    page_table_begin(page, heads);
    for (size_t i = 0; !status && i < options->entry_count; i++) entry_row(page, &options->entries[i], &comparisons[i]);
    entry_row(page, &options->reference, NULL);
    page_table_end(page);
    page_small_print(page, images->has_mask ? "relMSE: mean of (a - r)² / (r² + 0.001), over the pixels that do not "
                                              "look at the lamp. FLIP: Andersson et al. 2020."
                                            : "relMSE: mean of (a - r)² / (r² + 0.001). FLIP: Andersson et al. 2020.");
    return status;
}

enum status report_write(const struct report_options *options, struct error *error) {
    struct report_images images = {.has_mask = options->mask_path != NULL};
    struct page page = {0};
    struct comparison *comparisons = calloc(options->entry_count + 1, sizeof *comparisons);
    struct image *differences = calloc(options->entry_count + 1, sizeof *differences);
    enum status status = STATUS_OK;
    if (!comparisons || !differences) status = error_set(error, STATUS_MEMORY, "out of memory for the report");
    if (!status) status = image_load(&images.reference, options->reference.image_path, false, error);
    if (!status && images.has_mask) status = image_load(&images.mask, options->mask_path, true, error);
    if (!status) status = page_init(&page, options->title, error);
    if (!status) {
        images.exposure = image_auto_exposure(&images.reference);
        status = report_entries(&page, &images, options, comparisons, differences, error);
    }
    if (!status) {
        bake_table(&page, options->bake_json_path);
        status = page_save(&page, options->output, error);
    }
    for (size_t i = 0; differences && i < options->entry_count; i++) image_fini(&differences[i]);
    free(differences);
    free(comparisons);
    page_fini(&page);
    image_fini(&images.reference);
    image_fini(&images.mask);
    return status;
}
