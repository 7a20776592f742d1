// An arena: many allocations, freed together. Everything a loaded scene owns lives in one.
#pragma once

#include <stddef.h>

struct arena {
    struct arena_block *blocks;
};

// Zeroed memory aligned to 64 bytes, valid until arena_fini; NULL when memory is out or the size overflows.
void *arena_alloc(struct arena *arena, size_t count, size_t size);
char *arena_strdup(struct arena *arena, const char *text);
char *arena_printf(struct arena *arena, const char *format, ...) __attribute__((format(printf, 2, 3)));
void arena_fini(struct arena *arena); // a zeroed arena is an empty one
