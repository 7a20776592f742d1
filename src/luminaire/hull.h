// The hull: a small quantised mesh of what of a lamp can be seen from outside, kept in the file for rays that look at
// the lamp. Smooth clear glass is traced through; every other part is a surface on which the view field (view_field.h)
// lies. Positions are 24-bit steps within the hull's box, in lamp coordinates: a facet of a few millimetres whose
// corners are off by 16-bit steps turns far enough to move the glints that it shows. On smooth parts
// vertices have normals of 12-bit steps; elsewhere the triangles' own count.
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/error.h"
#include "math/vec.h"

enum hull_kind { HULL_OPAQUE, HULL_TRANSLUCENT, HULL_GLASS }; // translucent: the transparency dims what lies behind
enum { HULL_BITS = 24, HULL_MAX_CODE = (1 << HULL_BITS) - 1 };
enum { HULL_NORMAL_BITS = 12, HULL_MAX_NORMAL = (1 << HULL_NORMAL_BITS) - 1 };
enum { HULL_MAX_PARTS = 64, HULL_MAX_VERTICES = 65536, HULL_MAX_TRIANGLES = 1 << 18 };

struct hull_part { // triangles [first, first + count); parts follow each other and fill the mesh
    enum hull_kind kind;
    bool smooth; // the vertices' normals are interpolated
    uint32_t first, count;
    float eta; // HULL_GLASS: index of refraction, inside over outside
    float sigma_a[3]; // HULL_GLASS: absorption inside [1/length]
};

struct hull {
    float lower[3], step[3]; // position = lower + code * step
    uint32_t (*vertices)[3]; // codes of HULL_BITS
    uint16_t (*normals)[2]; // of every vertex: codes of HULL_NORMAL_BITS over the octahedral square, 0 on flat parts
    uint16_t (*triangles)[3];
    size_t vertex_count, triangle_count;
    struct hull_part parts[HULL_MAX_PARTS];
    size_t part_count;
    unsigned char *packed; // vertices and triangles as the file has them (hull_pack.h), or NULL
    size_t packed_bytes;
};

enum status hull_allocate(struct hull **hull, size_t vertex_count, size_t triangle_count, struct error *error);
void hull_destroy(struct hull *hull); // NULL is allowed
// Parts, indices and numbers in range. `center`, `radius`: of the proxy.
enum status hull_check(const struct hull *hull, const float center[3], float radius, struct error *error);
vec3 hull_vertex(const struct hull *hull, size_t vertex);
void hull_set_vertex(struct hull *hull, size_t vertex, vec3 p); // the nearest position that the frame has
vec3 hull_normal(const struct hull *hull, size_t vertex); // unit
void hull_set_normal(struct hull *hull, size_t vertex, vec3 n); // n: unit
vec3 hull_face_normal(const struct hull *hull, size_t triangle); // unit, (0, 0, 1) where the triangle has no area
