// A scene file as plain structs: a tree of objects with properties, after defaults ($name), includes and references
// are resolved. Reads Mitsuba XML in both spellings (0.5/0.6 camelCase and 2.x/3.x snake_case).
// Knows nothing of what the objects mean: that is the tables' business (src/scene).
#pragma once

#include "base/arena.h"
#include "base/error.h"
#include "base/run.h"
#include "math/transform.h"

struct place { // where something stands in the files; line and column count from 1
    const char *file;
    int line, column;
};

enum property_type {
    PROPERTY_BOOL,
    PROPERTY_INT,
    PROPERTY_FLOAT,
    PROPERTY_STRING,
    PROPERTY_VEC3, // <point>, <vector>
    PROPERTY_RGB, // <rgb>, <srgb> (hex accepted, converted to linear)
    PROPERTY_SPECTRUM, // <spectrum>: one value, or wavelength:value pairs; three values are an RGB
    PROPERTY_BLACKBODY, // <blackbody temperature scale>
    PROPERTY_TRANSFORM,
};

struct property {
    const char *name;
    enum property_type type;
    struct place place;
    bool used; // set by whoever reads it; what is still false afterwards was misspelt
    bool boolean;
    double number; // INT, FLOAT, one-value SPECTRUM, BLACKBODY temperature [K]
    const char *string; // also the raw text of every other type
    vec3 vector; // VEC3
    rgb color; // RGB; SPECTRUM converted for a reflectance (see spectrum.h); BLACKBODY as an emission, times its scale
    struct transform transform;
    const float *wavelengths_nm, *values; // SPECTRUM with pairs
    size_t pair_count;
};

struct object_child {
    const char *name; // the slot: the name attribute of the child or of its <ref>, or ""
    struct object *object;
    struct place place; // of the child or of the <ref>
};

struct object {
    const char *tag; // "scene", "shape", "bsdf", "texture", "emitter", "sensor", "film", "sampler", "rfilter",
                     // "medium", "integrator"
    const char *type; // the type attribute, "" where there is none
    const char *id; // or ""
    struct place place;
    struct property *properties;
    size_t property_count;
    struct object_child *children;
    size_t child_count;
    bool used;
    void *instance; // what the scene made of it: a shared <ref> becomes one instance
};

struct definition {
    const char *name, *value;
}; // -D name=value

struct description {
    struct object *root;
    struct arena arena;
    const bool *definition_used; // of each definition given: is it used in the file?
};

// Parses a file. Errors carry file:line:column: malformed XML, unknown tag, $name without a value (lists the near
// names), duplicate id, reference to nothing or to itself, cyclic include, a file that cannot be read.
// *description is valid only on STATUS_OK; description_fini frees it.
enum status description_load(struct description *description, const char *path, const struct definition *definitions,
                             size_t definition_count, const struct run *run, struct error *error);
// The same from memory; `path` names it in messages and is the folder of includes. For the fuzzer.
enum status description_parse(struct description *description, const char *path, const char *text, size_t length,
                              const struct definition *definitions, size_t definition_count, const struct run *run,
                              struct error *error);
void description_fini(struct description *description);

struct property *object_property(const struct object *object, const char *name); // either spelling; NULL where absent

// error_set with "file:line:column: " before the text.
enum status error_at(struct error *error, struct place place, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
// The nearest of n names by edit distance (either spelling), or NULL where none is near.
const char *nearest_name(const char *name, const char *const *names, size_t n);
