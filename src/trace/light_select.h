// The choice of one light for next-event estimation: the room's emitters, the baked luminaires, and, at a vertex that
// is live in a luminaire's own geometry, the emitters of that lamp.
#pragma once

#include "scene/scene.h"

struct light_choice {
    const struct emitter *emitter; // or NULL: the luminaire below
    uint32_t luminaire;
    float pmf;
};

struct light_point { // where light is gathered
    vec3 p;
    int kept; // luminaire instance whose kept geometry this is (it sends no light here), or -1
    int live; // luminaire instance whose own emitters count here, or -1
};

struct light_select;
enum status light_select_create(struct light_select **select, const struct scene *scene, struct error *error);
void light_select_destroy(struct light_select *select);

// False: no light. u in [0,1).
bool light_select_sample(const struct light_select *select, const struct light_point *point, float u,
                         struct light_choice *choice);
// Probability that light_select_sample gives this light.
float light_select_pmf_emitter(const struct light_select *select, const struct light_point *point,
                               const struct emitter *emitter);
float light_select_pmf_luminaire(const struct light_select *select, const struct light_point *point,
                                 uint32_t luminaire);
