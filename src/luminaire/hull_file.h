// The tensors of a hull and its view field, for luminaire_file.c.
#pragma once

#include "format/safetensors.h"
#include "luminaire/hull.h"
#include "luminaire/proxy.h"
#include "luminaire/view_field.h"

enum { HULL_TENSORS = 9, HULL_PART_NUMBERS = 7, VIEW_NUMBERS = 6 };

struct hull_numbers { // what the tensors point to
    float frame[6], parts[HULL_MAX_PARTS][HULL_PART_NUMBERS], view[VIEW_NUMBERS];
};

// HULL_TENSORS tensors, which point into `numbers`, the hull and the field.
void hull_describe(const struct hull *hull, const struct view_field *view, struct hull_numbers *numbers,
                   struct tensor *tensors);
// STATUS_OK with *hull = *view = NULL where the file holds none. Checks everything.
enum status hull_read(const struct safetensors *file, const char *name, const struct proxy *proxy, struct hull **hull,
                      struct view_field **view, struct error *error);
