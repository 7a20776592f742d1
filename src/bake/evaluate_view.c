// Looking at the lamp: orthographic pictures of the bounding sphere from the corners of a cube, of the light field, of
// the hull where there is one, and by traced lines.
#include <math.h>

#include "bake/evaluate_private.h"
#include "bake/lamp_picture.h"

enum { PIXELS = EVALUATION_PIXELS, VIEWS = 8 };

struct view_job {
    const struct luminaire *luminaire;
    const struct lamp *lamp;
    uint64_t stream;
    vec3 w; // of the light
    size_t samples; // of each half of a pixel
    struct image_pair *model, *reference;
    const struct scene *hull; // or NULL
    struct image_pair *surface;
};

static void take_pictures(const struct view_job *job) {
    for (int half = 0; half < 2; half++)
        lamp_picture_take(&(struct lamp_picture){.luminaire = job->luminaire,
                                                 .lamp = job->lamp,
                                                 .hull = job->hull,
                                                 .w = job->w,
                                                 .stream = job->stream | (uint64_t)half << 40,
                                                 .samples = job->samples,
                                                 .reference = &job->reference->half[half],
                                                 .model = &job->model->half[half],
                                                 .surface = &job->surface->half[half]});
}

// Sums of squared differences of log(1 + x), free of noise but for the logarithm's curvature.
static void log_errors(const struct image_pair *model, const struct image_pair *reference, double *squared,
                       double *black) {
    for (size_t i = 0; i < 3 * PIXELS * PIXELS; i++) {
        double r0 = log1p((double)reference->half[0].pixels[i]), r1 = log1p((double)reference->half[1].pixels[i]);
        double a = log1p(0.5 * (double)(model->half[0].pixels[i] + model->half[1].pixels[i]));
        *squared += (a - r0) * (a - r1);
        *black += r0 * r1;
    }
}

// The same for pictures whose halves are independent of each other, but not of the reference's halves.
static void log_errors_by_halves(const struct image_pair *model, const struct image_pair *reference, double *squared) {
    for (size_t i = 0; i < 3 * PIXELS * PIXELS; i++) {
        double difference[2];
        for (int half = 0; half < 2; half++)
            difference[half] =
                log1p((double)model->half[half].pixels[i]) - log1p((double)reference->half[half].pixels[i]);
        *squared += difference[0] * difference[1];
    }
}

struct view_sums {
    double squared, surface_squared, black, flip, surface_flip, flip_noise, flip_black;
};

static enum status compare_view(const struct view_job *job, struct view_sums *sums, struct error *error) {
    double one, one_noise, one_black;
    take_pictures(job);
    log_errors(job->model, job->reference, &sums->squared, &sums->black);
    // The picture of the light field has the same places in each pixel: only the reference's noise counts.
    struct image_pair still = {0};
    enum status status = image_pair_mean(job->model, &still.half[0], error);
    still.half[1] = still.half[0];
    if (status == STATUS_OK) status = image_pair_flip(&still, job->reference, &one, &one_noise, &one_black, error);
    if (status == STATUS_OK) {
        sums->flip += one / VIEWS;
        sums->flip_noise += one_noise / VIEWS;
        sums->flip_black += one_black / VIEWS;
    }
    image_fini(&still.half[0]);
    if (!job->hull || status != STATUS_OK) return status;
    log_errors_by_halves(job->surface, job->reference, &sums->surface_squared);
    status = image_pair_flip(job->surface, job->reference, &one, &one_noise, &one_black, error);
    sums->surface_flip += one / VIEWS;
    return status;
}

static float gain_db(double squared, double black) {
    return squared > 0 && black > 0 ? (float)(10 * log10(black / squared)) : 0;
}

enum status evaluate_views(const struct luminaire *luminaire, const struct lamp *lamp, int samples,
                           struct evaluation *evaluation, struct error *error) {
    const bool has_hull = luminaire_hull(luminaire) != NULL;
    struct view_sums sums = {0};
    struct scene hull = {0};
    enum status status = has_hull ? scene_init_hull(&hull, luminaire, lamp->threads, error) : STATUS_OK;
    if (status != STATUS_OK) return status;
    for (int view = 0; view < VIEWS && status == STATUS_OK; view++) {
        struct image_pair model, reference = {0}, surface = {0};
        status = image_pair_init(&model, error);
        if (status == STATUS_OK) status = image_pair_init(&reference, error);
        if (status == STATUS_OK) status = image_pair_init(&surface, error);
        struct view_job job = {
            .luminaire = luminaire,
            .lamp = lamp,
            .stream = (uint64_t)STREAM_EVALUATION << 56 | 5ull << 48 | (uint64_t)view << 42,
            .w = vec3_normalize((vec3){view & 1 ? 1.0f : -1.0f, view & 2 ? 1.0f : -1.0f, view & 4 ? 1.0f : -1.0f}),
            .samples = samples < 2 ? 1 : (size_t)samples / 2,
            .model = &model,
            .reference = &reference,
            .hull = has_hull ? &hull : NULL,
            .surface = &surface};
        if (status == STATUS_OK) status = compare_view(&job, &sums, error);
        image_pair_fini(&model);
        image_pair_fini(&reference);
        image_pair_fini(&surface);
    }
    evaluation->view_gain_db = gain_db(sums.squared, sums.black);
    evaluation->view_flip = (float)sums.flip;
    evaluation->view_flip_noise = (float)sums.flip_noise;
    evaluation->view_flip_black = (float)sums.flip_black;
    evaluation->view_measured = status == STATUS_OK;
    evaluation->surface_gain_db = gain_db(sums.surface_squared, sums.black);
    evaluation->surface_flip = (float)sums.surface_flip;
    evaluation->surface_measured = status == STATUS_OK && has_hull;
    scene_fini(&hull);
    return status;
}
