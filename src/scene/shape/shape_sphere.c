// A sphere, intersected in double precision: the quadratic is formed about the ray's point nearest the centre, so that
// small spheres far away keep their shape (Haines et al. 2019, Ray Tracing Gems ch. 7). uv: azimuth about the local z
// axis and angle from +z, each over [0,1], as in Mitsuba 3.
#include "math/warp.h"
#include "scene/shape/shape_common.h"
#include "scene/shape/sphere.h"

static const struct param sphere_params[] = {{.name = "center",
                                              .type = PARAM_VEC3,
                                              .offset = offsetof(struct sphere, center),
                                              .fallback = "0 0 0",
                                              .help = "centre, before to_world"},
                                             {.name = "radius",
                                              .type = PARAM_FLOAT,
                                              .offset = offsetof(struct sphere, radius),
                                              .fallback = "1",
                                              .min = 1e-30,
                                              .max = 1e30,
                                              .help = "radius, before to_world"},

                                             PARAM_END};

static enum status sphere_commit(struct shape *shape, struct commit_context *context, struct error *error) {
    struct sphere *self = (struct sphere *)shape;
    enum status status = shape_check_transform(shape, context, error);
    if (status != STATUS_OK) return status;
    float scale = shape_similarity_scale(&shape->to_world);
    if (!(scale > 0))
        return error_at(
            error, context->object->place,
            "to_world of this sphere is not a rotation with uniform scale and would make an ellipsoid; use a mesh "
            "for it (obj, ply) or the same scale on x, y and z");
    struct transform place = transform_translate(self->center);
    struct transform size = transform_scale(vec3_make(self->radius, self->radius, self->radius));
    self->object = transform_multiply(&place, &size);
    self->object = transform_multiply(&shape->to_world, &self->object);
    self->from_world = transform_inverse(&self->object);
    self->center = transform_point(&shape->to_world, self->center);
    self->radius *= scale;
    self->inward = shape->flip_normals != transform_flips_handedness(&shape->to_world);
    shape->area = 4 * PI_F * sqrf(self->radius);
    if (!isfinite(shape->area) || !(shape->area > 0) || !vec3_is_finite(self->center))
        return error_at(error, context->object->place, "radius %g of this sphere is out of range",
                        (double)self->radius);
    return STATUS_OK;
}

static void sphere_bounds(const struct shape *shape, vec3 *lower, vec3 *upper) {
    const struct sphere *self = (const struct sphere *)shape;
    vec3 r = {self->radius, self->radius, self->radius};
    *lower = vec3_sub(self->center, r);
    *upper = vec3_add(self->center, r);
}

static bool sphere_intersect(const struct shape *shape, const struct ray *ray, float *t, vec2 *uv) {
    const struct sphere *self = (const struct sphere *)shape;
    double o[3] = {(double)ray->origin.x - (double)self->center.x, (double)ray->origin.y - (double)self->center.y,
                   (double)ray->origin.z - (double)self->center.z};
    double d[3] = {(double)ray->direction.x, (double)ray->direction.y, (double)ray->direction.z};
    double a = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
    double middle = -(o[0] * d[0] + o[1] * d[1] + o[2] * d[2]) / a; // t of the point nearest the centre
    double gap = 0, distance2 = 0; // squared distances of that point and of the origin
    for (int k = 0; k < 3; ++k) {
        double x = o[k] + middle * d[k];
        gap += x * x;
        distance2 += o[k] * o[k];
    }
    double r = (double)self->radius, h2 = (r * r - gap) / a;
    if (h2 < 0) return false;
    double far_root = middle + copysign(sqrt(h2), middle); // the root of larger magnitude; the other by their product
    double near_root = far_root != 0 ? (distance2 - r * r) / (a * far_root) : 0;
    bool near_first = near_root < far_root;
    double first = near_first ? near_root : far_root, second = near_first ? far_root : near_root;
    double lower = (double)ray->t_min, upper = (double)ray->t_max;
    double hit = first > lower && first <= upper ? first : second;
    if (!(hit > lower && hit <= upper)) return false;
    *t = (float)hit;
    *uv = (vec2){0, 0};
    return true;
}

// atan2(y, x) in turns, for the uvs: the series after two halvings of the range, right to 1e-7.
static float turns(float y, float x) {
    float a = fabsf(x), b = fabsf(y);
    float small = a < b ? a : b, large = a < b ? b : a;
    if (large == 0) return 0;
    bool tilted = small > 0.41421356f * large; // then the angle beyond an eighth of a half turn
    float t = tilted ? (small - large) / (small + large) : small / large, q = t * t, sum = 0;
    for (int k = 15; k > 0; k -= 2) sum = 1.0f / (float)k - q * sum;
    float angle = t * sum * (0.5f * INV_PI_F) + (tilted ? 0.125f : 0);
    if (a < b) angle = 0.25f - angle;
    if (x < 0) angle = 0.5f - angle;
    return y < 0 ? -angle : angle;
}

static void sphere_fill(const struct shape *shape, vec2 uv, struct surface *surface) {
    (void)uv;
    const struct sphere *self = (const struct sphere *)shape;
    double c[3] = {(double)self->center.x, (double)self->center.y, (double)self->center.z};
    double x[3] = {(double)surface->p.x - c[0], (double)surface->p.y - c[1], (double)surface->p.z - c[2]};
    double length = sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]);
    double inverse = length > 0 ? 1 / length : 0, r = (double)self->radius;
    vec3 n = length > 0 ? (vec3){(float)(x[0] * inverse), (float)(x[1] * inverse), (float)(x[2] * inverse)}
                        : vec3_make(0, 0, 1);
    surface->p = (vec3){(float)(c[0] + x[0] * inverse * r), (float)(c[1] + x[1] * inverse * r),
                        (float)(c[2] + x[2] * inverse * r)};
    vec3 local = vec3_scale(transform_vector(&self->from_world, n), self->radius);
    float rim = sqrtf(local.x * local.x + local.y * local.y), around_z = turns(local.y, local.x);
    surface->uv = (vec2){around_z < 0 ? around_z + 1 : around_z, 2 * turns(rim, local.z)};
    vec2 around = rim > 1e-6f ? (vec2){local.x / rim, local.y / rim} : (vec2){1, 0};
    surface->dp_du = transform_vector(&self->object, vec3_make(-local.y * 2 * PI_F, local.x * 2 * PI_F, 0));
    surface->dp_dv =
        transform_vector(&self->object, vec3_make(local.z * around.x * PI_F, local.z * around.y * PI_F, -rim * PI_F));
    surface->ng = self->inward ? vec3_neg(n) : n;
    surface->shading = shape_frame(surface->ng, surface->dp_du);
}

static void sphere_sample(const struct shape *shape, vec2 u, struct surface *surface) {
    const struct sphere *self = (const struct sphere *)shape;
    surface->p = vec3_mad(warp_uniform_sphere(u), self->radius, self->center);
    sphere_fill(shape, u, surface);
}

const struct shape_type shape_sphere = {
    .name = "sphere",
    .help = "a sphere",
    .params = sphere_params,
    .size = sizeof(struct sphere),
    .commit = sphere_commit,
    .bounds = sphere_bounds,
    .intersect = sphere_intersect,
    .fill = sphere_fill,
    .sample = sphere_sample,
};
