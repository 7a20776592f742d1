// Where a lamp emits: balls round its emission points, for rays to aim at.
#pragma once

#include "scene/scene.h"

enum { EMISSION_CLUSTERS = 64, EMISSION_BEADS = 256 };

struct emission_cluster {
    vec3 center;
    float radius; // holds its emission points
    float share; // of the emitted power
};

// The fewest clusters, up to EMISSION_CLUSTERS, such that no emission point is farther than a tenth of `lamp_radius`
// from its cluster's centre; one to each where the emission is in more pieces, far apart for their size. Of the
// emitters that belong to instance `luminaire`'s geometry; -1: of the scene itself.
enum status emission_clusters_find(struct emission_cluster clusters[EMISSION_CLUSTERS], size_t *count,
                                   const struct scene *scene, int luminaire, float lamp_radius, struct error *error);
// The same emission as `count` <= EMISSION_BEADS balls, evenly along or over it. *reach (or NULL): how far it is from
// the nearest of so many of its own points; half as far for twice as many where it is long and thin.
enum status emission_beads_find(float (*beads)[3], size_t count, float *reach, const struct scene *scene, int luminaire,
                                struct error *error);
