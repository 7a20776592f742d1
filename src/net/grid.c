#include "net/grid.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>

int grid_add_level(struct grid_layout *layout, int dims, int resolution, int log2_entries, uint32_t slices) {
    assert(layout->level_count < GRID_MAX_LEVELS && dims >= 1 && dims <= GRID_MAX_DIMS);
    static const uint32_t primes[GRID_MAX_DIMS] = {1, 2654435761u, 805459861u, 3674653429u};
    struct grid_level *level = &layout->levels[layout->level_count];
    *level =
        (struct grid_level){.dims = dims, .resolution = resolution, .slices = slices, .offset = layout->entry_count};
    uint64_t dense = 1;
    for (int a = 0; a < dims; a++) {
        level->stride[a] = (uint32_t)dense;
        dense *= (uint64_t)resolution + 1;
    }
    if (dense <= (uint64_t)1 << log2_entries) {
        level->mask = UINT32_MAX;
        level->slice_entries = (uint32_t)dense;
    } else {
        for (int a = 0; a < dims; a++) level->stride[a] = primes[a];
        level->slice_entries = (uint32_t)1 << log2_entries;
        level->mask = level->slice_entries - 1;
    }
    layout->entry_count += level->slice_entries * slices;
    return layout->level_count++;
}

void grid_add_lookup(struct grid_layout *layout, int level, int set) {
    assert(layout->lookup_count < GRID_MAX_LOOKUPS && set < GRID_MAX_SETS);
    layout->lookups[layout->lookup_count++] = (struct grid_lookup){level, set, layout->corner_count};
    layout->corner_count += layout->levels[level].dims + 1;
    if (set >= layout->set_count) layout->set_count = set + 1;
}

int grid_input_count(const struct grid_layout *layout) {
    return (2 * layout->lookup_count + layout->raw_count + 3) & ~3;
}

void grid_by_lookup_make(const struct grid_layout *layout, const float *scale, struct grid_by_lookup *grid) {
    *grid = (struct grid_by_lookup){
        .lookup_count = layout->lookup_count, .raw_count = layout->raw_count, .input_count = grid_input_count(layout)};
    for (int j = 0; j < layout->lookup_count; j++) {
        const struct grid_level *level = &layout->levels[layout->lookups[j].level];
        for (int a = 0; a < level->dims; a++) {
            grid->resolution[a][j] = (float)level->resolution;
            grid->last[a][j] = level->resolution - 1;
            grid->stride[a][j] = level->stride[a];
        }
        grid->mask[j] = level->mask;
        grid->slice_entries[j] = level->slice_entries;
        grid->offset[j] = level->offset;
        grid->scale[j] = scale[layout->lookups[j].level];
        grid->set[j] = layout->lookups[j].set;
    }
}

void grid_quantise(const struct grid_layout *layout, const float *table, int8_t *codes, float *scale) {
    for (int k = 0; k < layout->level_count; k++) {
        const struct grid_level *level = &layout->levels[k];
        size_t first = (size_t)level->offset * 2, count = (size_t)level->slice_entries * level->slices * 2;
        float largest = 0;
        for (size_t i = first; i < first + count; i++) largest = fmaxf(largest, fabsf(table[i]));
        scale[k] = largest / 127;
        for (size_t i = first; i < first + count; i++)
            codes[i] = (int8_t)(largest > 0 ? lrintf(table[i] / scale[k]) : 0);
    }
}

void grid_corners(const struct grid_level *level, const float *coordinates, int slice, uint32_t *index, float *weight) {
    float fraction[GRID_MAX_DIMS];
    int axis[GRID_MAX_DIMS];
    uint32_t key = 0;
    for (int a = 0; a < level->dims; a++) {
        float p = fminf(fmaxf(coordinates[a], 0), 1) * (float)level->resolution;
        int cell = (int)p < level->resolution ? (int)p : level->resolution - 1;
        key += (uint32_t)cell * level->stride[a];
        int at = a;
        for (; at > 0 && fraction[at - 1] < p - (float)cell; at--) {
            fraction[at] = fraction[at - 1];
            axis[at] = axis[at - 1];
        }
        fraction[at] = p - (float)cell;
        axis[at] = a;
    }
    uint32_t base = level->offset + (uint32_t)slice * level->slice_entries;
    for (int k = 0; k <= level->dims; k++) {
        index[k] = base + (key & level->mask);
        weight[k] = (k ? fraction[k - 1] : 1) - (k < level->dims ? fraction[k] : 0);
        if (k < level->dims) key += level->stride[axis[k]];
    }
}
