// Serialized meshes from arbitrary bytes: an error or a mesh whose every index is in range.
#include <stdlib.h>

#include "format/mesh.h"

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t length);

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t length) {
    struct arena arena = {0};
    struct mesh mesh;
    struct error error;
    if (mesh_parse_serialized(&mesh, &arena, "fuzz", bytes, length, 0, &error) == STATUS_OK) {
        for (size_t i = 0; i < 3 * mesh.triangle_count; ++i) {
            if (!vec3_is_finite(mesh.positions[mesh.indices[i]])) abort();
        }
        if (mesh_compute_normals(&mesh, &arena, &error) != STATUS_OK) abort();
    }
    arena_fini(&arena);
    return 0;
}
