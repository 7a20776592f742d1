// The page: the table, and for every row the pictures side by side, their differences from the reference, and the
// places where each errs most, magnified. All is read back from the row's files.
#include <math.h>
#include <stdio.h>

#include "evidence/table1_output.h"
#include "image/metric.h"
#include "report/page.h"
#include "report/picture.h"

enum { PICTURES = 3, CROP_SHARE = 6, CROP_ZOOM = 4 }; // a crop's side is a sixth of the height

struct row_pictures {
    struct image image[PICTURES]; // the reference (a mean of two), bdpt, ours
    struct image half[2], mask; // of the reference
    float exposure;
};

static void pictures_fini(struct row_pictures *pictures) {
    for (int i = 0; i < PICTURES; i++) image_fini(&pictures->image[i]);
    for (int i = 0; i < 2; i++) image_fini(&pictures->half[i]);
    image_fini(&pictures->mask);
}

static enum status picture_load(struct image *image, const struct table1_kit *kit, const struct table1_entry *entry,
                                const char *name, struct error *error) {
    char path[PATH_MAX];
    table1_path(path, kit, entry, name);
    return image_load(image, path, true, error);
}

static enum status pictures_load(struct row_pictures *pictures, const struct table1_kit *kit,
                                 const struct table1_row *row, struct error *error) {
    const struct table1_entry *entry = row->entry;
    char name[TABLE1_NAME], file[TABLE1_NAME + 8];
    table1_equal_name(name, row->ours_spp);
    snprintf(file, sizeof file, "%s.exr", name);
    enum status status = picture_load(&pictures->half[0], kit, entry, "reference_1.exr", error);
    if (!status) status = picture_load(&pictures->half[1], kit, entry, "reference_2.exr", error);
    if (!status) status = image_mean(&pictures->image[0], &pictures->half[0], &pictures->half[1], error);
    if (!status) status = picture_load(&pictures->image[1], kit, entry, "bdpt.exr", error);
    if (!status) status = picture_load(&pictures->image[2], kit, entry, file, error);
    if (!status) status = picture_load(&pictures->mask, kit, entry, "mask.exr", error);
    if (!status) pictures->exposure = image_auto_exposure(&pictures->image[0]);
    return status;
}

struct crop {
    int x, y, side;
};

// The tile outside the lamp with the largest relative squared error.
static struct crop worst_tile(const struct row_pictures *pictures, const struct image *image) {
    const struct image *reference = &pictures->image[0];
    struct crop worst = {.side = reference->height / CROP_SHARE > 4 ? reference->height / CROP_SHARE : 4};
    double most = -1;
    for (int y = 0; y + worst.side <= reference->height; y += worst.side)
        for (int x = 0; x + worst.side <= reference->width; x += worst.side) {
            double sum = 0;
            for (int i = 0; i < worst.side * worst.side; i++) {
                const size_t at =
                    (size_t)(y + i / worst.side) * (size_t)reference->width + (size_t)(x + i % worst.side);
                if (!(pictures->mask.pixels[at * (size_t)pictures->mask.channels] > 0.5f)) continue;
                sum += pixel_relative_error(&image->pixels[at * (size_t)image->channels],
                                            &reference->pixels[at * (size_t)reference->channels]);
            }
            if (sum > most) most = sum, worst.x = x, worst.y = y;
        }
    return worst;
}

static const char *const NAMES[PICTURES] = {"reference", "bdpt", "ours"};

static enum status add_crops(struct page *page, const struct row_pictures *pictures, int of, struct error *error) {
    const struct crop crop = worst_tile(pictures, &pictures->image[of]);
    char note[80];
    snprintf(note, sizeof note, "where %s errs most", NAMES[of]);
    enum status status = STATUS_OK;
    page_row_begin(page);
    for (int i = 0; !status && i < PICTURES; i++) {
        struct image part = {0};
        status = image_crop(&part, &pictures->image[i], crop.x, crop.y, crop.side, crop.side, CROP_ZOOM, error);
        if (!status) status = page_picture(page, &part, pictures->exposure, NAMES[i], note, error);
        image_fini(&part);
    }
    page_row_end(page);
    return status;
}

