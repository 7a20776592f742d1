// The hull: a small quantised mesh of what of a lamp can be seen from outside, kept in the file for rays that look at
// the lamp. Smooth clear glass is traced through; every other part is a surface on which the view field (view_field.h)
// lies. Positions are 16-bit steps within the hull's box, in lamp coordinates; normals are derived.
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/error.h"
#include "math/vec.h"

enum hull_kind { HULL_OPAQUE, HULL_TRANSLUCENT, HULL_GLASS }; // translucent: the transparency dims what lies behind
enum { HULL_MAX_PARTS = 64, HULL_MAX_VERTICES = 65536, HULL_MAX_TRIANGLES = 1 << 18 };

struct hull_part { // triangles [first, first + count); parts follow each other and fill the mesh
    enum hull_kind kind;
    bool smooth; // normals are interpolated where the crease is blunt
    uint32_t first, count;
    float eta; // HULL_GLASS: index of refraction, inside over outside
    float sigma_a[3]; // HULL_GLASS: absorption inside [1/length]
};

struct hull {
    float lower[3], step[3]; // position = lower + code * step
    uint16_t (*vertices)[3], (*triangles)[3];
    size_t vertex_count, triangle_count;
    struct hull_part parts[HULL_MAX_PARTS];
    size_t part_count;
};

enum status hull_allocate(struct hull **hull, size_t vertex_count, size_t triangle_count, struct error *error);
void hull_destroy(struct hull *hull); // NULL is allowed
// Parts, indices and numbers in range. `center`, `radius`: of the proxy.
enum status hull_check(const struct hull *hull, const float center[3], float radius, struct error *error);
vec3 hull_vertex(const struct hull *hull, size_t vertex);
// Unit normals of the three corners of every triangle: the triangle's own, or on smooth parts the angle-weighted mean
// over the neighbours that meet it in a blunt crease. `normals` has 3 * triangle_count slots.
enum status hull_corner_normals(const struct hull *hull, vec3 *normals, struct error *error);
