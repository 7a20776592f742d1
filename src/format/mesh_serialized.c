// Mitsuba's serialized meshes, versions 3 and 4 (Mitsuba 0.5 documentation, "Serialized mesh loader"), little-endian:
//   shape:      u16 0x041C, u16 version, then a zlib stream of
//               u32 flags, name (version 4: UTF-8, ends with 0), u64 vertices, u64 triangles,
//               positions, [normals], [texture coordinates], [colours] as float or double, u32 indices
//   dictionary: the offset of every shape (u32 in version 3, u64 in version 4), u32 number of shapes; ends the file
// The flag 0x10, face normals, is ignored as Mitsuba 3.9 does (checked): the shape's own face_normals decides. Neither
// flips the texture coordinates.
// Sizes in the file are believed only as far as the decompressed bytes reach, so a small file cannot claim much memory.
#include "format/mesh.h"

#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

#include "base/file.h"

enum {
    MAGIC = 0x041C,
    HAS_NORMALS = 0x1,
    HAS_UVS = 0x2,
    HAS_COLORS = 0x8,
    DOUBLE_PRECISION = 0x2000,
};

struct cursor { // unread bytes
    const uint8_t *bytes;
    size_t length;
};

static uint64_t little_endian(const uint8_t *bytes, int size) {
    uint64_t value = 0;
    for (int i = size - 1; i >= 0; --i) value = value << 8 | bytes[i];
    return value;
}

static bool cursor_take(struct cursor *cursor, size_t size, const uint8_t **bytes) {
    if (size > cursor->length) return false;
    *bytes = cursor->bytes;
    cursor->bytes += size;
    cursor->length -= size;
    return true;
}

// The bytes of one shape, between its offset and the next shape's or the dictionary's.
static enum status find_shape(struct cursor *shape, int *version, const char *name, const uint8_t *bytes, size_t length,
                              int shape_index, struct error *error) {
    if (length < 8 || little_endian(bytes, 2) != MAGIC) {
        return error_set(error, STATUS_INVALID, "%s: not a serialized mesh file", name);
    }
    *version = (int)little_endian(bytes + 2, 2);
    if (*version != 3 && *version != 4) {
        return error_set(error, STATUS_UNSUPPORTED,
                         "%s: version %d of the serialized format; versions 3 and 4 can be read", name, *version);
    }
    size_t entry = *version == 3 ? 4 : 8, count = little_endian(bytes + length - 4, 4);
    if (count == 0 || count > (length - 8) / entry) {
        return error_set(error, STATUS_INVALID, "%s: the dictionary at its end is damaged; the file may be truncated",
                         name);
    }
    if (shape_index < 0 || (size_t)shape_index >= count) {
        return error_set(error, STATUS_INVALID, "%s: has no shape %d; it holds %zu, counted from 0", name, shape_index,
                         count);
    }
    size_t dictionary = length - 4 - count * entry;
    const uint8_t *place = bytes + dictionary + (size_t)shape_index * entry;
    uint64_t start = little_endian(place, (int)entry);
    uint64_t end = (size_t)shape_index + 1 < count ? little_endian(place + entry, (int)entry) : dictionary;
    if (end > dictionary || start > end || end - start < 4 || little_endian(bytes + start, 2) != MAGIC) {
        return error_set(error, STATUS_INVALID, "%s: the dictionary's entry %d is damaged; the file may be truncated",
                         name, shape_index);
    }
    *shape = (struct cursor){bytes + start + 4, end - start - 4};
    return STATUS_OK;
}

// Inflates all of a zlib stream into memory that grows with it. The caller frees *result.
static enum status inflate_all(struct cursor packed, const char *name, uint8_t **result, size_t *result_length,
                               struct error *error) {
    z_stream stream = {0};
    size_t capacity = 0, used = 0;
    uint8_t *buffer = NULL;
    if (inflateInit(&stream) != Z_OK) return error_set(error, STATUS_MEMORY, "%s: out of memory", name);
    int code = Z_OK;
    while (code == Z_OK) {
        if (used == capacity) {
            capacity = capacity ? 2 * capacity : 65536;
            uint8_t *larger = capacity <= SIZE_MAX / 4 ? realloc(buffer, capacity) : NULL;
            if (!larger) {
                code = Z_MEM_ERROR;
                break;
            }
            buffer = larger;
        }
        if (stream.avail_in == 0) {
            stream.next_in = (Bytef *)packed.bytes;
            stream.avail_in = packed.length < UINT_MAX ? (uInt)packed.length : UINT_MAX;
            packed.bytes += stream.avail_in;
            packed.length -= stream.avail_in;
        }
        uInt room = capacity - used < UINT_MAX ? (uInt)(capacity - used) : UINT_MAX;
        stream.next_out = buffer + used;
        stream.avail_out = room;
        code = inflate(&stream, Z_NO_FLUSH); // Z_BUF_ERROR at the end of a truncated stream
        used += room - stream.avail_out;
    }
    inflateEnd(&stream);
    if (code == Z_STREAM_END) {
        *result = buffer;
        *result_length = used;
        return STATUS_OK;
    }
    free(buffer);
    if (code == Z_MEM_ERROR) return error_set(error, STATUS_MEMORY, "%s: out of memory after %zu bytes", name, used);
    return error_set(error, STATUS_INVALID, "%s: the compressed mesh is damaged or truncated after %zu bytes", name,
                     used);
}

