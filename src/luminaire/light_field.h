// What light_field.c and transparency.c share with the file and the assembly (src/luminaire only).
#pragma once

#include "luminaire/build.h"
#include "luminaire/field_net.h"

struct light_field {
    struct field_net net;
    float radiance_unit, scale[3];
};

struct transparency {
    struct field_net net;
};
