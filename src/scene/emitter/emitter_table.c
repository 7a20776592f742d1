// Every type of light. A new one is a file and a line here.
#include "scene/emitter.h"

extern const struct emitter_type emitter_area, emitter_point, emitter_spot, emitter_directional, emitter_constant,
    emitter_envmap;

const struct emitter_type *const emitter_table[] = {
    &emitter_area, &emitter_point, &emitter_spot, &emitter_directional, &emitter_constant, &emitter_envmap, NULL};
