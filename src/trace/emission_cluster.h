// Where a lamp emits: balls round its emission points, for rays to aim at.
#pragma once

#include "scene/scene.h"

enum { EMISSION_CLUSTERS = 64 };

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
