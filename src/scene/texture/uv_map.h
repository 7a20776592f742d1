// The to_uv transform of textures: the upper left 2x2 block and the translation act on (u, v), as in Mitsuba 3.
#pragma once

#include "math/transform.h"

static inline vec2 uv_map_apply(const struct transform *to_uv, vec2 uv) {
    const float(*m)[4] = to_uv->m;
    return (vec2){m[0][0] * uv.x + m[0][1] * uv.y + m[0][3], m[1][0] * uv.x + m[1][1] * uv.y + m[1][3]};
}
