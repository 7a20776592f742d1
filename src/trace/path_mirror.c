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

static void sample_one(const struct path_tracer *tracer, struct path_worker *worker, uint32_t index, uint32_t luminaire,
                       const struct mirror *mirror, vec3 image, vec3 direction, float pdf_light) {
    const struct path *path = &worker->paths[index];
    const float along = vec3_dot(direction, mirror->n), away = vec3_dot(vec3_sub(mirror->p, image), mirror->n);
    if (!(away * along > 0)) return;
    const vec3 towards = vec3_normalize(vec3_sub(vec3_mad(direction, away / along, image), path->surface.p));
    float pdf_bsdf;
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
    if (!crossing_find(&tracer->scene->luminaires[luminaire], &ray, &t_mid)) return;
    ray.t_max = t_mid;
    const float weight = path_light_weight(tracer, pdf_light, pdf_bsdf, false);
    worker->shadows[worker->shadow_count++] = (struct shadow){
        index, luminaire, ray, rgb_scale(response, weight / pdf_light), .viewpoint = image, .sharp = false};
}

void path_light_mirrors(const struct path_tracer *tracer, struct path_worker *worker) {
    const struct scene *scene = tracer->scene;
    if (!tracer->mirrors.count) return;
    for (uint32_t l = 0; l < scene->luminaire_count; l++) {
        const struct luminaire_instance *instance = &scene->luminaires[l];
        size_t count = 0;
        for (size_t i = 0; i < worker->active_count; i++) {
            const struct path *path = &worker->paths[worker->active[i]];
            if (path->status != PATH_SCATTERS || !(surface_bsdf_flags(&path->surface) & BSDF_SMOOTH) ||
                !path_samples_mirrors(tracer, path))
                continue;
            struct sampler sampler = path_sampler(path, PATH_DIMENSION_LIGHT);
            sampler.dimension += MIRROR_DIMENSIONS;
            const vec2 choice = sampler_2d(&sampler), u = sampler_2d(&sampler);
            if ((uint32_t)(choice.x * (float)scene->luminaire_count) != l) continue;
            const size_t m = (size_t)(choice.y * (float)tracer->mirrors.count);
            const vec3 s = luminaire_local_point(instance, mirror_image(&tracer->mirrors.mirrors[m], path->surface.p));
            worker->requests[count] = (struct luminaire_request){worker->active[i], (uint32_t)m, choice_pmf(tracer)};
            worker->points[count][0] = s.x, worker->points[count][1] = s.y, worker->points[count][2] = s.z;
            worker->numbers[count][0] = u.x, worker->numbers[count][1] = u.y;
            worker->numbers[count][2] = sampler_1d(&sampler);
            count++;
        }
        if (!count) continue;
        luminaire_sample(instance->luminaire, count, (const float(*)[3])worker->points,
                         (const float(*)[3])worker->numbers, worker->directions, worker->pdfs);
        for (size_t i = 0; i < count; i++) {
            const struct luminaire_request *request = &worker->requests[i];
            const struct mirror *mirror = &tracer->mirrors.mirrors[request->luminaire];
            const float *local = worker->directions[i], pdf_light = worker->pdfs[i] * request->pmf;
            if (pdf_light > 0)
                sample_one(tracer, worker, request->path, l, mirror,
                           mirror_image(mirror, worker->paths[request->path].surface.p),
                           luminaire_world_direction(instance, (vec3){local[0], local[1], local[2]}), pdf_light);
        }
    }
}
