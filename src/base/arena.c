#include "base/arena.h"

#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct arena_block {
    struct arena_block *next;
    size_t used, size;
};

enum { BLOCK_HEADER = 64, BLOCK_SIZE = 1 << 16 };

void *arena_alloc(struct arena *arena, size_t count, size_t size) {
    if (size && count > (SIZE_MAX / 2) / size) return NULL;
    size_t bytes = (count * size + 63) & ~(size_t)63;
    struct arena_block *block = arena->blocks;
    if (!block || block->size - block->used < bytes) {
        size_t capacity = bytes > BLOCK_SIZE - BLOCK_HEADER ? bytes + BLOCK_HEADER : BLOCK_SIZE;
        block = aligned_alloc(64, capacity);
        if (!block) return NULL;
        *block = (struct arena_block){arena->blocks, BLOCK_HEADER, capacity};
        arena->blocks = block;
    }
    void *result = (char *)block + block->used;
    block->used += bytes;
    memset(result, 0, bytes);
    return result;
}

char *arena_strdup(struct arena *arena, const char *text) {
    size_t length = strlen(text) + 1;
    char *copy = arena_alloc(arena, length, 1);
    if (copy) memcpy(copy, text, length);
    return copy;
}

char *arena_printf(struct arena *arena, const char *format, ...) {
    va_list arguments, again;
    va_start(arguments, format);
    va_copy(again, arguments);
    int length = vsnprintf(NULL, 0, format, arguments);
    va_end(arguments);
    char *text = length < 0 ? NULL : arena_alloc(arena, (size_t)length + 1, 1);
    if (text) vsnprintf(text, (size_t)length + 1, format, again);
    va_end(again);
    return text;
}

void arena_fini(struct arena *arena) {
    for (struct arena_block *block = arena->blocks, *next; block; block = next) {
        next = block->next;
        free(block);
    }
    arena->blocks = NULL;
}
