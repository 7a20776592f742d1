// Cells are numbered in the order in which they are made; a hash table with open addressing finds their numbers. Which
// cells there are and what they hold after a pass is the same for any order. The table cannot fill up: between passes
// it is decided whether more are made, and one pass makes CACHE_TELLERS x CACHE_TOLD x CACHE_SIZES at most. Answers
// have a table of their own, of the cells that know enough and no larger than needed, which is made anew now and then.
#include "trace/radiance_cache.h"

#include <stdlib.h>

#include "base/pages.h"
#include "trace/luminaire_crossing.h"

enum {
    LEVELS = 9, // of size, each half of the one before
    CELLS_ACROSS = 20, // the scene, of the largest
    LEAST_TOLD = 32, // before a cell of the largest size answers; twice as much with each smaller size
    LESSON_STRIDE = 8, // answers are made anew after one pass, and when there are an eighth more
    SLOTS = 1 << 20,
    MOST_CELLS = SLOTS / 2 + CACHE_TELLERS * CACHE_TOLD * CACHE_SIZES
};
enum { TELLING = 1 << 16, FORGOTTEN = 4, LEAST_WEIGHT = 16 * TELLING };
// One telling adds no more than this much of the scene's mean, or half of all that the cell has been told: a single
// bright path among some hundred would else light up a wall.
static const float most_of_mean = 128, most_of_told = 0.5f;
static const float finest = 0x1p-26f; // unit of the sums, of the radiance that the lights' power would bring
_Static_assert(MOST_CELLS < SLOTS, "a search in the table ends at a free slot");

struct slot {
    uint64_t key; // 0: free
    int32_t cell; // 1 + number; 0: it is being made
};

struct cell {
    uint64_t key;
    int64_t radiance[3]; // in `unit`
    int64_t weight; // of what has been told; TELLING: when it is told
    int64_t told; // times
    float most; // luminance that one telling may add, in `unit`; 0: the cell is new
};

struct answer {
    uint64_t key; // 0: free
    rgb mean;
    float count;
};

struct radiance_cache {
    vec3 corner; // of the scene's bounding cube
    float widest, unit;
    struct slot *slots;
    struct cell *cells;
    int32_t cell_count;
    bool full;
    struct answer *answers; // NULL: none yet
    size_t answer_slots; // a power of two, at least twice the answers
    size_t passes, next_lesson;
    float most; // of new cells
};

static float light_power(const struct scene *scene) {
    float power = 0;
    for (size_t i = 0; i < scene->emitter_count; i++) power += maxf(rgb_luminance(scene->emitters[i]->power), 0);
    for (size_t i = 0; i < scene->luminaire_count; i++)
        power += maxf(rgb_luminance(luminaire_power(&scene->luminaires[i])), 0);
    return power > 0 && isfinite(power) ? power : 1;
}

enum status radiance_cache_create(struct radiance_cache **result, const struct scene *scene, struct error *error) {
    struct radiance_cache *cache = calloc(1, sizeof *cache);
    *result = cache;
    if (cache) {
        cache->slots = pages_alloc(SLOTS, sizeof *cache->slots);
        cache->cells = calloc(MOST_CELLS, sizeof *cache->cells);
        cache->next_lesson = 1;
        cache->most = INFINITY;
    }
    if (!cache || !cache->slots || !cache->cells)
        return error_set(error, STATUS_MEMORY, "out of memory for the cache of radiance");
    const float r = scene->bounds.radius;
    cache->widest = 2 * r / CELLS_ACROSS;
    cache->corner = vec3_sub(scene->bounds.center, (vec3){r, r, r});
    cache->unit = finest * light_power(scene) / sqrf(r);
    return STATUS_OK;
}

void radiance_cache_destroy(struct radiance_cache *cache) {
    if (!cache) return;
    free(cache->slots);
    free(cache->cells);
    free(cache->answers);
    free(cache);
}

