// Where scattered light comes from: a few clusters of lit surface (a ceiling above a lamp, a wall beside it) and of
// images of lamps in mirrors and polished floors, learned from what earlier paths met; each is a ball with a mean
// normal and a mean radiance. From a point each is a lobe of directions, and a mixture of lobes in proportion to the
// light expected from each is the density that scattering is mixed with. This is path guiding as in Vorba et al. 2014
// ("On-line Learning of Parametric Mixture Models for Light Transport Simulation") and Mueller et al. 2017 ("Practical
// Path Guiding"), but with one set of sources for the whole scene in place of a distribution of directions for each
// place: parallax is exact, and some thousand paths teach it. What it has learned changes the noise, never the mean.
#pragma once

#include <stddef.h>

#include "math/vec.h"

enum { GUIDE_CLUSTERS = 64 }; // a multiple of GUIDE_LANES
enum { GUIDE_LANES = 8 };

struct guide_record { // a place that a path got light from
    vec3 p, n; // n: unit, towards the path
    float radiance; // estimate of what comes from there; luminance
    float share; // estimate of that light's part in its pixel, relative to the pixel
};

struct guide { // by components, for vector arithmetic; unused clusters have no radiance
    float x[GUIDE_CLUSTERS], y[GUIDE_CLUSTERS], z[GUIDE_CLUSTERS]; // centres
    float radius[GUIDE_CLUSTERS];
    float nx[GUIDE_CLUSTERS], ny[GUIDE_CLUSTERS], nz[GUIDE_CLUSTERS]; // mean normals: shorter where normals differ
    float all_round[GUIDE_CLUSTERS]; // share of the radiance that goes to all sides, for the same reason
    float radiance[GUIDE_CLUSTERS];
    float contrast; // E L^2 / (E L)^2 of the clusters' radiance as paths met them; 1: all alike; 0: nothing learned
};

// Replaces what was learned. Sorts the records. The same records in the same order give the same guide.
void guide_learn(struct guide *guide, struct guide_record *records, size_t count);

struct guide_view { // the lobes from one point: density (1 + 2 s) / (4 pi (1 + s (1 - cos))^2), s the sharpness
    float x[GUIDE_CLUSTERS], y[GUIDE_CLUSTERS], z[GUIDE_CLUSTERS]; // axes
    float sharpness[GUIDE_CLUSTERS];
    float weight[GUIDE_CLUSTERS];
    float sum; // of the weights
};

// False where nothing is expected from above the horizon of the unit normal n; then *view is not to be used.
bool guide_look(const struct guide *guide, vec3 p, vec3 n, struct guide_view *view);
vec3 guide_sample(const struct guide_view *view, float u_lobe, vec2 u_direction);
// [1/sr]; *radiance: of the brightest cluster in that direction, 0: none.
float guide_pdf(const struct guide *guide, const struct guide_view *view, vec3 direction, float *radiance);
