// The forms that lamps are put together from. All are added to a mesh; those that glass may be made of say "closed".
#pragma once

#include "mesh_writer.h"

#define COUNT(array) ((int)(sizeof(array) / sizeof *(array)))

// A grid of rows x columns vertices, already written, the columns wrapping around; the rows do too where `closed`.
void solid_grid(struct mesh_writer *mesh, int first, int rows, int columns, bool closed);
// A tube round a curve of n points, open at its ends unless the curve is closed.
void solid_tube(struct mesh_writer *mesh, const struct point *curve, int n, double radius, bool closed);
// A horizontal ring about the vertical axis.
void solid_ring(struct mesh_writer *mesh, double radius, double y, double thickness);
// A profile of n pairs (radius, y), from the top down, turned about the vertical axis through `base`.
void solid_lathe(struct mesh_writer *mesh, struct point base, const double (*profile)[2], int n);
// The same with edges where the profile turns by more than 40 degrees; closed where the profile begins and ends at
// radius 0 or where it comes back to its first pair. A hollow body's profile runs up its inner wall and down its outer.
void solid_turned(struct mesh_writer *mesh, struct point base, const double (*profile)[2], int n, int sides);
// A closed faceted body without normals: a profile of n pairs (radius, height) from the top down, turned about `axis`
// (unit) through `origin` in `sides` corners; a radius of 0 is a point, other ends are flat.
void solid_gem(struct mesh_writer *mesh, struct point origin, struct point axis, double turn, int sides,
               const double (*profile)[2], int n);
// A gem that hangs from `hook`: a small table on top, a crown, a girdle and a pavilion that ends in a point.
void solid_drop(struct mesh_writer *mesh, struct point hook, int sides, double radius, double height, double turn);
