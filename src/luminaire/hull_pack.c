// docs/luminaire-format.md describes the stream.
#include "luminaire/hull_pack.h"

#include <stdlib.h>
#include <string.h>
#include <zlib.h>

enum { POSITION_BYTES = 3, NORMAL_BYTES = 2, VERTEX_BYTES = 3 * POSITION_BYTES + 2 * NORMAL_BYTES, TRIANGLE_BYTES = 6 };

// Differences modulo 2^bits with the sign in the lowest bit, so that small ones of either sign have zeros above.
static uint32_t fold(uint32_t difference, int bytes) {
    const uint32_t mask = (1u << 8 * bytes) - 1, d = difference & mask;
    return d > mask >> 1 ? (mask - d) << 1 | 1 : d << 1;
}

static uint32_t unfold(uint32_t code, int bytes) {
    const uint32_t mask = (1u << 8 * bytes) - 1;
    return code & 1 ? mask - (code >> 1) : code >> 1;
}

static size_t plain_size(const struct hull *hull) {
    return VERTEX_BYTES * hull->vertex_count + TRIANGLE_BYTES * hull->triangle_count;
}

// Coordinate `a` of a vertex: of the position below 3, else of the normal.
static uint32_t coordinate(const struct hull *hull, size_t vertex, int a) {
    return a < 3 ? hull->vertices[vertex][a] : hull->normals[vertex][a - 3];
}

static void write_plain(const struct hull *hull, unsigned char *to) {
    const size_t n = hull->vertex_count, corners = 3 * hull->triangle_count;
    for (int a = 0; a < 5; a++) {
        const int bytes = a < 3 ? POSITION_BYTES : NORMAL_BYTES;
        for (size_t i = 0; i < n; i++) {
            uint32_t code = fold(coordinate(hull, i, a) - (i ? coordinate(hull, i - 1, a) : 0), bytes);
            for (int k = 0; k < bytes; k++) to[(size_t)k * n + i] = (unsigned char)(code >> 8 * k);
        }
        to += (size_t)bytes * n;
    }
    uint32_t next = 0; // vertices come in the order in which triangles use them, but for a stranger's hull
    for (size_t c = 0; c < corners; c++) {
        const uint32_t index = hull->triangles[c / 3][c % 3], back = next - index;
        if (index >= next) next = index + 1;
        to[c] = (unsigned char)back;
        to[corners + c] = (unsigned char)(back >> 8);
    }
}

static void read_plain(struct hull *hull, const unsigned char *from) {
    const size_t n = hull->vertex_count, corners = 3 * hull->triangle_count;
    for (int a = 0; a < 5; a++) {
        const int bytes = a < 3 ? POSITION_BYTES : NORMAL_BYTES;
        uint32_t value = 0;
        for (size_t i = 0; i < n; i++) {
            uint32_t code = 0;
            for (int k = 0; k < bytes; k++) code |= (uint32_t)from[(size_t)k * n + i] << 8 * k;
            value += unfold(code, bytes);
            if (a < 3)
                hull->vertices[i][a] = value & HULL_MAX_CODE;
            else
                hull->normals[i][a - 3] = value & HULL_MAX_NORMAL;
        }
        from += (size_t)bytes * n;
    }
    uint32_t next = 0;
    for (size_t c = 0; c < corners; c++) {
        const uint32_t index = (next - (from[c] | (uint32_t)from[corners + c] << 8)) & 0xffff;
        if (index >= next) next = index + 1;
        hull->triangles[c / 3][c % 3] = (uint16_t)index;
    }
}

static enum status out_of_memory(const struct hull *hull, struct error *error) {
    return error_set(error, STATUS_MEMORY, "out of memory for a hull of %zu triangles", hull->triangle_count);
}

enum status hull_pack(struct hull *hull, struct error *error) {
    const size_t size = plain_size(hull);
    uLongf count = compressBound((uLong)size);
    unsigned char *plain = malloc(size + 1), *stream = malloc(count);
    bool packed = plain && stream;
    if (packed) {
        write_plain(hull, plain);
        packed = compress2(stream, &count, plain, (uLong)size, Z_BEST_COMPRESSION) == Z_OK;
    }
    free(plain);
    free(hull->packed);
    hull->packed = packed ? realloc(stream, count) : NULL;
    hull->packed_bytes = hull->packed ? count : 0;
    if (!hull->packed) free(stream);
    return hull->packed ? STATUS_OK : out_of_memory(hull, error);
}

enum status hull_unpack(struct hull *hull, const void *bytes, size_t count, struct error *error) {
    const size_t size = plain_size(hull);
    uLongf found = (uLongf)size;
    unsigned char *plain = malloc(size + 1);
    free(hull->packed);
    hull->packed = malloc(count + 1);
    enum status status = STATUS_OK;
    if (!plain || !hull->packed)
        status = out_of_memory(hull, error);
    else {
        memcpy(hull->packed, bytes, count);
        hull->packed_bytes = count;
        const int result = uncompress(plain, &found, hull->packed, (uLong)count);
        if (result == Z_OK && found == size)
            read_plain(hull, plain);
        else
            status = result == Z_MEM_ERROR
                         ? out_of_memory(hull, error)
                         : error_set(error, STATUS_INVALID, "the hull's mesh is not a stream of its triangles");
    }
    free(plain);
    return status;
}
