// Shapes from mesh files: obj, ply, serialized. Paths are relative to the scene file.
#include <string.h>

#include "base/file.h"
#include "scene/shape/shape_common.h"

struct mesh_shape {
    struct shape base;
    const char *filename;
    int shape_index;
    bool flip_tex_coords;
};

#define MESH_FILENAME_PARAM                                                                                            \
    {                                                                                                                  \
        .name = "filename", .type = PARAM_STRING, .offset = offsetof(struct mesh_shape, filename),                     \
        .help = "the mesh, relative to the scene file"                                                                 \
    }

#define MESH_FLIP_PARAM(by_default)                                                                                    \
    {                                                                                                                  \
        .name = "flip_tex_coords", .type = PARAM_BOOL, .offset = offsetof(struct mesh_shape, flip_tex_coords),         \
        .fallback = by_default, .help = "v of the texture coordinates counts from the other end"                       \
    }

static const struct param obj_params[] = {MESH_FILENAME_PARAM, MESH_FLIP_PARAM("true"), PARAM_END};
static const struct param ply_params[] = {MESH_FILENAME_PARAM, MESH_FLIP_PARAM("false"), PARAM_END};
static const struct param serialized_params[] = {MESH_FILENAME_PARAM,
                                                 {.name = "shape_index",
                                                  .type = PARAM_INT,
                                                  .offset = offsetof(struct mesh_shape, shape_index),
                                                  .fallback = "0",
                                                  .min = 0,
                                                  .max = 1e9,
                                                  .help = "which of the file's meshes, from 0"},
                                                 MESH_FLIP_PARAM("false"),
                                                 PARAM_END};

extern const struct shape_type shape_obj;

static enum status mesh_shape_commit(struct shape *shape, struct commit_context *context, struct error *error) {
    struct mesh_shape *self = (struct mesh_shape *)shape;
    enum status status = shape_check_transform(shape, context, error);
    if (status != STATUS_OK) return status;
    char path[4096];
    path_resolve(path, sizeof path, context->object->place.file, self->filename);
    struct error inner = {0};
    if (strcmp(shape->type->name, "obj") == 0) {
        status = mesh_load_obj(&shape->mesh, context->arena, path, &inner);
    } else if (strcmp(shape->type->name, "ply") == 0) {
        status = mesh_load_ply(&shape->mesh, context->arena, path, &inner);
    } else {
        status = mesh_load_serialized(&shape->mesh, context->arena, path, self->shape_index, &inner);
    }
    if (status != STATUS_OK) {
        error_at(error, context->object->place, "%s", inner.text);
        if (error) error->status = status;
        return status;
    }
    // The OBJ reader has flipped v already.
    bool flip = self->flip_tex_coords != (shape->type == &shape_obj);
    for (size_t v = 0; flip && shape->mesh.uvs && v < shape->mesh.vertex_count; v++)
        shape->mesh.uvs[v].y = 1 - shape->mesh.uvs[v].y;
    return shape_finish_mesh(shape, context, error);
}

const struct shape_type shape_obj = {
    .name = "obj",
    .help = "a triangle mesh from a Wavefront OBJ file",
    .params = obj_params,
    .size = sizeof(struct mesh_shape),
    .commit = mesh_shape_commit,
};
const struct shape_type shape_ply = {
    .name = "ply",
    .help = "a triangle mesh from a PLY file (ASCII or binary)",
    .params = ply_params,
    .size = sizeof(struct mesh_shape),
    .commit = mesh_shape_commit,
};
const struct shape_type shape_serialized = {
    .name = "serialized",
    .help = "a triangle mesh from Mitsuba's serialized format",
    .params = serialized_params,
    .size = sizeof(struct mesh_shape),
    .commit = mesh_shape_commit,
};
