// Warps of the unit square with their densities. warp_table lists every one; the chi-square test loops over it.
#pragma once

#include "math/vec.h"

vec3 warp_uniform_sphere(vec2 u);
float warp_uniform_sphere_pdf(void);
vec3 warp_uniform_hemisphere(vec2 u);
vec3 warp_cosine_hemisphere(vec2 u); // pdf_sa = cos / pi
float warp_cosine_hemisphere_pdf(vec3 w);
vec3 warp_uniform_cone(vec2 u, float cos_max); // about +z
float warp_uniform_cone_pdf(float cos_max);
vec2 warp_concentric_disk(vec2 u); // Shirley and Chiu 1997
vec2 warp_triangle(vec2 u); // barycentrics (b1, b2)
float warp_tent(float u); // on [-1, 1]
float warp_gaussian(float u, float stddev, float radius); // truncated at +-radius
// The octahedral map, unit sphere <-> [0,1]^2 (Engelhardt and Dachsbacher 2008).
vec2 octahedral_from_direction(vec3 w);
vec3 direction_from_octahedral(vec2 p);

struct warp { // for the test: maps the square to directions
    const char *name;
    vec3 (*sample)(vec2 u);
    float (*pdf_sa)(vec3 w);
};
extern const struct warp warp_table[]; // ends with name == NULL