// count * components numbers, float or double, as floats in the arena; NULL where the bytes or the memory end.
static float *take_numbers(struct cursor *cursor, struct arena *arena, size_t count, size_t components, bool wide) {
    size_t size = wide ? sizeof(double) : sizeof(float);
    const uint8_t *bytes;
    if (count > cursor->length / (components * size) || !cursor_take(cursor, count * components * size, &bytes))
        return NULL;
    float *numbers = arena_alloc(arena, count, components * sizeof *numbers);
    for (size_t i = 0; numbers && i < count * components; ++i) {
        if (wide) {
            double value;
            memcpy(&value, bytes + i * size, size);
            numbers[i] = (float)value;
        } else {
            memcpy(&numbers[i], bytes + i * size, size);
        }
    }
    return numbers;
}

static enum status parse_shape(struct mesh *mesh, struct arena *arena, const char *name, struct cursor cursor,
                               int version, struct error *error) {
    const uint8_t *bytes;
    enum status truncated =
        error_set(error, STATUS_INVALID, "%s: the mesh holds fewer numbers than it announces", name);
    if (!cursor_take(&cursor, 4, &bytes)) return truncated;
    uint32_t flags = (uint32_t)little_endian(bytes, 4);
    if (version == 4) {
        const uint8_t *end = memchr(cursor.bytes, 0, cursor.length);
        if (!end || !cursor_take(&cursor, (size_t)(end - cursor.bytes) + 1, &bytes)) return truncated;
    }
    if (!cursor_take(&cursor, 16, &bytes)) return truncated;
    uint64_t vertices = little_endian(bytes, 8), triangles = little_endian(bytes + 8, 8);
    if (vertices > UINT32_MAX) {
        return error_set(error, STATUS_INVALID, "%s: announces %llu vertices; at most 2^32 are possible", name,
                         (unsigned long long)vertices);
    }
    bool wide = flags & DOUBLE_PRECISION;
    mesh->vertex_count = vertices;
    mesh->positions = (vec3 *)take_numbers(&cursor, arena, vertices, 3, wide);
    if (!mesh->positions) return truncated;
    if (flags & HAS_NORMALS && !(mesh->normals = (vec3 *)take_numbers(&cursor, arena, vertices, 3, wide)))
        return truncated;
    if (flags & HAS_UVS && !(mesh->uvs = (vec2 *)take_numbers(&cursor, arena, vertices, 2, wide))) return truncated;
    if (flags & HAS_COLORS && !cursor_take(&cursor, vertices * 3 * (wide ? 8 : 4), &bytes)) return truncated;
    if (triangles > cursor.length / 12 || !cursor_take(&cursor, triangles * 12, &bytes)) return truncated;
    mesh->indices = arena_alloc(arena, triangles, 3 * sizeof *mesh->indices);
    if (!mesh->indices)
        return error_set(error, STATUS_MEMORY, "%s: out of memory for %llu triangles", name,
                         (unsigned long long)triangles);
    mesh->triangle_count = triangles;
    for (size_t i = 0; i < 3 * triangles; ++i) mesh->indices[i] = (uint32_t)little_endian(bytes + 4 * i, 4);
    return mesh_finish(mesh, arena, name, error);
}

enum status mesh_parse_serialized(struct mesh *mesh, struct arena *arena, const char *name, const uint8_t *bytes,
                                  size_t length, int shape_index, struct error *error) {
    *mesh = (struct mesh){0};
    struct cursor packed = {0}, shape = {0};
    int version = 0;
    enum status status = find_shape(&packed, &version, name, bytes, length, shape_index, error);
    if (status != STATUS_OK) return status;
    uint8_t *inflated = NULL;
    status = inflate_all(packed, name, &inflated, &shape.length, error);
    shape.bytes = inflated;
    if (status == STATUS_OK) status = parse_shape(mesh, arena, name, shape, version, error);
    free(inflated);
    return status;
}

enum status mesh_load_serialized(struct mesh *mesh, struct arena *arena, const char *path, int shape_index,
                                 struct error *error) {
    uint8_t *bytes;
    size_t length;
    enum status status = file_read(path, &bytes, &length, error);
    if (status == STATUS_OK) status = mesh_parse_serialized(mesh, arena, path, bytes, length, shape_index, error);
    free(bytes);
    return status;
}
