// The rows as text: one list of columns makes the JSON, the Markdown and the page's table.
#pragma once

#include <jansson.h>

#include "evidence/table1_row.h"

enum { TABLE1_LIMITS = 700 }; // bytes for table1_limits

struct table1_column {
    const char *key; // in the JSON; NULL ends the list
    size_t offset; // of `count` doubles in struct table1_row
    int count;
    const char *label; // NULL: in the JSON only
    const char *format;
    double factor; // from the row's unit to the label's
};
extern const struct table1_column table1_columns[];

// The figure as the label says; of several the one that is farthest from 0; "-" for NAN.
void table1_cell(char *text, size_t size, const struct table1_column *column, const struct table1_row *row);

// The whole result, or NULL without memory. Figures that do not exist are null.
json_t *table1_json(const struct table1_kit *kit, const struct table1_row *rows, int count);
// Markdown: a column for each row, so that it fits a terminal; then what limits each. malloc'ed, or NULL.
char *table1_markdown(const struct table1_row *rows, int count);
// FOLDER/table1.html.
enum status table1_page(const struct table1_kit *kit, const struct table1_row *rows, int count, struct error *error);
