// Triangle meshes from files: OBJ (through Assimp), PLY, Mitsuba's serialized (v3/v4, zlib). Plain arrays.
#pragma once

#include <stdint.h>

#include "base/arena.h"
#include "base/error.h"
#include "math/vec.h"

struct mesh {
    vec3 *positions; // vertex_count
    vec3 *normals; // vertex_count, unit, or NULL
    vec2 *uvs; // vertex_count, or NULL
    uint32_t *indices; // 3 * triangle_count
    size_t vertex_count, triangle_count;
};

// All arrays are allocated in `arena`. Errors name the file: unreadable, truncated, no triangles, NaN or infinite
// vertices, an index out of range, sizes that overflow. Winding is the file's.
// As in Mitsuba, a mesh without normals is smooth unless face normals are asked for: the caller then calls
// mesh_compute_normals. Texture coordinates are as Mitsuba delivers them: v of an OBJ file is flipped, others are not.
enum status mesh_load_obj(struct mesh *mesh, struct arena *arena, const char *path, struct error *error);
enum status mesh_load_ply(struct mesh *mesh, struct arena *arena, const char *path, struct error *error);
enum status mesh_load_serialized(struct mesh *mesh, struct arena *arena, const char *path, int shape_index,
                                 struct error *error);
enum status mesh_parse_serialized(struct mesh *mesh, struct arena *arena, const char *name, const uint8_t *bytes,
                                  size_t length, int shape_index, struct error *error); // for the fuzzer
// For the fuzzer; a zero byte must follow the length bytes, as file_read has it.
enum status mesh_parse_ply(struct mesh *mesh, struct arena *arena, const char *name, const uint8_t *bytes,
                           size_t length, struct error *error);

// Replaces mesh->normals by angle-weighted averages of the face normals.
enum status mesh_compute_normals(struct mesh *mesh, struct arena *arena, struct error *error);
// The last step of every loader: checks what the header of this file promises and normalises the normals.
enum status mesh_finish(struct mesh *mesh, struct arena *arena, const char *name, struct error *error);
