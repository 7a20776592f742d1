// What light_field.c and transparency.c share with the file and the assembly (src/luminaire only).
#pragma once

#include "luminaire/build.h"
#include "luminaire/field_net.h"

struct light_field {
    struct field_net net;
    float radiance_unit, scale[3];
    float ceiling_offset, ceiling; // see light_field_fit_ceiling: in anchor radii; in units before the scale, 0: none
    enum light_loss loss;
};

struct hull_tree;

struct transparency {
    struct field_net net;
    struct hull_tree *tree; // of the hull that the network knows, or NULL
};

// Gives a transparency that was restored its hull. The hull is copied.
enum status transparency_set_hull(struct transparency *t, const struct hull *hull, struct error *error);
// Whether the line meets anything of the lamp; true where there is no hull to tell.
bool transparency_sees(const struct transparency *t, const float point[3], const float w[3]);
