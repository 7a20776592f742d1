// The identity of a lamp: what a checkpoint is refused by, and what the file remembers of its source.
#include "scene/lamp_identity.h"

#include <stdlib.h>

#include "base/file.h"

static uint64_t hash_bytes(uint64_t hash, const void *bytes, size_t n) {
    const uint8_t *p = bytes;
    for (size_t i = 0; i < n; i++) hash = (hash ^ p[i]) * 0x100000001b3ull;
    return hash;
}

enum status lamp_identity(const struct scene *scene, uint64_t *identity, struct error *error) {
    uint8_t *bytes;
    size_t length;
    enum status status = file_read(scene->path, &bytes, &length, error);
    if (status != STATUS_OK) return status;
    uint64_t hash = hash_bytes(0xcbf29ce484222325ull, bytes, length);
    free(bytes);
    for (size_t i = 0; i < scene->shape_count; i++) {
        const struct mesh *mesh = &scene->shapes[i]->mesh;
        hash = hash_bytes(hash, mesh->positions, mesh->vertex_count * sizeof *mesh->positions);
        hash = hash_bytes(hash, mesh->indices, 3 * mesh->triangle_count * sizeof *mesh->indices);
    }
    *identity = hash;
    return STATUS_OK;
}
