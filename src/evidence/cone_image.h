// The lamp as one shading point sees it: values over a square grid on the cone of its bounding sphere, equal in solid
// angle, as the paper's sampling images are.
#pragma once

#include "bake/gather.h"
#include "luminaire/sampling.h"

struct cone_image {
    vec3 point; // its normal faces the lamp's centre
    struct sampling_view view;
    int side; // of the grid
    float solid_angle; // of a grid cell
    float (*direction)[3]; // [side * side] of cell centres, from the point to the lamp
    float *value; // [side * side]
};

// `out`: unit, from the lamp's centre to the point; `distance` in radii, above 1. Values are 0.
enum status cone_image_init(struct cone_image *image, const struct luminaire *luminaire, vec3 out, float distance,
                            int side, struct error *error);
void cone_image_fini(struct cone_image *image);
// Luminance times cosine as the light field has it; by traced lines, `samples` of each cell.
void cone_image_predict(struct cone_image *image, const struct luminaire *luminaire);
void cone_image_trace(struct cone_image *image, const struct lamp *lamp, int samples, uint64_t stream);
// The probability density of luminaire_sample, per solid angle.
void cone_image_density(struct cone_image *image, const struct luminaire *luminaire);

// Means of the values over coarse x coarse blocks of cells; `side` must be a multiple of coarse.
void cone_image_average(const struct cone_image *image, int coarse, float *mean);
// Relative variance of value / density over directions drawn with that density: E[(v / p)^2] / E[v / p]^2 - 1.
double cone_image_variance(const struct cone_image *image, const float *density);