static enum status add_pictures(struct page *page, const struct table1_row *row, const struct row_pictures *pictures,
                                struct error *error) {
    char notes[PICTURES][160];
    snprintf(notes[0], sizeof notes[0], "bdpt of the geometry, %.0f samples, %.4g CPU s", row->reference_spp,
             row->reference_cpu_s);
    snprintf(notes[1], sizeof notes[1], "%.0f samples, %.4g CPU s, relMSE %.3g, FLIP %.3f", row->bdpt_spp,
             row->bdpt_cpu_s, row->bdpt_relmse, row->bdpt_flip);
    snprintf(notes[2], sizeof notes[2], "%.0f samples, %.4g CPU s, relMSE %.3g, FLIP %.3f", row->ours_spp,
             row->ours_cpu_s, row->ours_relmse, row->ours_flip);
    enum status status = STATUS_OK;
    page_row_begin(page);
    for (int i = 0; !status && i < PICTURES; i++)
        status = page_picture(page, &pictures->image[i], pictures->exposure, NAMES[i], notes[i], error);
    page_row_end(page);
    page_row_begin(page);
    for (int i = 1; !status && i < PICTURES; i++) {
        struct image difference = {0};
        status = image_difference(&difference, &pictures->image[i], &pictures->image[0], error);
        if (!status)
            status = page_picture(page, &difference, DIFFERENCE_GAIN * pictures->exposure, NAMES[i],
                                  "difference from the reference, 16 times brighter", error);
        image_fini(&difference);
    }
    page_row_end(page);
    for (int of = 1; !status && of < PICTURES; of++) status = add_crops(page, pictures, of, error);
    return status;
}

static enum status add_row(struct page *page, const struct table1_kit *kit, const struct table1_row *row,
                           struct error *error) {
    char text[TABLE1_LIMITS];
    struct row_pictures pictures = {0};
    snprintf(text, sizeof text, "%s, %s", row->entry->luminaire, row->entry->scene);
    page_heading(page, text);
    table1_limits(row, text, sizeof text);
    page_paragraph(page, text);
    enum status status = pictures_load(&pictures, kit, row, error);
    if (!status) status = add_pictures(page, row, &pictures, error);
    pictures_fini(&pictures);
    return status;
}

static void add_table(struct page *page, const struct table1_row *rows, int count) {
    const char *heads[TABLE1_ROWS + 2] = {""};
    for (int i = 0; i < count; i++) heads[i + 1] = rows[i].entry->luminaire;
    page_table_begin(page, heads);
    for (const struct table1_column *column = table1_columns; column->key; column++) {
        if (!column->label) continue;
        page_table_row(page, column->label);
        for (int i = 0; i < count; i++) {
            char cell[64];
            table1_cell(cell, sizeof cell, column, &rows[i]);
            page_cell(page, cell);
        }
    }
    page_table_end(page);
}

enum status table1_page(const struct table1_kit *kit, const struct table1_row *rows, int count, struct error *error) {
    char text[400], path[PATH_MAX];
    struct page page = {0};
    enum status status = page_init(&page, "Table 1 of Neural Complex Luminaires, measured anew", error);
    if (status) return status;
    snprintf(
        text, sizeof text,
        "Bidirectional path tracing of the lamp's geometry against path tracing with the baked lamp, on the CPU, at "
        "scale %g (1: 400 pixels high and 1024 samples a pixel); two references by bdpt with %g times the samples "
        "each.",
        kit->scale, kit->reference);
    page_paragraph(&page, text);
    add_table(&page, rows, count);
    page_small_print(
        &page, "relMSE: mean of (x - r)² / (r² + 0.001) over the pixels that do not look at the lamp, less the "
               "noise of the reference. Bias: what remains of it without noise, from two independent renderings "
               "of ours and two of the reference. FLIP (Andersson et al. 2020) includes the reference's noise. "
               "The speed-up compares CPU seconds at equal relMSE; where ours cannot reach bdpt's, it is given at "
               "the error where our noise is as large as our bias.");
    for (int i = 0; !status && i < count; i++) status = add_row(&page, kit, &rows[i], error);
    snprintf(path, sizeof path, "%s/table1.html", kit->folder);
    if (!status) status = page_save(&page, path, error);
    page_fini(&page);
    return status;
}
