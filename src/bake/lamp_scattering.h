// What becomes of the room's light that a lamp stops: a white shade sends much of it back, black iron none. Without it
// a baked lamp swallows 1 to 3 % of a furnished room's light.
#pragma once

#include "bake/gather.h"
#include "luminaire/luminaire.h"

// Measures it for light that comes evenly from all sides, beside what the luminaire lets through.
enum status lamp_scattering_measure(struct luminaire *luminaire, const struct lamp *lamp, struct error *error);
