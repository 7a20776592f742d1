// OBJ through Assimp, the only file that knows it. All meshes of a file are joined in order; polygons are cut into
// triangles; points and lines are dropped; materials are ignored (the scene file has its own). Normals and texture
// coordinates are kept where every mesh of the file has them.
//
// Checked against Mitsuba 3.9: it gives smooth, angle-weighted normals where the file has none (unless face_normals is
// set), and flips v (flip_tex_coords defaults to true).
//
// Assimp gives every corner of a face its own vertex. Corners with the same values are joined here, exactly, in the
// order of their first use. Deviation: Mitsuba joins by the file's indices, so where a file without normals repeats a
// position it has a crease, and ours is smooth.
#include "format/mesh.h"

#include <assimp/cimport.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"

static enum status memory_error(struct error *error, const char *path) {
    return error_set(error, STATUS_MEMORY, "%s: out of memory for the mesh", path);
}

static enum status count_elements(struct mesh *mesh, const struct aiScene *scene, const char *path,
                                  struct error *error) {
    for (unsigned m = 0; m < scene->mNumMeshes; ++m) {
        const struct aiMesh *part = scene->mMeshes[m];
        mesh->vertex_count += part->mNumVertices;
        for (unsigned f = 0; f < part->mNumFaces; ++f) mesh->triangle_count += part->mFaces[f].mNumIndices == 3;
    }
    if (mesh->vertex_count > UINT32_MAX)
        return error_set(error, STATUS_UNSUPPORTED, "%s: more than 2^32 vertices", path);
    return STATUS_OK;
}

static bool every_part_has(const struct aiScene *scene, bool normals) {
    for (unsigned m = 0; m < scene->mNumMeshes; ++m) {
        const struct aiMesh *part = scene->mMeshes[m];
        if (part->mNumVertices > 0 && !(normals ? (const void *)part->mNormals : (const void *)part->mTextureCoords[0]))
            return false;
    }
    return true;
}

static vec3 vec3_from_assimp(struct aiVector3D v) { return (vec3){v.x, v.y, v.z}; }

static enum status copy_scene(struct mesh *mesh, struct arena *arena, const struct aiScene *scene, const char *path,
                              struct error *error) {
    enum status status = count_elements(mesh, scene, path, error);
    if (status != STATUS_OK) return status;
    bool has_normals = every_part_has(scene, true), has_uvs = every_part_has(scene, false);
    mesh->positions = arena_alloc(arena, mesh->vertex_count, sizeof *mesh->positions);
    mesh->indices = arena_alloc(arena, mesh->triangle_count, 3 * sizeof *mesh->indices);
    if (has_normals) mesh->normals = arena_alloc(arena, mesh->vertex_count, sizeof *mesh->normals);
    if (has_uvs) mesh->uvs = arena_alloc(arena, mesh->vertex_count, sizeof *mesh->uvs);
    if (!mesh->positions || !mesh->indices || (has_normals && !mesh->normals) || (has_uvs && !mesh->uvs))
        return memory_error(error, path);
    size_t vertex = 0, index = 0;
    for (unsigned m = 0; m < scene->mNumMeshes; ++m) {
        const struct aiMesh *part = scene->mMeshes[m];
        for (unsigned f = 0; f < part->mNumFaces; ++f) {
            for (unsigned k = 0; k < 3 && part->mFaces[f].mNumIndices == 3; ++k) {
                mesh->indices[index++] = (uint32_t)vertex + part->mFaces[f].mIndices[k];
            }
        }
        for (unsigned v = 0; v < part->mNumVertices; ++v, ++vertex) {
            mesh->positions[vertex] = vec3_from_assimp(part->mVertices[v]);
            if (has_normals) mesh->normals[vertex] = vec3_from_assimp(part->mNormals[v]);
            if (!has_uvs) continue;
            struct aiVector3D uv = part->mTextureCoords[0][v];
            mesh->uvs[vertex] = (vec2){uv.x, 1 - uv.y};
        }
    }
    return STATUS_OK;
}

