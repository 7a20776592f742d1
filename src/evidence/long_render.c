// The state is the film: its mean and variance as an image, the number of passes beside it. A pass of bdpt or of
// particles depends on nothing but the seed and its number, so that what is continued equals what was never interrupted
// (but for rounding to float). The path tracer's roulette has to learn from the passes again: other samples, the same
// mean.
#include "evidence/long_render.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "evidence/kept.h"
#include "evidence/scene_files.h"
#include "render/render.h"
#include "trace/integrator.h"

static const double SAVE_INTERVAL_S = 60;

struct long_job {
    const struct long_render *request;
    const struct run *run;
    char key[600], image_path[4096], numbers_path[4096];
    struct scene scene;
    struct film film;
    double cpu_s, spent_s; // by earlier calls; by this one, up to the last save
};

static enum status job_init(struct long_job *job, const struct long_render *request, const struct run *run,
                            struct error *error) {
    *job = (struct long_job){.request = request, .run = run};
    snprintf(job->image_path, sizeof job->image_path, "%s.exr", request->stem);
    snprintf(job->numbers_path, sizeof job->numbers_path, "%s.json", request->stem);
    struct scene_files files;
    enum status status =
        scene_files_measure(&files, request->scene, request->definitions, request->definition_count, error);
    int used = snprintf(job->key, sizeof job->key, "sconce %s, %s, %dx%d, seed %llu, files %016llx", SCONCE_VERSION,
                        request->integrator, request->width, request->height, (unsigned long long)request->seed,
                        (unsigned long long)files.hash);
    for (size_t i = 0; i < request->definition_count; i++) { // paths are told by what they hold
        const struct definition *d = &request->definitions[i];
        if (used < (int)sizeof job->key && !strchr(d->value, '/'))
            used += snprintf(job->key + used, sizeof job->key - (size_t)used, ", %s %s", d->name, d->value);
    }
    return status;
}

static void job_fini(struct long_job *job) {
    scene_fini(&job->scene);
    film_fini(&job->film);
}

// Samples of an earlier call, 0 without one that fits.
static int job_kept(struct long_job *job) {
    json_t *numbers = kept_load(job->numbers_path, job->key);
    int samples = 0;
    if (numbers && !access(job->image_path, R_OK) && (!job->request->mask || !access(job->request->mask, R_OK))) {
        samples = (int)json_integer_value(json_object_get(numbers, "samples"));
        job->cpu_s = json_number_value(json_object_get(numbers, "cpu_s"));
    }
    json_decref(numbers);
    if (samples >= 0 && samples <= job->request->samples) return samples;
    job->cpu_s = 0;
    return 0;
}

static enum status film_restore(struct film *film, const struct image *image, int passes, struct error *error) {
    static const char *const names[2][3] = {{"R", "G", "B"}, {"variance.R", "variance.G", "variance.B"}};
    const double n = passes;
    for (int c = 0; c < 3; c++) {
        const int mean = image_channel(image, names[0][c]), variance = image_channel(image, names[1][c]);
        if (image->width != film->width || image->height != film->height || mean < 0 || variance < 0)
            return error_set(error, STATUS_INVALID, "the kept picture has another form; remove it");
        for (size_t i = 0; i < (size_t)film->width * (size_t)film->height; i++) {
            const float *pixel = &image->pixels[i * (size_t)image->channels];
            film->mean[3 * i + (size_t)c] = (double)pixel[mean];
            film->m2[3 * i + (size_t)c] = (double)pixel[variance] * n * (n - 1);
        }
    }
    film->pass_count = (size_t)passes;
    return STATUS_OK;
}

// The numbers go first and come last: without them there is no rendering.
static enum status job_save(struct long_job *job, const void *state, double cpu_begin, struct error *error) {
    struct image image;
    enum status status =
        integrator_image(integrator_table[job->scene.integrator], state, &job->film, job->run, &image, error);
    if (status) return status;
    job->spent_s = clock_cpu_s() - cpu_begin;
    unlink(job->numbers_path);
    status = image_save(&image, job->image_path, 1, error);
    image_fini(&image);
    if (status) return status;
    return kept_save(job->numbers_path,
                     json_pack("{s:s, s:i, s:f}", "key", job->key, "samples", (int)job->film.pass_count, "cpu_s",
                               job->cpu_s + job->spent_s),
                     error);
}

static enum status job_load_scene(struct long_job *job, int kept, struct error *error) {
    const struct long_render *request = job->request;
    struct scene_options options = {.share_light = true,
                                    .definitions = request->definitions,
                                    .definition_count = request->definition_count,
                                    .width = request->width,
                                    .height = request->height,
                                    .threads = job->run->threads};
    // Its notes were read when the scene was made, and some rooms have no use for all definitions.
    const struct run silent = {.threads = job->run->threads, .cancelled = job->run->cancelled, .user = job->run->user};
    enum status status = scene_load(&job->scene, request->scene, &options, &silent, error);
    if (status) return status;
    integrator_find(&job->scene.integrator, request->integrator);
    status = film_init(&job->film, job->scene.sensor, error);
    if (!status && request->mask) status = render_mask(&job->scene, request->mask, job->run, error);
    if (status || !kept) return status;
    struct image image;
    status = image_load(&image, job->image_path, false, error);
    if (!status) status = film_restore(&job->film, &image, kept, error);
    image_fini(&image);
    return status;
}

static enum status job_passes(struct long_job *job, struct error *error) {
    const struct long_render *request = job->request;
    const struct integrator_type *type = integrator_table[job->scene.integrator];
    struct run run = *job->run;
    run.seed = request->seed;
    void *state = NULL;
    const double wall = clock_wall_s();
    double cpu = clock_cpu_s(), saved_s = wall;
    enum status status = type->create(&job->scene, &run, &state, error);
    if (job->film.pass_count) cpu = clock_cpu_s(); // an earlier call has counted what comes before the passes
    while (!status && job->film.pass_count < (size_t)request->samples) {
        char detail[64];
        snprintf(detail, sizeof detail, "%zu of %d spp", job->film.pass_count, request->samples);
        run_progress(&run, request->stage, (double)job->film.pass_count / request->samples, clock_wall_s() - wall,
                     detail);
        status = run_cancelled(&run) ? error_set(error, STATUS_CANCELLED, "stopped; %s is kept", job->image_path)
                                     : type->render_pass(state, &job->film, job->film.pass_count, &run, error);
        if (!status) film_end_pass(&job->film, run.threads);
        if (!status && clock_wall_s() - saved_s > SAVE_INTERVAL_S) {
            status = job_save(job, state, cpu, error);
            saved_s = clock_wall_s();
        }
    }
    if (job->film.pass_count && (!status || status == STATUS_CANCELLED)) {
        enum status saved = job_save(job, state, cpu, status ? NULL : error);
        if (!status) status = saved;
    }
    if (state) type->destroy(state);
    return status;
}

enum status long_render(const struct long_render *request, const struct run *run, struct long_render_result *result,
                        struct error *error) {
    struct long_job job;
    *result = (struct long_render_result){0};
    enum status status = job_init(&job, request, run, error);
    if (status) return status;
    const int kept = job_kept(&job);
    if (kept < request->samples) {
        status = job_load_scene(&job, kept, error);
        if (!status) status = job_passes(&job, error);
    }
    if (!status) status = image_load(&result->image, job.image_path, false, error);
    result->cpu_s = job.cpu_s + job.spent_s;
    result->samples = request->samples;
    job_fini(&job);
    return status;
}
