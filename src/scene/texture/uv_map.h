// Where a texture lies on uv: the to_uv transform (its upper left 2x2 block and the translation act on (u, v), as in
// Mitsuba 3) after the scales and offsets of Mitsuba 0.5.
#pragma once

#include "base/param.h"
#include "math/transform.h"

struct uv_map {
    struct transform to_uv;
    float uscale, vscale, uvscale, uoffset, voffset;
};

#define UV_MAP_PARAMS(type, field)                                                                                     \
    {"to_uv", PARAM_TRANSFORM, offsetof(type, field.to_uv), "", .help = "applied to uv"},                              \
        {"uscale",                                                                                                     \
         PARAM_FLOAT,                                                                                                  \
         offsetof(type, field.uscale),                                                                                 \
         "1",                                                                                                          \
         .min = -1e6,                                                                                                  \
         .max = 1e6,                                                                                                   \
         .help = "repetitions along u (Mitsuba 0.5)"},                                                                 \
        {"vscale",    PARAM_FLOAT, offsetof(type, field.vscale), "1",                                                  \
         .min = -1e6, .max = 1e6,  .help = "repetitions along v"},                                                     \
        {"uvscale",   PARAM_FLOAT, offsetof(type, field.uvscale), "1",                                                 \
         .min = -1e6, .max = 1e6,  .help = "multiplies both"},                                                         \
        {"uoffset",   PARAM_FLOAT, offsetof(type, field.uoffset),       "0",                                           \
         .min = -1e6, .max = 1e6,  .help = "added to u after its scale"},                                              \
    {                                                                                                                  \
        "voffset", PARAM_FLOAT, offsetof(type, field.voffset), "0", .min = -1e6, .max = 1e6,                           \
                                                                    .help = "added to v after its scale"               \
    }

// Puts the scales and offsets into to_uv: once, after the parameters are read.
static inline void uv_map_init(struct uv_map *map) {
    struct transform scale = transform_identity(),
                     offset = transform_translate(vec3_make(map->uoffset, map->voffset, 0));
    scale.m[0][0] = map->uscale * map->uvscale; // may be 0, so that no inverse is asked for
    scale.m[1][1] = map->vscale * map->uvscale;
    offset = transform_multiply(&offset, &scale);
    map->to_uv = transform_multiply(&map->to_uv, &offset);
}

static inline vec2 uv_map_apply(const struct uv_map *map, vec2 uv) {
    const float(*m)[4] = map->to_uv.m;
    return (vec2){m[0][0] * uv.x + m[0][1] * uv.y + m[0][3], m[1][0] * uv.x + m[1][1] * uv.y + m[1][3]};
}
