// What the files of the scene reader share: description.c (lifecycle, look-up), description_parse.c (elements to
// objects), description_names.c ($names in attributes), description_property.c (elements to properties),
// description_spectrum.c (those with parameters inside), description_value.c and description_transform.c (attribute
// texts to values), description_resolve.c (references).
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
// From n pairs in arrays of the arena.
enum status spectrum_finish(struct property *property, float *wavelengths, float *values, size_t n,
                            struct error *error);
enum status load_spd(struct arena *arena, const char *path, struct property *property, struct error *error);

// One operation of a <transform>: `attributes` as expat gives them, `matrix` becomes operation * matrix.
enum status transform_apply_element(const char *tag, const char *const *attributes, struct place place,
                                    struct transform *matrix, struct error *error);
const char *attribute_value(const char *const *attributes, const char *name); // either spelling; NULL where absent

// What the elements of a file have in common while they are read.
struct named_value { // a <default> or a -D definition
    struct named_value *next;
    const char *name, *value;
    bool *used; // set when a $name uses it; NULL: nobody asks
};
struct named_value *named_value_find(struct named_value *values, const char *name, size_t length);
enum { ATTRIBUTES_CAPACITY = 33 }; // names and values of 16, and the end
// A copy of expat's attributes of <tag> at `place` with $names replaced; an error where one is not in `known`.
enum status attributes_take(struct arena *arena, struct named_value *values, const char *tag, struct place place,
                            const char *const *raw, const char *const *known, size_t known_count,
                            const char **attributes, struct error *error);

// Elements that become a property, and the attributes they may have besides `name`. Ends with tag == NULL.
struct property_tag {
    const char *tag;
    enum property_type type;
    const char *attributes[5];
};
extern const struct property_tag property_tags[];
// Fills a property, whose name and place are set, from its attributes; transforms become the identity.
enum status property_set(struct arena *arena, const struct property_tag *tag, const char *const *attributes,
                         struct property *property, struct error *error);

// <spectrum type="..."> with its parameters inside (description_spectrum.c): fills the property.
enum status property_set_spectrum(struct arena *arena, struct object *object, struct property *property,
                                  struct error *error);

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
