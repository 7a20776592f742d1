// The tensors of a hull and its view field, for luminaire_file.c.
#pragma once

#include "format/safetensors.h"
#include "luminaire/hull.h"
#include "luminaire/proxy.h"
#include "luminaire/view_field.h"

enum { HULL_TENSORS = 4, VIEW_TENSORS = 5, HULL_PART_NUMBERS = 7, VIEW_NUMBERS = 6 };

struct hull_numbers { // what the tensors point to
    float frame[6], parts[HULL_MAX_PARTS][HULL_PART_NUMBERS];
    uint32_t counts[2]; // vertices, triangles
};

// HULL_TENSORS and VIEW_TENSORS tensors, which point into `numbers`, the hull and the field.
void hull_describe(const struct hull *hull, struct hull_numbers *numbers, struct tensor *tensors);
void view_describe(const struct view_field *view, float numbers[VIEW_NUMBERS], struct tensor *tensors);
// STATUS_OK with *hull = NULL where the file holds none. Checks everything.
enum status hull_read(const struct safetensors *file, const char *name, const struct proxy *proxy, struct hull **hull,
                      struct error *error);
// `prefix`: of the group whose view field it is.
enum status view_read(const struct safetensors *file, const char *name, const char *prefix, const struct proxy *proxy,
                      const struct hull *hull, struct view_field **view, struct error *error);
