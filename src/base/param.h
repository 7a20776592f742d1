// Declared parameters: one table per plugin drives parsing, defaults, range and unknown-name errors, `sconce help`
// and the statistical tests. Nothing else lists a parameter.
#pragma once

#include <stddef.h>

enum param_type {
    PARAM_BOOL, // field: bool
    PARAM_INT, // field: int
    PARAM_FLOAT, // field: float
    PARAM_STRING, // field: const char * (owned by the scene)
    PARAM_CHOICE, // field: int, index into `choices`
    PARAM_RGB, // field: rgb; <rgb>, <spectrum>, <blackbody>, <float>
    PARAM_VEC3, // field: vec3; <point>, <vector>
    PARAM_TRANSFORM, // field: struct transform
    PARAM_TEXTURE, // field: const struct texture *; a <texture> or anything PARAM_RGB takes (a constant texture)
};

// Names are written in snake_case as in Mitsuba 3; the camelCase spelling of Mitsuba 0.5 is accepted too (names are
// compared without case and underscores).
struct param {
    const char *name;
    enum param_type type;
    size_t offset; // offsetof the field in the plugin's own struct
    const char *fallback; // the default, written as in a scene file ("0.5", "1 1 1", "true", "bk7"); NULL: required;
                          // "" : optional, the field stays zero/NULL
    double min, max; // inclusive range of numbers and colour components; min == max: unchecked
    const char *unit; // "sr^-1", "degrees", "1" ... or NULL
    const char *help; // one line
    const char *choices; // PARAM_CHOICE: "ggx|beckmann"; PARAM_STRING: suggestions or NULL
    const char *alias; // another accepted name, or NULL
};
#define PARAM_END                                                                                                      \
    { 0 }

// True where the two names are the same parameter, ignoring case and underscores.
int param_name_equal(const char *a, const char *b);
