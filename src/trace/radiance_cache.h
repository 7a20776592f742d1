// What arrives at the surfaces of a room, learned while it is rendered: the mean incoming radiance (irradiance / pi) in
// cells of position and normal. Keller, Dahm and Binder 2016 ("Path space filtering") share light between paths so; the
// size of a cell follows the footprint of the path that asks, as in Binder et al. 2019 ("Massively parallel path space
// filtering"). Every point is in cells of CACHE_SIZES sizes, and the smallest that knows enough answers: the more is
// told, the finer. Sums are of integers, so what is known after a pass does not depend on the order of its paths.
#pragma once

#include "base/error.h"
#include "scene/scene.h"

struct radiance_cache;
struct cache_place { // of a cell
    vec3 p, n; // where, and the unit normal on the side that light arrives at
    float width; // [length] of the largest cell, at most
    uint32_t shape; // index; light on different shapes is kept apart,
    int kind; // and of kind 0 and 1
};

enum { CACHE_SIZES = 4 }; // each half of the one before
enum { CACHE_TELLERS = 1 << 15, CACHE_TOLD = 2 }; // most paths of one pass that make cells; and of how many places

struct cache_cells {
    int32_t cells[CACHE_SIZES]; // the widest first; -1: none
};

enum status radiance_cache_create(struct radiance_cache **cache, const struct scene *scene, struct error *error);
void radiance_cache_destroy(struct radiance_cache *cache); // NULL is allowed
// Between passes: now and then, cells answer from here on with the mean of what they have been told, of late more than
// before.
void radiance_cache_learn(struct radiance_cache *cache);

// --- Thread-safe. ---
// False: too little is known.
bool radiance_cache_mean(const struct radiance_cache *cache, const struct cache_place *place, rgb *mean);
// The cells of a place, made if need be. False: there can be none.
bool radiance_cache_cells(struct radiance_cache *cache, const struct cache_place *place, struct cache_cells *cells);
void radiance_cache_tell(struct radiance_cache *cache, const struct cache_cells *cells, rgb radiance);
