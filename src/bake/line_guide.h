// Where to look: a density over the lines that cross the lamp's bounding sphere, learned from particle exits. Guided
// camera lines, untraced lines and the integrals of a finished model are all drawn from it.
//
// Lines are measured by dA_perp dw. With e the entry and u the exit point on the sphere this measure is dA(e) dA(u) /
// (4 R^2), because both cosines are |u - e| / (2 R): points independent and uniform on the sphere give uniform lines.
#pragma once

#include "bake/gather.h"
#include "trace/emission_cluster.h"

struct line_guide;

// p = 0.3 uniform + the rest by a histogram of the exits (20 x 50 cells each of entry and exit point) raised to
// `exponent` and, where cluster_share > 0, by lines that pass the clusters. Deterministic.
struct line_guide_options {
    vec3 center;
    float radius;
    const struct line_exit *exits;
    size_t exit_count;
    float exponent;
    const struct emission_cluster *clusters;
    size_t cluster_count;
    float cluster_share;
};
enum status line_guide_create(struct line_guide **guide, const struct line_guide_options *options, struct error *error);
void line_guide_destroy(struct line_guide *guide);

// *point is where the line leaves the sphere. Returns the density [1/(length^2 sr)], > 0; 0: this draw gave no line
// that crosses the sphere, count it as a sample of value 0.
float line_guide_sample(const struct line_guide *guide, struct sampler *sampler, vec3 *point, vec3 *w);
float line_guide_density(const struct line_guide *guide, vec3 point, vec3 w);
