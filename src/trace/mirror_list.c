// Which shapes are plane mirrors: flat meshes whose BSDF is one delta reflection and whose normals are not bent.
#include "trace/mirror_list.h"

#include <stdlib.h>

enum { MIRRORS_MAX = 8 }; // more would make each too rare a choice
static const float flatness = 1e-4f; // of the mesh's extent
static const float least_cos = 0.99999f; // of a normal with the plane's

static bool shape_is_mirror(const struct shape *shape, struct mirror *mirror) {
    if (!shape->bsdf || shape->bsdf->flags != BSDF_DELTA || shape->luminaire >= 0 || !shape->mesh.triangle_count)
        return false;
    const struct mesh *mesh = &shape->mesh;
    const uint32_t *corners = mesh->indices;
    const vec3 a = mesh->positions[corners[0]];
    const vec3 n = vec3_cross(vec3_sub(mesh->positions[corners[1]], a), vec3_sub(mesh->positions[corners[2]], a));
    const float length = vec3_length(n);
    if (!(length > 0)) return false;
    *mirror = (struct mirror){shape, a, vec3_scale(n, 1 / length)};
    for (size_t i = 0; i < 3 * (size_t)mesh->triangle_count; i++) {
        const vec3 offset = vec3_sub(mesh->positions[corners[i]], a);
        if (fabsf(vec3_dot(offset, mirror->n)) > flatness * sqrtf(length)) return false;
    }
    return true;
}

enum status mirrors_find(struct mirror_list *list, const struct scene *scene, struct error *error) {
    *list = (struct mirror_list){.mirrors = calloc(MIRRORS_MAX, sizeof *list->mirrors)};
    if (!list->mirrors) return error_set(error, STATUS_MEMORY, "out of memory for the list of mirrors");
    for (size_t i = 0; i < scene->shape_count; i++) {
        struct mirror mirror;
        if (!shape_is_mirror(scene->shapes[i], &mirror)) continue;
        if (list->count == MIRRORS_MAX) {
            list->count = 0;
            break;
        }
        list->mirrors[list->count++] = mirror;
    }
    return STATUS_OK;
}

void mirrors_fini(struct mirror_list *list) { free(list->mirrors); }

const struct mirror *mirror_at(const struct mirror_list *list, const struct surface *surface) {
    for (size_t i = 0; i < list->count; i++)
        if (list->mirrors[i].shape == surface->shape)
            return fabsf(vec3_dot(list->mirrors[i].n, surface->shading.n)) > least_cos ? &list->mirrors[i] : NULL;
    return NULL;
}
