// Builds a distribution by its own functions and moves the tables into the arena.
#include "scene/distribution_arena.h"

#include <string.h>

static bool move_table(struct distribution *d, struct arena *arena) {
    float *cdf = arena_alloc(arena, d->n + 1, sizeof *cdf);
    struct distribution moved = {cdf, d->n, d->total};
    if (cdf) memcpy(cdf, d->cdf, (d->n + 1) * sizeof *cdf);
    distribution_fini(d);
    if (cdf) *d = moved;
    return cdf != NULL;
}

enum status distribution_init_arena(struct distribution *d, const float *weights, size_t n, struct arena *arena,
                                    struct error *error) {
    enum status status = distribution_init(d, weights, n, error);
    if (status != STATUS_OK) return status;
    return move_table(d, arena) ? STATUS_OK : error_set(error, STATUS_MEMORY, "out of memory for %zu weights", n);
}

enum status distribution2d_init_arena(struct distribution2d *d, const float *weights, size_t width, size_t height,
                                      struct arena *arena, struct error *error) {
    *d = (struct distribution2d){.width = width, .height = height};
    d->columns = arena_alloc(arena, height, sizeof *d->columns);
    float *sums = arena_alloc(arena, height, sizeof *sums);
    if (!d->columns || !sums)
        return error_set(error, STATUS_MEMORY, "out of memory for %zu x %zu weights", width, height);
    for (size_t y = 0; y < height; ++y) {
        enum status status = distribution_init_arena(&d->columns[y], weights + y * width, width, arena, error);
        if (status != STATUS_OK) return status;
        sums[y] = (float)d->columns[y].total;
    }
    return distribution_init_arena(&d->rows, sums, height, arena, error);
}
