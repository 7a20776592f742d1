// The scene description as a tree of plain structs: its lifecycle, look-up and error texts. See description_parse.c.
#include "format/description_private.h"

#include <ctype.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "base/param.h"

void description_fini(struct description *description) {
    arena_fini(&description->arena);
    *description = (struct description){0};
}

struct property *object_property(const struct object *object, const char *name) {
    for (size_t i = 0; i < object->property_count; i++)
        if (param_name_equal(object->properties[i].name, name)) return &object->properties[i];
    return NULL;
}

enum status error_at(struct error *error, struct place place, const char *format, ...) {
    char text[sizeof error->text];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    const char *file = place.file ? place.file : "?";
    if (place.line <= 0) return error_set(error, STATUS_INVALID, "%s: %s", file, text);
    return error_set(error, STATUS_INVALID, "%s:%d:%d: %s", file, place.line, place.column, text);
}

enum { NAME_MAX_LENGTH = 48 };

static size_t name_fold(const char *name, char folded[NAME_MAX_LENGTH]) {
    size_t length = 0;
    for (; *name && length < NAME_MAX_LENGTH; name++)
        if (*name != '_') folded[length++] = (char)tolower((unsigned char)*name);
    return length;
}

// Optimal string alignment: insertions, deletions, substitutions and swaps of neighbours (Damerau 1964).
static int edit_distance(const char *a, size_t n, const char *b, size_t m) {
    int rows[3][NAME_MAX_LENGTH + 1];
    for (size_t j = 0; j <= m; j++) rows[0][j] = (int)j;
    for (size_t i = 1; i <= n; i++) {
        int *row = rows[i % 3], *before = rows[(i + 2) % 3], *before2 = rows[(i + 1) % 3];
        row[0] = (int)i;
        for (size_t j = 1; j <= m; j++) {
            int best = before[j - 1] + (a[i - 1] != b[j - 1]);
            if (before[j] + 1 < best) best = before[j] + 1;
            if (row[j - 1] + 1 < best) best = row[j - 1] + 1;
            if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] && before2[j - 2] + 1 < best)
                best = before2[j - 2] + 1;
            row[j] = best;
        }
    }
    return rows[n % 3][m];
}

const char *nearest_name(const char *name, const char *const *names, size_t n) {
    char folded[NAME_MAX_LENGTH], candidate[NAME_MAX_LENGTH];
    size_t length = name_fold(name, folded);
    const char *nearest = NULL;
    int nearest_distance = (int)(length / 3 > 1 ? length / 3 : 1) + 1;
    for (size_t i = 0; i < n; i++) {
        size_t candidate_length = name_fold(names[i], candidate);
        int distance = edit_distance(folded, length, candidate, candidate_length);
        if (distance < nearest_distance && (size_t)distance < length) {
            nearest = names[i];
            nearest_distance = distance;
        }
    }
    return nearest;
}
