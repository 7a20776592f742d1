// An open cylinder from p0 to p1, its outside away from the axis. uv: azimuth / 2 pi and the share of the way from p0
// to p1, as in Mitsuba 3.
#include "scene/shape/shape_common.h"

struct cylinder {
    struct shape base;
    vec3 p0, p1; // parameters, then in the world
    float radius;
    float length;
    struct frame axes; // n along the axis; left-handed where to_world mirrors
    bool inward;
};

static const struct param cylinder_params[] = {{.name = "p0",
                                                .type = PARAM_VEC3,
                                                .offset = offsetof(struct cylinder, p0),
                                                .fallback = "0 0 0",
                                                .help = "start of the axis, before to_world"},
                                               {.name = "p1",
                                                .type = PARAM_VEC3,
                                                .offset = offsetof(struct cylinder, p1),
                                                .fallback = "0 0 1",
                                                .help = "end of the axis, before to_world"},
                                               {.name = "radius",
                                                .type = PARAM_FLOAT,
                                                .offset = offsetof(struct cylinder, radius),
                                                .fallback = "1",
                                                .min = 1e-30,
                                                .max = 1e30,
                                                .help = "radius, before to_world"},

                                               PARAM_END};

static enum status cylinder_commit(struct shape *shape, struct commit_context *context, struct error *error) {
    struct cylinder *self = (struct cylinder *)shape;
    enum status status = shape_check_transform(shape, context, error);
    if (status != STATUS_OK) return status;
    vec3 axis = vec3_sub(self->p1, self->p0);
    if (!(vec3_length(axis) > 0))
        return error_at(error, context->object->place,
                        "p0 and p1 of this cylinder are the same point; move one of them");
    const struct transform *t = &shape->to_world;
    struct frame local = frame_from_normal(vec3_normalize(axis));
    vec3 s = transform_vector(t, local.s), up = transform_vector(t, local.t), n = transform_vector(t, axis);
    float scale = vec3_length(s), height = vec3_length(n);
    bool round = fabsf(vec3_length(up) - scale) <= 1e-4f * scale && fabsf(vec3_dot(s, up)) <= 1e-4f * scale * scale &&
                 fabsf(vec3_dot(s, n)) <= 1e-4f * scale * height && fabsf(vec3_dot(up, n)) <= 1e-4f * scale * height;
    if (!round)
        return error_at(
            error, context->object->place,
            "to_world of this cylinder shears it or scales it unevenly across its axis; use the same scale in "
            "both directions or a mesh (obj, ply)");
    self->p0 = transform_point(t, self->p0);
    self->p1 = transform_point(t, self->p1);
    self->radius *= scale;
    self->length = height;
    self->axes = (struct frame){vec3_scale(s, 1 / scale), vec3_scale(up, 1 / scale), vec3_scale(n, 1 / height)};
    self->inward = shape->flip_normals;
    shape->area = 2 * PI_F * self->radius * self->length;
    if (!(shape->area > 0) || !isfinite(shape->area))
        return error_at(error, context->object->place, "radius or length of this cylinder is out of range");
    return STATUS_OK;
}

static void cylinder_bounds(const struct shape *shape, vec3 *lower, vec3 *upper) {
    const struct cylinder *self = (const struct cylinder *)shape;
    vec3 n = self->axes.n;
    vec3 r = {self->radius * sqrtf(fmaxf(0, 1 - n.x * n.x)), self->radius * sqrtf(fmaxf(0, 1 - n.y * n.y)),
              self->radius * sqrtf(fmaxf(0, 1 - n.z * n.z))};
    vec3 a = self->p0, b = self->p1;
    *lower = vec3_sub((vec3){fminf(a.x, b.x), fminf(a.y, b.y), fminf(a.z, b.z)}, r);
    *upper = vec3_add((vec3){fmaxf(a.x, b.x), fmaxf(a.y, b.y), fmaxf(a.z, b.z)}, r);
}

struct vec3d {
    double x, y, z;
};

static struct vec3d local_double(const struct frame *f, double x, double y, double z) {
    return (struct vec3d){(double)f->s.x * x + (double)f->s.y * y + (double)f->s.z * z,
                          (double)f->t.x * x + (double)f->t.y * y + (double)f->t.z * z,
                          (double)f->n.x * x + (double)f->n.y * y + (double)f->n.z * z};
}

static bool cylinder_intersect(const struct shape *shape, const struct ray *ray, float *t, vec2 *uv) {
    const struct cylinder *self = (const struct cylinder *)shape;
    struct vec3d o =
        local_double(&self->axes, (double)ray->origin.x - (double)self->p0.x,
                     (double)ray->origin.y - (double)self->p0.y, (double)ray->origin.z - (double)self->p0.z);
    struct vec3d d =
        local_double(&self->axes, (double)ray->direction.x, (double)ray->direction.y, (double)ray->direction.z);
    double a = d.x * d.x + d.y * d.y, r = (double)self->radius;
    if (!(a > 0)) return false;
    double middle = -(o.x * d.x + o.y * d.y) / a, x = o.x + middle * d.x, y = o.y + middle * d.y;
    double h2 = (r * r - x * x - y * y) / a;
    if (h2 < 0) return false;
    double h = sqrt(h2);
    for (int side = -1; side <= 1; side += 2) {
        double hit = middle + side * h, z = o.z + hit * d.z;
        if (hit > (double)ray->t_min && hit <= (double)ray->t_max && z >= 0 && z <= (double)self->length) {
            *t = (float)hit;
            *uv = (vec2){(float)atan2(o.y + hit * d.y, o.x + hit * d.x), (float)z};
            return true;
        }
    }
    return false;
}

static void cylinder_fill(const struct shape *shape, vec2 at, struct surface *surface) { // at: azimuth, height
    const struct cylinder *self = (const struct cylinder *)shape;
    float phi = at.x < 0 ? at.x + 2 * PI_F : at.x;
    double c = cos((double)at.x), s = sin((double)at.x), r = (double)self->radius, z = (double)at.y;
    const struct frame *f = &self->axes;
    surface->p =
        (vec3){(float)((double)self->p0.x + r * (c * (double)f->s.x + s * (double)f->t.x) + z * (double)f->n.x),
               (float)((double)self->p0.y + r * (c * (double)f->s.y + s * (double)f->t.y) + z * (double)f->n.y),
               (float)((double)self->p0.z + r * (c * (double)f->s.z + s * (double)f->t.z) + z * (double)f->n.z)};
    vec3 out = frame_world_from_local(f, vec3_make((float)c, (float)s, 0));
    vec3 around = frame_world_from_local(f, vec3_make((float)-s, (float)c, 0));
    surface->uv = (vec2){phi * 0.5f * INV_PI_F, at.y / self->length};
    surface->dp_du = vec3_scale(around, 2 * PI_F * self->radius);
    surface->dp_dv = vec3_scale(f->n, self->length);
    surface->ng = self->inward ? vec3_neg(out) : out;
    surface->shading = shape_frame(surface->ng, surface->dp_du);
}

static void cylinder_sample(const struct shape *shape, vec2 u, struct surface *surface) {
    const struct cylinder *self = (const struct cylinder *)shape;
    cylinder_fill(shape, (vec2){2 * PI_F * u.x, u.y * self->length}, surface);
}

const struct shape_type shape_cylinder = {
    .name = "cylinder",
    .help = "an open cylinder from p0 to p1",
    .params = cylinder_params,
    .size = sizeof(struct cylinder),
    .commit = cylinder_commit,
    .bounds = cylinder_bounds,
    .intersect = cylinder_intersect,
    .fill = cylinder_fill,
    .sample = cylinder_sample,
};
