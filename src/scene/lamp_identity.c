// The identity of a lamp: what a checkpoint is refused by, and what the file remembers of its source.
#include "scene/lamp_identity.h"

#include <stdlib.h>

#include "base/file.h"
#include "base/hash.h"

enum status lamp_identity(const struct scene *scene, uint64_t *identity, struct error *error) {
    uint8_t *bytes;
    size_t length;
    enum status status = file_read(scene->path, &bytes, &length, error);
    if (status != STATUS_OK) return status;
    uint64_t hash = hash_bytes(HASH_START, bytes, length);
    free(bytes);
    for (size_t i = 0; i < scene->shape_count; i++) {
        const struct mesh *mesh = &scene->shapes[i]->mesh;
        hash = hash_bytes(hash, mesh->positions, mesh->vertex_count * sizeof *mesh->positions);
        hash = hash_bytes(hash, mesh->indices, 3 * mesh->triangle_count * sizeof *mesh->indices);
    }
    *identity = hash;
    return STATUS_OK;
}
