// A hull's mesh in a file: a zlib stream (RFC 1950) of small differences. Lamps repeat their crystals, so that some two
// bytes a triangle are left of the 14 in memory.
#pragma once

#include "luminaire/hull.h"

// Makes hull->packed of the vertices and triangles.
enum status hull_pack(struct hull *hull, struct error *error);
// Vertices and triangles, of which the hull has the number, from a stream, which it copies. STATUS_INVALID: not a
// stream of as many.
enum status hull_unpack(struct hull *hull, const void *bytes, size_t count, struct error *error);
