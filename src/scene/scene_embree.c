// The only file that knows Embree (3.13). Meshes share their buffers with it; analytic shapes are user geometry with
// one primitive, intersected by their own functions. Kept geometry of a luminaire is left out for rays that ask so: by
// a filter function on its meshes and by a test in the callbacks of analytic shapes, exact for any number of
// luminaires.
#include "scene/scene_embree.h"

#include <embree3/rtcore.h>
#include <stdio.h>
#include <stdlib.h>

struct embree_scene {
    RTCDevice device;
    RTCScene scene, hulls; // hulls: NULL where no lamp shows one
    bool has_through;
};

struct ray_context { // the first member is what Embree hands to every callback
    struct RTCIntersectContext embree;
    int ignore_luminaire;
};

static int context_ignored(const struct RTCIntersectContext *context) {
    return ((const struct ray_context *)(const void *)context)->ignore_luminaire;
}

static void filter_luminaire(const struct RTCFilterFunctionNArguments *arguments) {
    const struct shape *shape = arguments->geometryUserPtr;
    if (shape->luminaire == context_ignored(arguments->context)) arguments->valid[0] = 0;
}

static void shape_bounds_callback(const struct RTCBoundsFunctionArguments *arguments) {
    const struct shape *shape = arguments->geometryUserPtr;
    vec3 lower, upper;
    shape->type->bounds(shape, &lower, &upper);
    float pad = 1e-5f * (vec3_length(vec3_sub(upper, lower)) + vec3_length(lower) + vec3_length(upper));
    *arguments->bounds_o = (struct RTCBounds){.lower_x = lower.x - pad,
                                              .lower_y = lower.y - pad,
                                              .lower_z = lower.z - pad,
                                              .upper_x = upper.x + pad,
                                              .upper_y = upper.y + pad,
                                              .upper_z = upper.z + pad};
}

static struct ray ray_from_embree(const struct RTCRay *ray) {
    return (struct ray){
        {ray->org_x, ray->org_y, ray->org_z}, {ray->dir_x, ray->dir_y, ray->dir_z}, ray->tnear, ray->tfar};
}

static void shape_intersect_callback(const struct RTCIntersectFunctionNArguments *arguments) {
    const struct shape *shape = arguments->geometryUserPtr;
    if (!arguments->valid[0]) return;
    if (shape->luminaire >= 0 && shape->luminaire == context_ignored(arguments->context)) return;
    struct RTCRayHit *hit = (struct RTCRayHit *)(void *)arguments->rayhit;
    struct ray ray = ray_from_embree(&hit->ray);
    float t;
    vec2 uv;
    if (!shape->type->intersect(shape, &ray, &t, &uv)) return;
    hit->ray.tfar = t;
    hit->hit.u = uv.x;
    hit->hit.v = uv.y;
    hit->hit.geomID = arguments->geomID;
    hit->hit.primID = arguments->primID;
}

static void shape_occluded_callback(const struct RTCOccludedFunctionNArguments *arguments) {
    const struct shape *shape = arguments->geometryUserPtr;
    if (!arguments->valid[0]) return;
    if (shape->luminaire >= 0 && shape->luminaire == context_ignored(arguments->context)) return;
    struct RTCRay *embree_ray = (struct RTCRay *)(void *)arguments->ray;
    struct ray ray = ray_from_embree(embree_ray);
    float t;
    vec2 uv;
    if (shape->type->intersect(shape, &ray, &t, &uv)) embree_ray->tfar = -INFINITY;
}

static void attach_shape(const struct embree_scene *embree, RTCScene scene, const struct shape *shape, unsigned index) {
    const struct mesh *mesh = &shape->mesh;
    bool is_mesh = mesh->triangle_count > 0;
    RTCGeometry geometry =
        rtcNewGeometry(embree->device, is_mesh ? RTC_GEOMETRY_TYPE_TRIANGLE : RTC_GEOMETRY_TYPE_USER);
    if (!geometry) return; // the device keeps the error
    rtcSetGeometryUserData(geometry, (void *)shape);
    if (is_mesh) {
        rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, mesh->positions, 0,
                                   sizeof(vec3), mesh->vertex_count);
        rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, mesh->indices, 0,
                                   3 * sizeof(uint32_t), mesh->triangle_count);
        if (shape->luminaire >= 0) {
            rtcSetGeometryIntersectFilterFunction(geometry, filter_luminaire);
            rtcSetGeometryOccludedFilterFunction(geometry, filter_luminaire);
        }
    } else {
        rtcSetGeometryUserPrimitiveCount(geometry, 1);
        rtcSetGeometryBoundsFunction(geometry, shape_bounds_callback, NULL);
        rtcSetGeometryIntersectFunction(geometry, shape_intersect_callback);
        rtcSetGeometryOccludedFunction(geometry, shape_occluded_callback);
    }
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(scene, geometry, index);
    rtcReleaseGeometry(geometry);
}

static RTCScene make_scene(const struct embree_scene *embree, struct shape *const *shapes, size_t count) {
    RTCScene scene = rtcNewScene(embree->device);
    if (!scene) return NULL;
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
    rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_HIGH); // 8 % faster rays on the demo room
    for (size_t i = 0; i < count; ++i) attach_shape(embree, scene, shapes[i], (unsigned)i);
    rtcCommitScene(scene);
    return scene;
}