static size_t first_slot(uint64_t key, size_t slots) {
    return (size_t)(key * 0x9E3779B97F4A7C15ull >> 32) & (slots - 1);
}

static void answer_with(const struct radiance_cache *cache, const struct cell *cell, struct answer *answers,
                        size_t slots) {
    size_t i = first_slot(cell->key, slots);
    while (answers[i].key) i = (i + 1) & (slots - 1);
    const double scale = (double)cache->unit * TELLING / (double)cell->weight;
    answers[i] =
        (struct answer){cell->key,
                        {(float)(scale * (double)cell->radiance[0]), (float)(scale * (double)cell->radiance[1]),
                         (float)(scale * (double)cell->radiance[2])},
                        (float)cell->told};
}

// What is told rests on what the cache said before, for most light has been scattered more than once. So errors of the
// first answers stay: of n tellings the mean keeps n^(a - 1) of them, where a is the share of the light that answers
// bring. It is forgotten in time: whenever the passes have doubled, what was told before counts a quarter of what it
// did.
static void forget(struct radiance_cache *cache) {
    for (int32_t i = 0; i < cache->cell_count; i++) {
        struct cell *cell = &cache->cells[i];
        if (cell->weight < LEAST_WEIGHT) continue;
        for (int c = 0; c < 3; c++) cell->radiance[c] /= FORGOTTEN;
        cell->weight /= FORGOTTEN;
    }
}

static float luminance_of(const struct cell *cell) {
    return rgb_luminance((rgb){(float)cell->radiance[0], (float)cell->radiance[1], (float)cell->radiance[2]});
}

static void bound_tellings(struct radiance_cache *cache) {
    double told = 0, weight = 0;
    for (int32_t i = 0; i < cache->cell_count; i++) {
        told += (double)luminance_of(&cache->cells[i]);
        weight += (double)cache->cells[i].weight / TELLING;
    }
    cache->most = told > 0 ? most_of_mean * (float)(told / weight) : INFINITY;
    for (int32_t i = 0; i < cache->cell_count; i++)
        cache->cells[i].most = maxf(cache->most, most_of_told * luminance_of(&cache->cells[i]));
}

void radiance_cache_learn(struct radiance_cache *cache) {
    if (cache->passes > 1 && (cache->passes & (cache->passes - 1)) == 0) forget(cache);
    if (cache->passes++ < cache->next_lesson) return;
    cache->next_lesson = cache->passes + (cache->passes - 1) / LESSON_STRIDE;
    cache->full = cache->cell_count >= SLOTS / 2;
    bound_tellings(cache);
    size_t known = 0, slots = 1024;
    for (int32_t i = 0; i < cache->cell_count; i++) known += cache->cells[i].told >= LEAST_TOLD;
    while (slots < 2 * known) slots *= 2;
    struct answer *answers = calloc(slots, sizeof *answers);
    if (!answers) return; // those of before go on
    for (int32_t i = 0; i < cache->cell_count; i++)
        if (cache->cells[i].told >= LEAST_TOLD) answer_with(cache, &cache->cells[i], answers, slots);
    free(cache->answers);
    cache->answers = answers;
    cache->answer_slots = slots;
}

static uint64_t coordinate(float p, float corner, float width) {
    const float i = (p - corner) / width;
    return i > 0 ? i < 0x1.fffp12f ? (uint64_t)i : 0x1fff : 0;
}

// The level of the largest cell for a place; LEVELS: all are too large.
static int first_level(const struct radiance_cache *cache, const struct cache_place *place) {
    int level = 0;
    for (float width = cache->widest; width > place->width && level < LEVELS; width *= 0.5f) level++;
    return level;
}

