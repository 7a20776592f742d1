// Feature grids: tables of two features per entry, dense or hashed, looked up at points of [0,1]^dims and interpolated
// on Kuhn simplices (sort the fractions, dims + 1 corners). A layout says which levels exist and which lookups feed the
// MLP; it holds no weights, so the trainer (float tables) and the query side (8-bit tables) share it. Hash: Mueller et
// al. 2022 (Instant NGP), eq. 4, with the sum in place of the exclusive or: neighbours along the first axis stay
// neighbours in memory and one addition leads from corner to corner.
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum {
    NET_LANES = 16, // samples a block; every block array is [feature][NET_LANES]
    GRID_MAX_DIMS = 4,
    GRID_MAX_LEVELS = 24,
    GRID_MAX_LOOKUPS = 56,
    GRID_MAX_SETS = 10,
    GRID_MAX_RAW = 20,
};

struct grid_level {
    int dims, resolution; // cells per axis
    uint32_t stride[4]; // key = sum cell[a] * stride[a]
    uint32_t mask; // entry = key & mask within the slice
    uint32_t slice_entries; // entries a slice; a slice is an independent grid of the same shape
    uint32_t slices;
    uint32_t offset; // first entry of slice 0 in the table
};

struct grid_lookup {
    int level, set; // two features, of this level at this coordinate set
    int corner; // its first corner in a block's index and weight arrays
};

struct grid_layout {
    struct grid_level levels[GRID_MAX_LEVELS];
    struct grid_lookup lookups[GRID_MAX_LOOKUPS];
    int level_count, lookup_count, set_count, raw_count;
    int corner_count; // of all lookups of one sample
    uint32_t entry_count; // of all levels
};

// The inputs of one block: coordinate sets in [0,1] (others are clamped), the slice of each set, features passed
// through.
struct grid_input {
    _Alignas(64) float set[GRID_MAX_SETS][GRID_MAX_DIMS][NET_LANES];
    int32_t slice[GRID_MAX_SETS][NET_LANES];
    float raw[GRID_MAX_RAW][NET_LANES];
};

// A finished layout lookup by lookup, for kernels whose lanes are the lookups of one sample. An axis that a level lacks
// has no cells and no stride; lanes past the last lookup read entry 0.
enum { GRID_LOOKUP_LANES = 64 };
struct grid_by_lookup {
    _Alignas(64) float resolution[GRID_MAX_DIMS][GRID_LOOKUP_LANES];
    int32_t last[GRID_MAX_DIMS][GRID_LOOKUP_LANES]; // cell of the axis
    uint32_t stride[GRID_MAX_DIMS][GRID_LOOKUP_LANES];
    uint32_t mask[GRID_LOOKUP_LANES], slice_entries[GRID_LOOKUP_LANES], offset[GRID_LOOKUP_LANES];
    float scale[GRID_LOOKUP_LANES]; // of the level's codes
    int32_t set[GRID_LOOKUP_LANES];
    int lookup_count, raw_count, input_count;
};
void grid_by_lookup_make(const struct grid_layout *layout, const float *scale, struct grid_by_lookup *grid);

// Adds a level: dense where (resolution + 1)^dims <= 2^log2_entries, else hashed. Returns its number.
int grid_add_level(struct grid_layout *layout, int dims, int resolution, int log2_entries, uint32_t slices);
void grid_add_lookup(struct grid_layout *layout, int level, int set);
// Features in an MLP's input: two a lookup, then the raw ones, then zeros up to a multiple of 4.
int grid_input_count(const struct grid_layout *layout);

// 8-bit tables: value = code * scale[level], scale[level] = max |value| / 127. codes: entry_count * 2 (+ GRID_PADDING
// bytes).
enum { GRID_PADDING = 2 };
void grid_quantise(const struct grid_layout *layout, const float *table, int8_t *codes, float *scale);

// Scalar reference of one lookup: indices and weights of its corners for one sample.
void grid_corners(const struct grid_level *level, const float *coordinates, int slice, uint32_t *index, float *weight);
