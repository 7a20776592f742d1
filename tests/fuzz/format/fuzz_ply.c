// PLY meshes from arbitrary bytes: an error or a mesh whose every index is in range.
#include <stdlib.h>
#include <string.h>

#include "format/mesh.h"

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t length);

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t length) {
    struct arena arena = {0};
    struct mesh mesh;
    struct error error;
    uint8_t *terminated = calloc(length + 1, 1);
    if (!terminated) return 0;
    if (length) memcpy(terminated, bytes, length);
    if (mesh_parse_ply(&mesh, &arena, "fuzz", terminated, length, &error) == STATUS_OK) {
        for (size_t i = 0; i < 3 * mesh.triangle_count; ++i) {
            if (!vec3_is_finite(mesh.positions[mesh.indices[i]])) abort();
        }
    }
    arena_fini(&arena);
    free(terminated);
    return 0;
}
