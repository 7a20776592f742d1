// A BSDF evaluated in a tilted frame, shared by bumpmap and normalmap.
#pragma once

#include "scene/bsdf.h"

// The frame about normal n (local, n.z > 0), with s next to the local x axis.
struct frame perturbed_frame(vec3 n);

// The child's functions in `frame`; its cosine is the tilted one, as usual for shading normals. Light that would change
// sides between the two frames is absorbed. With `shadowing`, light from near the horizon is dimmed by the masking of a
// GGX surface that has the same slopes, so that no hard edge is left where it would be cut off (Conty Estevez, Lecocq
// and Stein 2019, "A microfacet-based shadowing function to solve the bump terminator problem", eq. 2 and 3); Mitsuba
// 3.7 and later do so by default.
rgb perturbed_eval(const struct bsdf *child, const struct frame *frame, bool shadowing, const struct bsdf_point *point,
                   vec3 wi, vec3 wo, enum transport transport);
float perturbed_pdf(const struct bsdf *child, const struct frame *frame, const struct bsdf_point *point, vec3 wi,
                    vec3 wo, enum transport transport);
bool perturbed_sample(const struct bsdf *child, const struct frame *frame, bool shadowing,
                      const struct bsdf_point *point, vec3 wi, vec3 u, enum transport transport,
                      struct bsdf_sample *sample);
