// How the groups of a lamp are dimmed and tinted: "bulb=0.3; spot=800lm 2700K".
#pragma once

#include <stddef.h>

#include "luminaire/luminaire.h"

#define GROUP_ALL "all" // the whole lamp
#define LUMENS_PER_WATT 683 // of light at 555 nm, in whose watts luminances are counted (docs/conventions.md)

struct group_light {
    const char *name; // NULL: the light of a lamp without groups
    float flux[3]; // [W] with factors of 1
    float factor[3]; // is multiplied by what the text says
};

// Items NAME=SETTING between semicolons or commas, in the order that they are written in; NAME may be "all". A setting
// is one or several of: a factor (0.3), a factor for each colour (1:0.8:0.6), a colour temperature (2700K), which keeps
// the luminous flux, a luminous flux (800lm). Errors: unknown or repeated names, what is no setting, a colour or flux
// for what is dark.
enum status group_settings_apply(const char *text, struct group_light *groups, size_t count, struct error *error);
// The factors of a luminaire's groups by such a text; one factor where it has no groups. length: of the lamp's unit as
// it is placed [m], which lumens depend on.
enum status luminaire_group_factors(const struct luminaire *luminaire, const char *text, float length,
                                    float factors[LUMINAIRE_MAX_GROUPS][3], struct error *error);
// [lm]
float luminous_flux(const float flux[3]);
// Whether `name` can name a group, LUMINAIRE_NAME_SIZE being room enough.
enum status group_name_check(const char *name, struct error *error);
