// The film: mean and variance per pixel over passes. One pass is one whole image; passes are averaged.
#pragma once

#include "base/error.h"
#include "image/image.h"
#include "scene/sensor.h"

struct film {
    int width, height; // of the crop
    float *pass; // width * height * 3: the running pass, cleared by film_end_pass
    double *mean, *m2; // Welford over the passes
    size_t pass_count;
};

enum status film_init(struct film *film, const struct sensor *sensor, struct error *error);
void film_fini(struct film *film);
void film_end_pass(struct film *film, int threads);
// RGB plus variance.R/G/B of the mean (zero with one pass). Also alpha-free.
enum status film_image(const struct film *film, struct image *image, struct error *error);
