// Looking at the lamp: orthographic pictures of the bounding sphere from the corners of a cube, of the light field, of
// the hull where there is one, and by traced lines.
#include <math.h>

#include "bake/evaluate_private.h"
#include "bake/lamp_picture.h"

enum { PIXELS = EVALUATION_PIXELS, VIEWS = EVALUATION_VIEWS, QUARTERS = 4 };

struct picture { // independent pictures: two halves of two quarters each
    struct image quarter[QUARTERS];
};

static enum status picture_init(struct picture *picture, struct error *error) {
    enum status status = STATUS_OK;
    for (int k = 0; k < QUARTERS && status == STATUS_OK; k++)
        status = image_init(&picture->quarter[k], PIXELS, PIXELS, 3, error);
    return status;
}

static void picture_fini(struct picture *picture) {
    for (int k = 0; k < QUARTERS; k++) image_fini(&picture->quarter[k]);
}

static enum status picture_halves(const struct picture *picture, struct image_pair *pair, struct error *error) {
    enum status status = image_pair_init(pair, error);
    for (int half = 0; half < 2 && status == STATUS_OK; half++) {
        const float *a = picture->quarter[2 * half].pixels, *b = picture->quarter[2 * half + 1].pixels;
        for (size_t i = 0; i < 3 * PIXELS * PIXELS; i++) pair->half[half].pixels[i] = 0.5f * (a[i] + b[i]);
    }
    return status;
}

// log(1 + x) of a half's pixel value.
static double picture_log(const struct picture *picture, int half, size_t i) {
    return (double)log_of_mean(picture->quarter[2 * half].pixels[i], picture->quarter[2 * half + 1].pixels[i]);
}

struct view_job {
    const struct luminaire *luminaire;
    const struct lamp *lamp;
    uint64_t stream;
    vec3 w; // of the light
    size_t samples; // of each quarter of a pixel
    struct picture *model, *reference;
    const struct scene *hull; // or NULL
    struct picture *surface;
};

static void take_pictures(const struct view_job *job) {
    for (int k = 0; k < QUARTERS; k++)
        lamp_picture_take(&(struct lamp_picture){.luminaire = job->luminaire,
                                                 .lamp = job->lamp,
                                                 .hull = job->hull,
                                                 .w = job->w,
                                                 .stream = job->stream | (uint64_t)k << 40,
                                                 .samples = job->samples,
                                                 .reference = &job->reference->quarter[k],
                                                 .model = &job->model->quarter[k],
                                                 .surface = &job->surface->quarter[k]});
}

// Sums of squared differences of log(1 + x): products of the two halves' differences, free of noise in the mean.
static double log_error(const struct picture *a, const struct picture *r) {
    double sum = 0;
    for (size_t i = 0; i < 3 * PIXELS * PIXELS; i++)
        sum += (picture_log(a, 0, i) - picture_log(r, 0, i)) * (picture_log(a, 1, i) - picture_log(r, 1, i));
    return sum;
}

static double log_square(const struct picture *picture) {
    double sum = 0;
    for (size_t i = 0; i < 3 * PIXELS * PIXELS; i++) sum += picture_log(picture, 0, i) * picture_log(picture, 1, i);
    return sum;
}

static enum status picture_flip(const struct picture *picture, const struct picture *reference, double *flip,
                                double *noise, double *black, struct error *error) {
    struct image_pair a = {0}, r = {0};
    enum status status = picture_halves(picture, &a, error);
    if (status == STATUS_OK) status = picture_halves(reference, &r, error);
    if (status == STATUS_OK) status = image_pair_flip(&a, &r, flip, noise, black, error);
    image_pair_fini(&a);
    image_pair_fini(&r);
    return status;
}

struct view_sums {
    double squared, surface_squared, black, flip, surface_flip, flip_noise, flip_black;
};

static enum status compare_view(const struct view_job *job, struct view_sums *sums, struct error *error) {
    double one, one_noise, one_black;
    take_pictures(job);
    sums->black += log_square(job->reference);
    sums->squared += log_error(job->model, job->reference);
    enum status status = picture_flip(job->model, job->reference, &one, &one_noise, &one_black, error);
    if (status == STATUS_OK) {
        sums->flip += one / VIEWS;
        sums->flip_noise += one_noise / VIEWS;
        sums->flip_black += one_black / VIEWS;
    }
    if (!job->hull || status != STATUS_OK) return status;
    sums->surface_squared += log_error(job->surface, job->reference);
    status = picture_flip(job->surface, job->reference, &one, &one_noise, &one_black, error);
    sums->surface_flip += one / VIEWS;
    return status;
}

static double gain_db(double squared, double black) {
    return squared > 0 && black > 0 ? 10 * log10(black / squared) : 0;
}

static enum status look(struct view_job *job, int view, struct view_sums *sums, struct error *error) {
    struct picture model = {0}, reference = {0}, surface = {0};
    enum status status = picture_init(&model, error);
    if (status == STATUS_OK) status = picture_init(&reference, error);
    if (status == STATUS_OK) status = picture_init(&surface, error);
    job->stream = (uint64_t)STREAM_EVALUATION << 56 | 5ull << 48 | (uint64_t)view << 42;
    job->w = vec3_normalize((vec3){view & 1 ? 1.0f : -1.0f, view & 2 ? 1.0f : -1.0f, view & 4 ? 1.0f : -1.0f});
    job->model = &model;
    job->reference = &reference;
    job->surface = &surface;
    if (status == STATUS_OK) status = compare_view(job, sums, error);
    picture_fini(&model);
    picture_fini(&reference);
    picture_fini(&surface);
    return status;
}

enum status evaluate_views(const struct luminaire *luminaire, const struct lamp *lamp, int samples,
                           const struct evaluation_progress *progress, struct evaluation *evaluation,
                           struct error *error) {
    const bool has_hull = luminaire_hull(luminaire) != NULL;
    struct view_sums sums = {0};
    struct scene hull = {0};
    enum status status = has_hull ? scene_init_hull(&hull, luminaire, lamp->threads, error) : STATUS_OK;
    if (status != STATUS_OK) return status;
    struct view_job job = {.luminaire = luminaire,
                           .lamp = lamp,
                           .hull = has_hull ? &hull : NULL,
                           .samples = samples < QUARTERS ? 1 : (size_t)samples / QUARTERS};
    for (int view = 0; view < VIEWS && status == STATUS_OK; view++) {
        status = look(&job, view, &sums, error);
        evaluation_report(progress, (double)(view + 1) / VIEWS);
    }
    evaluation->view_samples = QUARTERS * (int)job.samples;
    evaluation->view_gain_db = (float)gain_db(sums.squared, sums.black);
    evaluation->view_flip = (float)sums.flip;
    evaluation->view_flip_noise = (float)sums.flip_noise;
    evaluation->view_flip_black = (float)sums.flip_black;
    evaluation->view_measured = status == STATUS_OK;
    evaluation->surface_gain_db = (float)gain_db(sums.surface_squared, sums.black);
    evaluation->surface_flip = (float)sums.surface_flip;
    evaluation->surface_measured = status == STATUS_OK && has_hull;
    scene_fini(&hull);
    return status;
}
