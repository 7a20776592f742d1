// Light samples of one lamp, drawn in a batch.
#pragma once

#include "scene/scene.h"

struct lamp_draws {
    float (*points)[3], (*numbers)[3]; // in the lamp's own space; three random numbers each
    float (*directions)[3], *pdfs; // what was drawn: in the same space; [1/sr]
};

enum status lamp_draws_init(struct lamp_draws *draws, size_t capacity, struct error *error);
void lamp_draws_fini(struct lamp_draws *draws); // what init has left after an error too

void lamp_draws_ask(struct lamp_draws *draws, size_t i, const struct luminaire_instance *lamp, vec3 point, vec2 u,
                    float third);
void lamp_draws_answer(struct lamp_draws *draws, size_t count, const struct luminaire_instance *lamp);
vec3 lamp_draws_direction(const struct lamp_draws *draws, size_t i,
                          const struct luminaire_instance *lamp); // in the room
