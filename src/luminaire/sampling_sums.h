// From lines with light on them to the images of a sampling density (src/luminaire only).
#pragma once

#include "luminaire/sampling.h"

struct sampling_line {
    vec3 point, w;
    float flux; // what it stands for; > 0
    float radiance; // on it; 0: not known
    int anchor; // that it passes, or -1
};

struct sampling_sums {
    struct sampling_density *density;
    float *light, *squares; // [cell][MAP_PIXELS] of the map's lines: integrals of their radiance and of its square
    double *anchors; // [cell] integral over the anchors' lines
    double *measure; // [cell] of all lines, where the radiance is known
    double *weights; // [cell] squares of the map's lines' flux
};

enum status sampling_sums_init(struct sampling_sums *sums, struct sampling_density *density, struct error *error);
void sampling_sums_fini(struct sampling_sums *sums);
// Every line stands for light at all points along it: each cell hears of it at distances that are drawn by the line's
// number, first + index, `repeats` of them in each distance bin.
void sampling_sums_add(struct sampling_sums *sums, const struct sampling_line *lines, size_t count, size_t first,
                       int repeats, uint64_t seed, int threads);
void sampling_sums_encode(const struct sampling_sums *sums); // the density's codes, shares and what derives from them

// The nearest anchor to a line, -1: there are none; and how near.
int sampling_nearest_anchor(const struct sampling_density *density, vec3 point, vec3 w, float *distance);
// The anchor whose cones draw a line, -1: none.
int sampling_anchor_of(const struct sampling_density *density, vec3 point, vec3 w);
// All channels count alike, so that no colour goes unsampled. 0 where that is no positive number.
float sampling_mean(const float channels[3]);
// Intensities of the anchors, from sums of the flux of their lines.
void sampling_add_intensity(struct sampling_density *density, const struct sampling_line *line);
void sampling_end_intensities(struct sampling_density *density);