static uint64_t hash_bytes(uint64_t hash, const void *bytes, size_t length) { // FNV-1a
    for (size_t i = 0; i < length; ++i) hash = (hash ^ ((const uint8_t *)bytes)[i]) * 0x100000001B3ull;
    return hash;
}

static bool vertices_equal(const struct mesh *mesh, size_t a, size_t b) {
    return memcmp(&mesh->positions[a], &mesh->positions[b], sizeof(vec3)) == 0 &&
           (!mesh->normals || memcmp(&mesh->normals[a], &mesh->normals[b], sizeof(vec3)) == 0) &&
           (!mesh->uvs || memcmp(&mesh->uvs[a], &mesh->uvs[b], sizeof(vec2)) == 0);
}

// Joins equal vertices in place; the table holds vertex numbers + 1, probed linearly.
static enum status vertices_join(struct mesh *mesh, const char *path, struct error *error) {
    size_t slots = 16, kept = 0;
    while (slots < 2 * mesh->vertex_count) slots *= 2;
    uint32_t *table = calloc(slots, sizeof *table), *renumbered = calloc(mesh->vertex_count + 1, sizeof *renumbered);
    enum status status = table && renumbered ? STATUS_OK : memory_error(error, path);
    for (size_t v = 0; v < mesh->vertex_count && status == STATUS_OK; ++v) {
        uint64_t hash = hash_bytes(0xCBF29CE484222325ull, &mesh->positions[v], sizeof(vec3));
        if (mesh->normals) hash = hash_bytes(hash, &mesh->normals[v], sizeof(vec3));
        if (mesh->uvs) hash = hash_bytes(hash, &mesh->uvs[v], sizeof(vec2));
        size_t slot = (hash ^ hash >> 32) & (slots - 1);
        while (table[slot] && !vertices_equal(mesh, table[slot] - 1, v)) slot = (slot + 1) & (slots - 1);
        if (!table[slot]) {
            mesh->positions[kept] = mesh->positions[v];
            if (mesh->normals) mesh->normals[kept] = mesh->normals[v];
            if (mesh->uvs) mesh->uvs[kept] = mesh->uvs[v];
            table[slot] = (uint32_t)++kept;
        }
        renumbered[v] = table[slot] - 1;
    }
    for (size_t i = 0; i < 3 * mesh->triangle_count && status == STATUS_OK; ++i) {
        if (mesh->indices[i] < mesh->vertex_count) mesh->indices[i] = renumbered[mesh->indices[i]];
    }
    if (status == STATUS_OK) mesh->vertex_count = kept;
    free(table);
    free(renumbered);
    return status;
}

static enum status parse_obj(struct mesh *mesh, struct arena *arena, const char *path, const uint8_t *bytes,
                             size_t length, struct error *error) {
    *mesh = (struct mesh){0};
    if (length == 0 || length > UINT_MAX) {
        return error_set(error, STATUS_INVALID, "%s: %s", path, length ? "larger than 4 GiB" : "the file is empty");
    }
    const struct aiScene *scene =
        aiImportFileFromMemory((const char *)bytes, (unsigned)length, aiProcess_Triangulate, "obj");
    if (!scene) return error_set(error, STATUS_INVALID, "%s: cannot be read as OBJ: %s", path, aiGetErrorString());
    enum status status = copy_scene(mesh, arena, scene, path, error);
    aiReleaseImport(scene);
    if (status == STATUS_OK) status = vertices_join(mesh, path, error);
    return status == STATUS_OK ? mesh_finish(mesh, arena, path, error) : status;
}

enum status mesh_load_obj(struct mesh *mesh, struct arena *arena, const char *path, struct error *error) {
    uint8_t *bytes;
    size_t length;
    enum status status = file_read(path, &bytes, &length, error);
    if (status == STATUS_OK) status = parse_obj(mesh, arena, path, bytes, length, error);
    free(bytes);
    return status;
}
