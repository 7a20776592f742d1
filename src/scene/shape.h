// Surfaces. shape_table lists every type. A shape is a triangle mesh, or one analytic surface, in world space.
#pragma once

#include "base/param.h"
#include "format/mesh.h"
#include "scene/bsdf.h"
#include "scene/commit.h"

struct ray {
    vec3 origin, direction; // direction is unit
    float t_min, t_max;
};

struct surface { // a point on a shape, complete for shading
    float t;
    vec3 p;
    vec3 ng; // unit geometric normal, on the same side as shading.n ("outside")
    struct frame shading; // shading.s follows dp/du where there are uvs
    vec2 uv;
    vec3 dp_du, dp_dv; // zero where there are no uvs
    const struct shape *shape;
    uint32_t primitive; // triangle index in the mesh; 0 otherwise
};

struct shape {
    const struct shape_type *type;
    const char *id; // or ""
    struct place place;
    const struct bsdf *bsdf;
    const struct emitter *emitter; // area emitter or NULL
    bool has_interior;
    rgb sigma_a; // absorption inside [1/length], of a homogeneous interior medium
    int luminaire; // index of the baked luminaire instance whose kept geometry this is, or -1
    const struct hull_part *hull; // NULL: a real surface; else this is a part of a baked lamp's hull
    uint32_t index; // in scene->shapes, or scene->hulls
    struct transform to_world;
    bool flip_normals, face_normals;
    struct mesh mesh; // world space; triangle_count == 0: analytic
    float area; // [length^2]
    struct distribution *triangles; // by area; NULL until somebody samples it (scene_commit builds it for emitters)
};

struct shape_type {
    const char *name, *help;
    const struct param *params;
    size_t size; // of the plugin's struct, which begins with struct shape
    // Loads or builds: a mesh in world space, or the analytic data; sets area.
    enum status (*commit)(struct shape *shape, struct commit_context *context, struct error *error);
    // Analytic shapes only (NULL for meshes):
    void (*bounds)(const struct shape *shape, vec3 *lower, vec3 *upper);
    bool (*intersect)(const struct shape *shape, const struct ray *ray, float *t,
                      vec2 *uv); // nearest in [t_min, t_max]
    void (*fill)(const struct shape *shape, vec2 uv, struct surface *surface); // from p (refined on the surface) and uv
    void (*sample)(const struct shape *shape, vec2 u, struct surface *surface); // uniform by area
};
extern const struct shape_type *const shape_table[]; // ends with NULL

// A point uniform by area: p, ng, shading, uv, shape, primitive are filled. pdf_area = 1 / shape->area.
void shape_sample(const struct shape *shape, vec2 u, struct surface *surface);
// Fills a mesh hit from its triangle and barycentrics.
void shape_fill_triangle(const struct shape *shape, uint32_t primitive, vec2 barycentric, struct surface *surface);
// Before that, with time for the memory in between: asks for the triangle's indices, then for its vertices.
void shape_fetch_triangle(const struct shape *shape, uint32_t primitive);
void shape_fetch_vertices(const struct shape *shape, uint32_t primitive);
