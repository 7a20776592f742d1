// Path tracer, first stage: one camera ray for every pixel of a tile of the crop.
#include "trace/film_sample.h"
#include "trace/path_state.h"

void path_generate(const struct path_tracer *tracer, struct path_worker *worker, int tile) {
    const struct sensor *sensor = tracer->scene->sensor;
    const struct path_tile t = path_tile_of(tracer, tile);
    uint32_t count = 0;
    for (int y = t.y0; y < t.y1; y++) {
        for (int x = t.x0; x < t.x1; x++, count++) {
            struct path *path = &worker->paths[count];
            int film_x = sensor->crop_x + x, film_y = sensor->crop_y + y;
            path->sampler = sampler_make(tracer->seed, film_pixel_stream(sensor, film_x, film_y), tracer->pass);
            vec2 u_film = sampler_2d(&path->sampler), u_lens = sampler_2d(&path->sampler);
            sensor->type->sample_ray(sensor, film_sample_position(sensor, film_x, film_y, u_film), u_lens, &path->ray);
            path->beta = rgb_gray(1);
            path->radiance = rgb_gray(0);
            path->status = PATH_SCATTERS;
            path->depth = 0;
            path->edge = 0;
            path->pixel = (uint32_t)y * (uint32_t)tracer->film->width + (uint32_t)x;
            path->lights = &tracer->tile_lights[tile];
            path->eta = 1;
            path->expected = tracer->expected[path->pixel];
            path->pdf = 0;
            path->vertex = (struct light_point){path->ray.origin, -1, -1};
            path->look = true;
            path->through = -1;
            path->may_be_caustic = false;
            path->from_sheet = false;
            path->passed = false;
            path->has_from = false;
            path->dimmed = false;
            path->samples_mirrors = false;
            path->mirror_pdf = 0;
            path->spread = path->pdf_spread = path->unfolded = 0;
            path->cached = path->marked = path->shows = false;
            path->mark_count = 0;
            path->share.state = SHARE_NONE;
            path->share.count = 0;
            path->record.state = RECORD_NONE;
            worker->active[count] = count;
        }
    }
    worker->active_count = count;
}
