// The unit disk in the xy plane, facing +z. uv: radius and azimuth / 2 pi, as in Mitsuba 3. Any affine to_world is
// allowed: a non-uniform one makes an ellipse.
#include "math/warp.h"
#include "scene/shape/shape_common.h"

struct disk {
    struct shape base;
    vec3 n, center, x, y; // in the world; x, y: the images of the unit vectors
    vec3 dual_x, dual_y; // dot products with p - center give the local coordinates
};

static const struct param disk_params[] = {PARAM_END};

static enum status disk_commit(struct shape *shape, struct commit_context *context, struct error *error) {
    struct disk *self = (struct disk *)shape;
    enum status status = shape_check_transform(shape, context, error);
    if (status != STATUS_OK) return status;
    const struct transform *t = &shape->to_world;
    self->center = transform_point(t, vec3_make(0, 0, 0));
    self->x = transform_vector(t, vec3_make(1, 0, 0));
    self->y = transform_vector(t, vec3_make(0, 1, 0));
    vec3 normal = vec3_cross(self->x, self->y);
    float area2 = vec3_dot(normal, normal);
    self->dual_x = vec3_scale(vec3_cross(self->y, normal), 1 / area2);
    self->dual_y = vec3_scale(vec3_cross(normal, self->x), 1 / area2);
    self->n = vec3_normalize(transform_normal(t, vec3_make(0, 0, 1)));
    if (shape->flip_normals) self->n = vec3_neg(self->n);
    shape->area = PI_F * sqrtf(area2);
    return STATUS_OK;
}

static void disk_bounds(const struct shape *shape, vec3 *lower, vec3 *upper) {
    const struct disk *self = (const struct disk *)shape;
    vec3 x = self->x, y = self->y;
    vec3 r = {sqrtf(x.x * x.x + y.x * y.x), sqrtf(x.y * x.y + y.y * y.y), sqrtf(x.z * x.z + y.z * y.z)};
    *lower = vec3_sub(self->center, r);
    *upper = vec3_add(self->center, r);
}

static double dot_double(vec3 a, double x, double y, double z) {
    return (double)a.x * x + (double)a.y * y + (double)a.z * z;
}

static bool disk_intersect(const struct shape *shape, const struct ray *ray, float *t, vec2 *uv) {
    const struct disk *self = (const struct disk *)shape;
    double x = (double)ray->origin.x - (double)self->center.x, y = (double)ray->origin.y - (double)self->center.y;
    double z = (double)ray->origin.z - (double)self->center.z;
    double height = dot_double(self->n, x, y, z), slope = (double)vec3_dot(self->n, ray->direction);
    if (slope == 0) return false;
    double hit = -height / slope;
    if (!(hit > (double)ray->t_min && hit <= (double)ray->t_max)) return false;
    x += hit * (double)ray->direction.x;
    y += hit * (double)ray->direction.y;
    z += hit * (double)ray->direction.z;
    vec2 local = {(float)dot_double(self->dual_x, x, y, z), (float)dot_double(self->dual_y, x, y, z)};
    if (local.x * local.x + local.y * local.y > 1) return false;
    *t = (float)hit;
    *uv = local;
    return true;
}

static void disk_fill(const struct shape *shape, vec2 local, struct surface *surface) {
    const struct disk *self = (const struct disk *)shape;
    double x = (double)local.x, y = (double)local.y;
    surface->p = (vec3){(float)((double)self->center.x + x * (double)self->x.x + y * (double)self->y.x),
                        (float)((double)self->center.y + x * (double)self->x.y + y * (double)self->y.y),
                        (float)((double)self->center.z + x * (double)self->x.z + y * (double)self->y.z)};
    float r = sqrtf(local.x * local.x + local.y * local.y), phi = atan2f(local.y, local.x);
    float c = r > 0 ? local.x / r : 1, s = r > 0 ? local.y / r : 0;
    surface->uv = (vec2){r, (phi < 0 ? phi + 2 * PI_F : phi) * 0.5f * INV_PI_F};
    surface->dp_du = vec3_add(vec3_scale(self->x, c), vec3_scale(self->y, s));
    surface->dp_dv = vec3_scale(vec3_sub(vec3_scale(self->y, local.x), vec3_scale(self->x, local.y)), 2 * PI_F);
    surface->ng = self->n;
    surface->shading = shape_frame(self->n, surface->dp_du);
}

static void disk_sample(const struct shape *shape, vec2 u, struct surface *surface) {
    disk_fill(shape, warp_concentric_disk(u), surface);
}

const struct shape_type shape_disk = {
    .name = "disk",
    .help = "the unit disk in the xy plane, facing +z",
    .params = disk_params,
    .size = sizeof(struct disk),
    .commit = disk_commit,
    .bounds = disk_bounds,
    .intersect = disk_intersect,
    .fill = disk_fill,
    .sample = disk_sample,
};
