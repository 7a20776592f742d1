// What a figure consists of: rows of pictures, tables and text. The pictures are PNG files beside the sheet's JSON,
// which holds everything else; a page is made of sheets.
#pragma once

#include <jansson.h>
#include <stddef.h>

#include "image/image.h"
#include "report/page.h"

struct sheet {
    json_t *content; // pieces in order
    json_t *piece; // the row or table that is being filled; borrowed
    const struct sheet_column *columns; // of the table
    const char *folder, *name;
    int picture_count;
};

struct sheet_column {
    const char *key, *head; // in the JSON, on the page
    int digits; // after the point, on the page
};
enum { SHEET_COLUMNS = 12 };

enum status sheet_init(struct sheet *sheet, const char *folder, const char *name, struct error *error);
void sheet_fini(struct sheet *sheet);

void sheet_row(struct sheet *sheet); // the pictures that follow stand side by side
// A PNG after scaling by `exposure`. Small pictures are written larger, each pixel as a square.
enum status sheet_picture(struct sheet *sheet, const struct image *image, float exposure, const char *name,
                          const char *note, struct error *error);
void sheet_text(struct sheet *sheet, const char *format, ...) __attribute__((format(printf, 2, 3)));
// `columns` ends with a NULL key and stays the caller's.
void sheet_table(struct sheet *sheet, const struct sheet_column *columns);
void sheet_line(struct sheet *sheet, const char *name, const double *values); // one a column; NAN: none

// FOLDER/figure_NAME.json: title, caption, key and content. `key` says from what it was made.
enum status sheet_save(const struct sheet *sheet, const char *title, const char *caption, const char *key,
                       struct error *error);
// The kept sheet, or NULL where there is none, or one of another key (NULL: of any).
json_t *sheet_load(const char *folder, const char *name, const char *key);
enum status sheet_show(const json_t *sheet, const char *folder, struct page *page, struct error *error);
