// Path tracer: the light samples by way of mirrors, and what scattering that finds such a lamp has to know of them.
#include "trace/path_state.h"

static float choice_pmf(const struct path_tracer *tracer) {
    return 1 / ((float)tracer->mirrors.count * (float)tracer->scene->luminaire_count);
}

bool path_samples_mirrors(const struct path_tracer *tracer, const struct path *path) {
    const int most = tracer->scene->max_depth;
    return tracer->mirrors.count && path->depth > 0 && !path->may_be_caustic && path->vertex.live < 0 &&
           path->vertex.kept < 0 && (most < 0 || path->depth + 2 < most);
}

void path_mirror_scatter(const struct path_tracer *tracer, struct path *path, const struct bsdf_sample *sample) {
    const struct mirror *mirror = NULL;
    if (sample->delta && path->pdf > 0 && path->samples_mirrors && !path->passed && !path->dimmed)
        mirror = mirror_at(&tracer->mirrors, &path->surface);
    path->mirror_pdf = mirror ? path->pdf : 0;
    if (mirror) path->mirrored = mirror_image(mirror, path->from.p);
    path->samples_mirrors = !sample->delta && path_samples_mirrors(tracer, path);
    path->dimmed = false;
}

float path_mirror_weight(const struct path_tracer *tracer, const struct path *path, const struct crossing *crossing) {
    const float pdf_light = crossing->pdf_sa * choice_pmf(tracer);
    return pdf_light > 0 ? power_heuristic(path->mirror_pdf, pdf_light) : 1;
}

// What a lamp would lay in front of the mirror: such samples are left to scattering.
static bool lamp_between(const struct path_tracer *tracer, const struct ray *ray, float distance) {
    for (size_t i = 0; i < tracer->scene->luminaire_count; i++) {
        float t_mid;
        const struct luminaire_instance *instance = &tracer->scene->luminaires[i];
        if (instance->keep != KEEP_ALL && crossing_find(instance, ray, &t_mid) && t_mid < distance) return true;
    }
    return false;
}

struct luminaire_request path_mirror_request(const struct path_tracer *tracer, const struct path *path,
                                             uint32_t index) {
    struct sampler sampler = path_sampler(path, PATH_DIMENSION_MIRROR);
    const vec2 u = sampler_2d(&sampler);
    return (struct luminaire_request){index, (uint32_t)(u.x * (float)tracer->scene->luminaire_count),
                                      &tracer->mirrors.mirrors[(size_t)(u.y * (float)tracer->mirrors.count)],
                                      choice_pmf(tracer), 0};
}

void path_mirror_sample(const struct path_tracer *tracer, struct path_worker *worker,
                        const struct luminaire_request *request, vec3 direction, float pdf_light) {
    const struct path *path = &worker->paths[request->path];
    const struct mirror *mirror = request->mirror;
    vec3 towards;
    float to_plane, pdf_bsdf;
    if (!mirror_way(mirror, path->surface.p, direction, &to_plane, &towards)) return;
    rgb response = path_response(path, towards, &pdf_bsdf);
    if (rgb_is_black(response)) return;
    struct ray ray = surface_spawn_ray(&path->surface, towards);
    struct surface end;
    const struct lamp_view view = {false, -1, -1};
    if (!lamp_view_intersect(tracer->scene, tracer->hidden, &view, &ray, &end) ||
        mirror_at(&tracer->mirrors, &end) != mirror || lamp_between(tracer, &ray, end.t))
        return;
    struct bsdf_sample reflection;
    if (!surface_sample_bsdf(&end, vec3_neg(towards), (vec3){0.5f, 0.5f, 0.5f}, TRANSPORT_RADIANCE, &reflection) ||
        !reflection.delta)
        return;
    response = rgb_mul(rgb_mul(response, reflection.weight), segment_absorption(&path->surface, &end, towards, end.t));
    ray = surface_spawn_ray(&end, reflection.wo);
    float t_mid;
    if (!crossing_find(&tracer->scene->luminaires[request->luminaire], &ray, &t_mid)) return;
    ray.t_max = t_mid;
    const float weight = path_light_weight(tracer, pdf_light, pdf_bsdf, false);
    worker->shadows[worker->shadow_count++] = (struct shadow){request->path,
                                                              request->luminaire,
                                                              ray,
                                                              rgb_scale(response, weight / pdf_light),
                                                              .viewpoint = mirror_image(mirror, path->surface.p),
                                                              .direction = towards,
                                                              .sharp = false};
}
