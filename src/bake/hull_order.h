// The triangles of a hull in an order that packs well (luminaire/hull_pack.h): each begins with an edge of one shortly
// before it, and vertices are numbered as they come up.
#pragma once

#include "luminaire/hull.h"

// Keeps the parts, which way every triangle is wound, and all positions. Vertices of no triangle are dropped.
enum status hull_order(struct hull *hull, struct error *error);
