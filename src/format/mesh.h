// Triangle meshes from files: OBJ and PLY (through Assimp), Mitsuba's serialized (v3/v4, zlib). Plain arrays.
#pragma once

#include <stdint.h>

#include "base/arena.h"
#include "base/error.h"
#include "math/vec.h"

struct mesh {
    vec3 *positions;  // vertex_count
    vec3 *normals;    // vertex_count, unit, or NULL
    vec2 *uvs;        // vertex_count, or NULL
    uint32_t *indices; // 3 * triangle_count
    size_t vertex_count, triangle_count;
};

// All arrays are allocated in `arena`. Errors name the file: unreadable, truncated, no triangles, NaN or infinite
// vertices, an index out of range, sizes that overflow. Winding and vertex order are the file's.
enum status mesh_load_obj(struct mesh *mesh, struct arena *arena, const char *path, struct error *error);
enum status mesh_load_ply(struct mesh *mesh, struct arena *arena, const char *path, struct error *error);
enum status mesh_load_serialized(struct mesh *mesh, struct arena *arena, const char *path, int shape_index, struct error *error);
enum status mesh_parse_serialized(struct mesh *mesh, struct arena *arena, const char *name, const uint8_t *bytes,
                                  size_t length, int shape_index, struct error *error); // for the fuzzer