static void keep_first_error(void *user, enum RTCError code, const char *text) {
    struct error *error = user;
    if (error->status != STATUS_OK) return;
    enum status status = code == RTC_ERROR_OUT_OF_MEMORY ? STATUS_MEMORY : STATUS_UNSUPPORTED;
    error_set(error, status, "ray casting failed: %s (Embree error %d)", text ? text : "no details", (int)code);
}

enum status embree_scene_create(struct embree_scene **result, const struct scene *scene, int threads,
                                struct error *error) {
    *result = NULL;
    struct embree_scene *embree = calloc(1, sizeof *embree);
    if (!embree) return error_set(error, STATUS_MEMORY, "out of memory for the ray casting structure");
    char config[64];
    snprintf(config, sizeof config, "threads=%d,set_affinity=0", threads > 0 ? threads : 1);
    struct error first = {0};
    embree->device = rtcNewDevice(config);
    if (!embree->device) {
        free(embree);
        return error_set(error, STATUS_UNSUPPORTED, "Embree cannot be started on this machine (error %d)",
                         (int)rtcGetDeviceError(NULL));
    }
    rtcSetDeviceErrorFunction(embree->device, keep_first_error, &first);
    embree->scene = make_scene(embree, scene->shapes, scene->shape_count);
    if (scene->hull_count) embree->hulls = make_scene(embree, scene->hulls, scene->hull_count);
    for (size_t i = 0; i < scene->shape_count; ++i) {
        const struct shape *shape = scene->shapes[i];
        embree->has_through = embree->has_through || (shape->bsdf && shape->bsdf->flags & BSDF_NULL);
    }
    rtcSetDeviceErrorFunction(embree->device, NULL, NULL);
    if (first.status != STATUS_OK) {
        embree_scene_destroy(embree);
        return error_set(error, first.status, "%s", first.text);
    }
    *result = embree;
    return STATUS_OK;
}

void embree_scene_destroy(struct embree_scene *embree) {
    if (!embree) return;
    if (embree->scene) rtcReleaseScene(embree->scene);
    if (embree->hulls) rtcReleaseScene(embree->hulls);
    if (embree->device) rtcReleaseDevice(embree->device);
    free(embree);
}

static struct ray_context context_make(int ignore_luminaire) {
    struct ray_context context;
    rtcInitIntersectContext(&context.embree);
    context.ignore_luminaire = ignore_luminaire;
    return context;
}

static struct RTCRay embree_from_ray(const struct ray *ray) {
    return (struct RTCRay){.org_x = ray->origin.x,
                           .org_y = ray->origin.y,
                           .org_z = ray->origin.z,
                           .tnear = ray->t_min,
                           .dir_x = ray->direction.x,
                           .dir_y = ray->direction.y,
                           .dir_z = ray->direction.z,
                           .tfar = ray->t_max,
                           .mask = 0xFFFFFFFFu};
}

static struct scene_hit trace_shapes(RTCScene scene, struct shape *const *shapes, const struct ray *ray,
                                     int ignore_luminaire) {
    struct ray_context context = context_make(ignore_luminaire);
    struct RTCRayHit hit = {.ray = embree_from_ray(ray)};
    hit.hit.geomID = hit.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(scene, &context.embree, &hit);
    if (hit.hit.geomID == RTC_INVALID_GEOMETRY_ID) return (struct scene_hit){0};
    return (struct scene_hit){shapes[hit.hit.geomID], hit.hit.primID, {hit.hit.u, hit.hit.v}, hit.ray.tfar};
}

struct scene_hit scene_trace(const struct scene *scene, const struct ray *ray, int ignore_luminaire) {
    return trace_shapes(scene->embree->scene, scene->shapes, ray, ignore_luminaire);
}

void scene_fill(const struct ray *ray, const struct scene_hit *hit, struct surface *surface) {
    if (hit->shape->mesh.triangle_count > 0) {
        shape_fill_triangle(hit->shape, hit->primitive, hit->uv, surface);
    } else {
        *surface = (struct surface){.shape = hit->shape, .p = vec3_mad(ray->direction, hit->t, ray->origin)};
        hit->shape->type->fill(hit->shape, hit->uv, surface);
    }
    surface->t = hit->t;
}

bool scene_intersect(const struct scene *scene, const struct ray *ray, int ignore_luminaire, struct surface *surface) {
    const struct scene_hit hit = scene_trace(scene, ray, ignore_luminaire);
    if (hit.shape) scene_fill(ray, &hit, surface);
    return hit.shape;
}

bool scene_intersect_hulls(const struct scene *scene, const struct ray *ray, int ignore_luminaire,
                           struct surface *surface) {
    if (!scene->embree->hulls) return false;
    const struct scene_hit hit = trace_shapes(scene->embree->hulls, scene->hulls, ray, ignore_luminaire);
    if (hit.shape) scene_fill(ray, &hit, surface);
    return hit.shape;
}

bool embree_scene_has_through(const struct embree_scene *embree) { return embree->has_through; }

bool embree_scene_occluded(const struct embree_scene *embree, const struct ray *ray, int ignore_luminaire) {
    struct ray_context context = context_make(ignore_luminaire);
    struct RTCRay embree_ray = embree_from_ray(ray);
    rtcOccluded1(embree->scene, &context.embree, &embree_ray);
    return embree_ray.tfar < 0;
}
