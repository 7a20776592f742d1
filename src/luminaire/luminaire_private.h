// The finished luminaire, shared by luminaire.c and luminaire_file.c.
#pragma once

#include "luminaire/hull_file.h"
#include "luminaire/light_field.h"
#include "luminaire/paper.h"
#include "luminaire/proxy.h"
#include "luminaire/sampling.h"

struct luminaire {
    struct proxy_shape shape;
    struct paper *paper; // the published networks, which then stand in place of the next three; or NULL
    struct light_field *light;
    struct transparency *transparency; // NULL: T = 0
    struct sampling_density *density;
    struct hull *hull; // with its view field, or both NULL
    struct view_field *view;
    float flux[3];
    char **keys, **values;
    size_t metadata_count;
    size_t bytes; // of the file
};

enum status luminaire_set_metadata(struct luminaire *luminaire, const char *const *keys, const char *const *values,
                                   size_t count, struct error *error);
size_t
luminaire_measure(const struct luminaire *luminaire); // size of the file that luminaire_save would write, in tensors
