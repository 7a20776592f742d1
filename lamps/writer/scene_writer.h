// Mitsuba 3 XML of lamps, piece by piece.
#pragma once

#include <stdbool.h>
#include <stdio.h>

#include "point.h"

// The comment, the path integrator and a camera of 480 x 480 pixels with `fov` degrees.
void scene_begin(FILE *file, const char *comment, struct point camera, struct point target, double fov);
void scene_end(FILE *file);

void scene_dielectric(FILE *file, const char *id, double int_ior, double ext_ior);
// GGX of IOR 1.5; the tint (r, g, b) is of what is refracted and of what is reflected
void scene_rough_glass(FILE *file, const char *id, double alpha, const char *tint);
void scene_metal(FILE *file, const char *id, double alpha, const char *eta, const char *k); // "r, g, b" each
void scene_brass(FILE *file, const char *id, double alpha);

// `inside` is what stands in the shape: a bsdf, an emitter.
void scene_sphere(FILE *file, struct point center, double radius, const char *inside);
// `name` is a .obj or .ply beside the scene; `flat` leaves vertex normals aside.
void scene_mesh(FILE *file, const char *id, const char *name, bool flat, const char *inside);
