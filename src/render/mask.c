// Which pixels see a baked lamp: the figures "outside the lamp" leave them out. Camera rays on a 4x4 grid in each pixel
// follow mirror reflections; everything that is not perfectly specular ends them.
#include "base/parallel.h"
#include "image/image.h"
#include "render/render.h"

enum { GRID = 4, MAX_REFLECTIONS = 4 };

static bool ray_meets_lamp(const struct scene *scene, const struct ray *ray) {
    for (size_t i = 0; i < scene->luminaire_count; i++) {
        const struct luminaire_instance *lamp = &scene->luminaires[i];
        struct transform local_from_world = transform_inverse(&lamp->to_world);
        vec3 o = transform_point(&local_from_world, ray->origin);
        vec3 d = vec3_normalize(transform_vector(&local_from_world, ray->direction));
        float t_near, t_far;
        if (luminaire_span(lamp->luminaire, (float[3]){o.x, o.y, o.z}, (float[3]){d.x, d.y, d.z}, &t_near, &t_far)) {
            float t_mid = 0.5f * (t_near + t_far) * lamp->scale;
            if (t_mid > 0 && t_mid < ray->t_max) return true;
        }
    }
    return false;
}

static bool film_point_sees_lamp(const struct scene *scene, vec2 film) {
    struct ray ray;
    scene->sensor->type->sample_ray(scene->sensor, film, (vec2){0.5f, 0.5f}, &ray);
    for (int bounce = 0; bounce <= MAX_REFLECTIONS; bounce++) {
        struct surface surface;
        bool hit = scene_intersect(scene, &ray, -1, &surface);
        if (hit) ray.t_max = surface.t;
        if (ray_meets_lamp(scene, &ray)) return true;
        struct bsdf_sample sample;
        vec3 wi = vec3_neg(ray.direction);
        if (!hit) return false;
        if (surface.shape->luminaire >= 0) return true;
        if (surface_bsdf_flags(&surface) & BSDF_SMOOTH) return false;
        if (!surface_sample_bsdf(&surface, wi, (vec3){0.999f, 0.5f, 0.5f}, TRANSPORT_RADIANCE, &sample) ||
            !sample.delta)
            return false;
        ray = surface_spawn_ray(&surface, sample.wo);
    }
    return false;
}

struct mask_job {
    const struct scene *scene;
    struct image image;
};

static void mask_row(void *user, size_t row, int worker) {
    (void)worker;
    struct mask_job *job = user;
    const struct sensor *sensor = job->scene->sensor;
    for (int x = 0; x < job->image.width; x++) {
        float *pixel = &job->image.pixels[row * (size_t)job->image.width + (size_t)x];
        *pixel = 1;
        for (int i = 0; i<GRID * GRID && * pixel> 0; i++) {
            vec2 film = {((float)(sensor->crop_x + x) + ((float)(i % GRID) + 0.5f) / GRID) / (float)sensor->width,
                         ((float)sensor->crop_y + (float)row + ((float)(i / GRID) + 0.5f) / GRID) /
                             (float)sensor->height};
            if (film_point_sees_lamp(job->scene, film)) *pixel = 0;
        }
    }
}

enum status render_mask(const struct scene *scene, const char *path, const struct run *run, struct error *error) {
    if (!scene->luminaire_count)
        return error_set(error, STATUS_INVALID,
                         "%s: a mask needs a baked lamp in the scene; give its .safetensors file with -D", scene->path);
    struct mask_job job = {.scene = scene};
    enum status status = image_init(&job.image, scene->sensor->crop_width, scene->sensor->crop_height, 1, error);
    if (status) return status;
    parallel_for(run->threads, (size_t)job.image.height, mask_row, &job);
    status = image_save(&job.image, path, 1, error);
    image_fini(&job.image);
    return status;
}
