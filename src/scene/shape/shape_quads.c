// The rectangle [-1,1]^2 facing +z and the cube [-1,1]^3, as flat-shaded meshes with Mitsuba 3's corner order and uvs.
#include "scene/shape/shape_common.h"

static const vec3 rectangle_corners[4] = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
static const vec3 cube_corners[24] = {
    {1, -1, -1}, {1, -1, 1},  {-1, -1, 1},  {-1, -1, -1}, // -y
    {1, 1, -1},  {-1, 1, -1}, {-1, 1, 1},   {1, 1, 1}, // +y
    {1, -1, -1}, {1, 1, -1},  {1, 1, 1},    {1, -1, 1}, // +x
    {1, -1, 1},  {1, 1, 1},   {-1, 1, 1},   {-1, -1, 1}, // +z
    {-1, -1, 1}, {-1, 1, 1},  {-1, 1, -1},  {-1, -1, -1}, // -x
    {1, 1, -1},  {1, -1, -1}, {-1, -1, -1}, {-1, 1, -1}, // -z
};
static const struct param quads_params[] = {PARAM_END};

static enum status rectangle_commit(struct shape *shape, struct commit_context *context, struct error *error) {
    return shape_finish_quads(shape, rectangle_corners, 1, context, error);
}

static const vec2 cube_uvs[4] = {{0, 1}, {1, 1}, {1, 0}, {0, 0}};

static enum status cube_commit(struct shape *shape, struct commit_context *context, struct error *error) {
    enum status status = shape_finish_quads(shape, cube_corners, 6, context, error);
    for (size_t i = 0; status == STATUS_OK && i < shape->mesh.vertex_count; ++i) shape->mesh.uvs[i] = cube_uvs[i % 4];
    return status;
}

const struct shape_type shape_rectangle = {
    .name = "rectangle",
    .help = "the square [-1,1]^2 in the xy plane, facing +z",
    .params = quads_params,
    .size = sizeof(struct shape),
    .commit = rectangle_commit,
};
const struct shape_type shape_cube = {
    .name = "cube",
    .help = "the cube [-1,1]^3",
    .params = quads_params,
    .size = sizeof(struct shape),
    .commit = cube_commit,
};
