// One HTML page that needs no other file: headings, text, pictures and tables, readable in light and dark and on small
// screens. Everything that is text is escaped here. Pieces are added in order; a piece that cannot be added for lack of
// memory makes page_save fail.
#pragma once

#include <stddef.h>
#include <stdio.h>

#include "image/image.h"

struct page {
    FILE *file; // into bytes
    char *bytes;
    size_t length;
};

enum status page_init(struct page *page, const char *title, struct error *error);
void page_fini(struct page *page);
// Ends the page and writes it, whole or not at all. Nothing may be added after it.
enum status page_save(struct page *page, const char *path, struct error *error);

void page_heading(struct page *page, const char *text);
void page_paragraph(struct page *page, const char *text);
void page_small_print(struct page *page, const char *text);

// Pictures stand side by side in a row, as many as the screen's width allows.
void page_row_begin(struct page *page);
void page_row_end(struct page *page);
// 8-bit sRGB after scaling by `exposure`. The name is set bold before the note.
enum status page_picture(struct page *page, const struct image *image, float exposure, const char *name,
                         const char *note, struct error *error);
void page_picture_png(struct page *page, const void *png, size_t length, const char *name, const char *note);

// A table: the first column is set to the left, the others to the right. `heads` ends with NULL.
void page_table_begin(struct page *page, const char *const *heads);
void page_table_end(struct page *page);
void page_table_row(struct page *page, const char *name); // begins a row with its first cell
void page_cell(struct page *page, const char *text);
void page_cell_number(struct page *page, const char *format, double value); // "-" for NAN
