// Sheets, to JSON and from there to a page: a page made after a break shows exactly what was kept.
#include "evidence/sheet.h"

#include <limits.h>
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>

#include "base/file.h"
#include "evidence/kept.h"
#include "report/picture.h"

enum { SMALL = 200 }; // pixels below which a picture is enlarged

enum status sheet_init(struct sheet *sheet, const char *folder, const char *name, struct error *error) {
    *sheet = (struct sheet){.content = json_array(), .folder = folder, .name = name};
    return sheet->content ? STATUS_OK : error_set(error, STATUS_MEMORY, "out of memory for figure %s", name);
}

void sheet_fini(struct sheet *sheet) { json_decref(sheet->content); }

static json_t *begin(struct sheet *sheet, const char *kind) {
    json_t *piece = json_object(), *list = json_array();
    json_object_set_new(piece, kind, list);
    json_array_append_new(sheet->content, piece);
    return sheet->piece = list;
}

void sheet_row(struct sheet *sheet) { begin(sheet, "pictures"); }

enum status sheet_picture(struct sheet *sheet, const struct image *image, float exposure, const char *name,
                          const char *note, struct error *error) {
    char file[64], path[PATH_MAX];
    struct image large = {0};
    const int longer = image->width > image->height ? image->width : image->height;
    enum status status = STATUS_OK;
    if (longer < SMALL)
        status = image_crop(&large, image, 0, 0, image->width, image->height, (SMALL + longer - 1) / longer, error);
    snprintf(file, sizeof file, "figure_%s_%02d.png", sheet->name, ++sheet->picture_count);
    snprintf(path, sizeof path, "%s/%s", sheet->folder, file);
    if (!status) status = image_save(longer < SMALL ? &large : image, path, exposure, error);
    image_fini(&large);
    if (!status)
        json_array_append_new(sheet->piece, json_pack("{s:s, s:s, s:s}", "file", file, "name", name, "note", note));
    return status;
}

void sheet_text(struct sheet *sheet, const char *format, ...) {
    char text[2000];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    json_array_append_new(sheet->content, json_pack("{s:s}", "text", text));
}

void sheet_table(struct sheet *sheet, const struct sheet_column *columns) {
    sheet->columns = columns;
    json_t *rows = begin(sheet, "rows"), *list = json_array();
    for (const struct sheet_column *column = columns; column->key; column++)
        json_array_append_new(
            list, json_pack("{s:s, s:s, s:i}", "key", column->key, "head", column->head, "digits", column->digits));
    json_object_set_new(json_array_get(sheet->content, json_array_size(sheet->content) - 1), "columns", list);
    sheet->piece = rows;
}

void sheet_line(struct sheet *sheet, const char *name, const double *values) {
    json_t *row = json_pack("{s:s}", "name", name);
    for (size_t i = 0; sheet->columns[i].key; i++)
        json_object_set_new(row, sheet->columns[i].key, isfinite(values[i]) ? json_real(values[i]) : json_null());
    json_array_append_new(sheet->piece, row);
}

static void sheet_path(char *path, const char *folder, const char *name) {
    snprintf(path, PATH_MAX, "%s/figure_%s.json", folder, name);
}

enum status sheet_save(const struct sheet *sheet, const char *title, const char *caption, const char *key,
                       struct error *error) {
    char path[PATH_MAX];
    sheet_path(path, sheet->folder, sheet->name);
    return kept_save(path,
                     json_pack("{s:s, s:s, s:s, s:s, s:O}", "figure", sheet->name, "title", title, "caption", caption,
                               "key", key, "content", sheet->content),
                     error);
}

json_t *sheet_load(const char *folder, const char *name, const char *key) {
    char path[PATH_MAX];
    sheet_path(path, folder, name);
    return kept_load(path, key);
}

static const char *text_of(const json_t *object, const char *key) {
    const char *text = json_string_value(json_object_get(object, key));
    return text ? text : "";
}

static enum status show_row(const json_t *pictures, const char *folder, struct page *page, struct error *error) {
    size_t i;
    json_t *picture;
    page_row_begin(page);
    json_array_foreach(pictures, i, picture) {
        char path[PATH_MAX];
        uint8_t *png;
        size_t length;
        snprintf(path, sizeof path, "%s/%s", folder, text_of(picture, "file"));
        enum status status = file_read(path, &png, &length, error);
        if (status) return status;
        page_picture_png(page, png, length, text_of(picture, "name"), text_of(picture, "note"));
        free(png);
    }
    page_row_end(page);
    return STATUS_OK;
}

static void show_table(const json_t *columns, const json_t *rows, struct page *page) {
    const char *heads[SHEET_COLUMNS + 2] = {""};
    size_t i, k;
    json_t *column, *row;
    json_array_foreach(columns, k, column) if (k < SHEET_COLUMNS) heads[k + 1] = text_of(column, "head");
    page_table_begin(page, heads);
    json_array_foreach(rows, i, row) {
        page_table_row(page, text_of(row, "name"));
        json_array_foreach(columns, k, column) {
            char cell[64] = "-";
            const json_t *value = json_object_get(row, text_of(column, "key"));
            int digits = (int)json_integer_value(json_object_get(column, "digits"));
            if (json_is_number(value)) snprintf(cell, sizeof cell, "%.*f", digits, json_number_value(value));
            page_cell(page, cell);
        }
    }
    page_table_end(page);
}

enum status sheet_show(const json_t *sheet, const char *folder, struct page *page, struct error *error) {

    page_heading(page, text_of(sheet, "title"));
    page_paragraph(page, text_of(sheet, "caption"));
    size_t i;
    json_t *piece;
    enum status status = STATUS_OK;
    json_array_foreach(json_object_get(sheet, "content"), i, piece) {
        const json_t *pictures = json_object_get(piece, "pictures"), *rows = json_object_get(piece, "rows");
        if (pictures && !status) status = show_row(pictures, folder, page, error);
        if (rows) show_table(json_object_get(piece, "columns"), rows, page);
        if (!pictures && !rows) page_small_print(page, text_of(piece, "text"));
    }
    return status;
}
