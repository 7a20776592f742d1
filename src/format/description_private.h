// What the files of the scene reader share: description.c (lifecycle, look-up), description_parse.c (elements to
// objects), description_value.c (attribute texts to values), description_resolve.c (references).
#pragma once

#include "format/description.h"

enum { DESCRIPTION_MAX_DEPTH = 64 }; // of elements, references and includes within each other

// Attribute texts to values. `what` names the value in messages.
enum status parse_integer(const char *text, struct place place, const char *what, double *number, struct error *error);
enum status parse_number(const char *text, struct place place, const char *what, double *number, struct error *error);
enum status parse_boolean(const char *text, struct place place, const char *what, bool *value, struct error *error);
// Numbers separated by commas or white space, into `numbers`; *count is at most `capacity`, more is an error.
enum status parse_numbers(const char *text, struct place place, const char *what, double *numbers, size_t capacity,
                          size_t *count, struct error *error);
enum status parse_color(const char *text, struct place place, bool is_srgb, rgb *color, struct error *error);
// One number, "wavelength:value" pairs, or the lines of an .spd file.
enum status parse_spectrum(struct arena *arena, const char *text, struct property *property, struct error *error);
enum status load_spd(struct arena *arena, const char *path, struct property *property, struct error *error);

// One operation of a <transform>: `attributes` as expat gives them, `matrix` becomes operation * matrix.
enum status transform_apply_element(const char *tag, const char *const *attributes, struct place place,
                                    struct transform *matrix, struct error *error);
const char *attribute_value(const char *const *attributes, const char *name); // either spelling; NULL where absent

// A <ref> or an id, in the order of the files.
struct reference {
    struct reference *next;
    const char *id;
    struct place place;
    struct object_child *child; // of the referring object
};
struct identifier {
    struct identifier *next;
    const char *id, *alias_of; // alias_of: NULL for an object's own id
    struct place place;
    struct object *object;
};

// Points every reference at its object; refuses unknown ids and cycles.
enum status references_resolve(struct object *root, struct reference *references, struct identifier *identifiers,
                               struct error *error);
