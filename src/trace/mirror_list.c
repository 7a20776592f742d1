// Which shapes are plane mirrors: flat meshes with a delta reflection whose normals are not bent.
#include "trace/mirror_list.h"

static const float flatness = 1e-4f; // of the mesh's extent
static const float least_cos = 0.99999f; // of a normal with the plane's

static bool bsdf_is_mirror(const struct bsdf *bsdf, enum mirror_kind kind) {
    if (kind == MIRROR_PURE) return bsdf->flags == BSDF_DELTA;
    return (bsdf->flags & BSDF_DELTA) && !(bsdf->flags & BSDF_NULL);
}

static void grow(struct mirror *mirror, vec3 p, float margin) {
    mirror->lower = (vec3){minf(mirror->lower.x, p.x - margin), minf(mirror->lower.y, p.y - margin),
                           minf(mirror->lower.z, p.z - margin)};
    mirror->upper = (vec3){maxf(mirror->upper.x, p.x + margin), maxf(mirror->upper.y, p.y + margin),
                           maxf(mirror->upper.z, p.z + margin)};
}

static bool shape_is_mirror(const struct shape *shape, enum mirror_kind kind, struct mirror *mirror) {
    if (!shape->bsdf || !bsdf_is_mirror(shape->bsdf, kind) || shape->luminaire >= 0 || !shape->mesh.triangle_count)
        return false;
    const struct mesh *mesh = &shape->mesh;
    const uint32_t *corners = mesh->indices;
    const vec3 a = mesh->positions[corners[0]];
    const vec3 n = vec3_cross(vec3_sub(mesh->positions[corners[1]], a), vec3_sub(mesh->positions[corners[2]], a));
    const float length = vec3_length(n);
    if (!(length > 0)) return false;
    *mirror = (struct mirror){shape, a, vec3_scale(n, 1 / length), a, a};
    for (size_t i = 0; i < 3 * (size_t)mesh->triangle_count; i++) {
        const vec3 p = mesh->positions[corners[i]];
        if (fabsf(vec3_dot(vec3_sub(p, a), mirror->n)) > flatness * sqrtf(length)) return false;
        grow(mirror, p, flatness * sqrtf(length));
    }
    return true;
}

void mirrors_find(struct mirror_list *list, const struct scene *scene, enum mirror_kind kind) {
    list->count = 0;
    for (size_t i = 0; i < scene->shape_count; i++) {
        struct mirror mirror;
        if (!shape_is_mirror(scene->shapes[i], kind, &mirror)) continue;
        size_t at = list->count;
        while (at > 0 && list->mirrors[at - 1].shape->area < mirror.shape->area) at--;
        if (at == MIRRORS_MAX) continue;
        if (list->count < MIRRORS_MAX) list->count++;
        for (size_t j = list->count - 1; j > at; j--) list->mirrors[j] = list->mirrors[j - 1];
        list->mirrors[at] = mirror;
    }
}

bool mirror_spans(const struct mirror *mirror, vec3 p) {
    return p.x >= mirror->lower.x && p.x <= mirror->upper.x && p.y >= mirror->lower.y && p.y <= mirror->upper.y &&
           p.z >= mirror->lower.z && p.z <= mirror->upper.z;
}

const struct mirror *mirror_at(const struct mirror_list *list, const struct surface *surface) {
    for (size_t i = 0; i < list->count; i++)
        if (list->mirrors[i].shape == surface->shape)
            return fabsf(vec3_dot(list->mirrors[i].n, surface->shading.n)) > least_cos ? &list->mirrors[i] : NULL;
    return NULL;
}
