// The measures of one evaluation, one file each.
#pragma once

#include "bake/evaluate.h"
#include "bake/gather.h"
#include "image/image.h"

enum { EVALUATION_PIXELS = 256, EVALUATION_VIEWS = 8 }; // a side, of the wall and of the pictures; directions

// Two independent estimates of one image: their mean is the image, their difference its noise.
struct image_pair {
    struct image half[2];
};
enum status image_pair_init(struct image_pair *pair, struct error *error); // RGB, square, black
void image_pair_fini(struct image_pair *pair);
enum status image_pair_mean(const struct image_pair *pair, struct image *mean, struct error *error);
// FLIP of the model against the reference, both of one exposure, extrapolated to what it is without noise; `noise`: of
// the model's mean against itself with the noise of both added; `black`: of a black image.
enum status image_pair_flip(const struct image_pair *model, const struct image_pair *reference, double *flip,
                            double *noise, double *black, struct error *error);

// log(1 + x) of what two equally noisy, independent estimates have as their mean, with the first order of the noise's
// bias taken off.
float log_of_mean(float x0, float x1);

struct wall {
    vec3 center; // of the lamp
    float radius;
    struct image_pair exits; // flux of the exits that met each pixel
    size_t emitted[2]; // particles of each half
};
enum status wall_init(struct wall *wall, const struct lamp *lamp, struct error *error);
void wall_fini(struct wall *wall);
void wall_add(struct wall *wall, const struct exit_list *exits, int half);
enum status wall_compare(struct wall *wall, const struct luminaire *luminaire, const struct lamp *lamp, int samples,
                         struct evaluation *evaluation, struct error *error);

struct evaluation_progress {
    const struct run *run;
    double start; // clock_wall_s
    double first, last; // what of the whole evaluation the stage begins and ends with
};
void evaluation_report(const struct evaluation_progress *progress, double fraction); // of the stage

enum status evaluate_views(const struct luminaire *luminaire, const struct lamp *lamp, int samples,
                           const struct evaluation_progress *progress, struct evaluation *evaluation,
                           struct error *error);
enum status evaluate_transparency(const struct luminaire *luminaire, const struct lamp *lamp, size_t lines,
                                  struct evaluation *evaluation, struct error *error);
enum status evaluate_sampling(const struct luminaire *luminaire, const struct lamp *lamp, size_t points,
                              struct evaluation *evaluation, struct error *error);