static uint64_t cell_key(const struct radiance_cache *cache, const struct cache_place *place, int level) {
    const float width = ldexpf(cache->widest, -level);
    const vec3 n = place->n, a = {fabsf(n.x), fabsf(n.y), fabsf(n.z)};
    const int side = a.x >= a.y && a.x >= a.z ? n.x < 0 : a.y >= a.z ? 2 + (n.y < 0) : 4 + (n.z < 0);
    const uint64_t apart = (uint64_t)((level * 6 + side) * 2 + place->kind + 1);
    return (uint64_t)place->shape << 46 | apart << 39 | coordinate(place->p.x, cache->corner.x, width) << 26 |
           coordinate(place->p.y, cache->corner.y, width) << 13 | coordinate(place->p.z, cache->corner.z, width);
}

static const struct answer *find_answer(const struct radiance_cache *cache, uint64_t key) {
    const size_t slots = cache->answer_slots;
    for (size_t i = first_slot(key, slots); cache->answers[i].key; i = (i + 1) & (slots - 1))
        if (cache->answers[i].key == key) return &cache->answers[i];
    return NULL;
}

bool radiance_cache_mean(const struct radiance_cache *cache, const struct cache_place *place, rgb *mean) {
    const int first = first_level(cache, place);
    if (!cache->answers) return false;
    for (int k = (first + CACHE_SIZES < LEVELS ? CACHE_SIZES : LEVELS - first) - 1; k >= 0; k--) {
        const struct answer *answer = find_answer(cache, cell_key(cache, place, first + k));
        if (!answer || !(answer->count >= (float)(LEAST_TOLD << k))) continue;
        *mean = answer->mean;
        return true;
    }
    return false;
}

static int32_t find_or_make(struct radiance_cache *cache, uint64_t key) {
    for (size_t i = first_slot(key, SLOTS);; i = (i + 1) % SLOTS) {
        struct slot *slot = &cache->slots[i];
        uint64_t found = __atomic_load_n(&slot->key, __ATOMIC_RELAXED);
        if (!found && cache->full) return -1;
        if (!found && __atomic_compare_exchange_n(&slot->key, &found, key, false, __ATOMIC_RELAXED, __ATOMIC_RELAXED)) {
            const int32_t cell = __atomic_fetch_add(&cache->cell_count, 1, __ATOMIC_RELAXED);
            cache->cells[cell].key = key;
            __atomic_store_n(&slot->cell, cell + 1, __ATOMIC_RELAXED);
            return cell;
        }
        if (found != key) continue;
        int32_t cell;
        do cell = __atomic_load_n(&slot->cell, __ATOMIC_RELAXED);
        while (!cell); // another thread is making it
        return cell - 1;
    }
}

bool radiance_cache_cells(struct radiance_cache *cache, const struct cache_place *place, struct cache_cells *cells) {
    const int first = first_level(cache, place);
    for (int k = 0; k < CACHE_SIZES; k++) {
        cells->cells[k] = -1;
        if (first + k < LEVELS) cells->cells[k] = find_or_make(cache, cell_key(cache, place, first + k));
    }
    return cells->cells[0] >= 0;
}

void radiance_cache_tell(struct radiance_cache *cache, const struct cache_cells *cells, rgb radiance) {
    const float channels[3] = {radiance.r, radiance.g, radiance.b};
    float values[3];
    for (int c = 0; c < 3; c++) values[c] = minf(maxf(channels[c] / cache->unit, 0), 0x1p50f);
    const float luminance = rgb_luminance((rgb){values[0], values[1], values[2]});
    for (int k = 0; k < CACHE_SIZES; k++) {
        if (cells->cells[k] < 0) continue;
        struct cell *cell = &cache->cells[cells->cells[k]];
        const float most = cell->most > 0 ? cell->most : cache->most, share = luminance > most ? most / luminance : 1;
        for (int c = 0; c < 3; c++)
            __atomic_fetch_add(&cell->radiance[c], (int64_t)(share * values[c]), __ATOMIC_RELAXED);
        __atomic_fetch_add(&cell->weight, TELLING, __ATOMIC_RELAXED);
        __atomic_fetch_add(&cell->told, 1, __ATOMIC_RELAXED);
    }
}
