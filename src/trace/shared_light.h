// Light that pixels share. Pixels that see one surface side by side get nearly the same light, so each may learn it
// from its neighbours (Keller, Dahm and Binder 2016, "Path Space Filtering"). Every pixel keeps sums of what arrived at
// the surface that it sees, in parts each of which varies slowly from pixel to pixel once it is divided by its weight.
// The film keeps what every pixel found by itself; the picture gets, for each part, the mix of a pixel's own mean and
// what its neighbours predict that promises the least error (shared_filter.c).
#pragma once

#include <stddef.h>
#include <stdint.h>

#include "base/error.h"
#include "base/run.h"
#include "image/image.h"
#include "math/vec.h"

enum { SHARED_WEIGHTS = 2, SHARED_PARTS = 6, SHARED_LAYERS = 3 }; // part i has weight i % SHARED_WEIGHTS

struct shared_sample { // of one path at one surface
    uint32_t surface; // 1 + number of what it sees
    vec3 p, n; // where
    rgb weight[SHARED_WEIGHTS], light[SHARED_PARTS]; // what the picture gets is weight * light
};

struct shared_splat { // light that a pixel's paths do not bring
    uint32_t surface; // which it reaches; 0: none that is shared
    vec3 n;
    int part; // the first of as many as there are weights
    rgb share[SHARED_WEIGHTS], weight[SHARED_WEIGHTS];
};

static inline rgb shared_ratio(rgb a, rgb b) { // 0 where b is
    return (rgb){b.r > 0 ? a.r / b.r : 0, b.g > 0 ? a.g / b.g : 0, b.b > 0 ? a.b / b.b : 0};
}

struct shared_light;
enum status shared_light_create(struct shared_light **shared, int width, int height, struct error *error);
void shared_light_destroy(struct shared_light *shared); // NULL is allowed
// Once for every path, of different surfaces; threads may add to different pixels at a time. A pixel keeps the
// SHARED_LAYERS surfaces that it has met first.
void shared_light_add(struct shared_light *shared, size_t pixel, const struct shared_sample *samples, int count);
// After the paths of a pass. Nothing is shared of it unless a path of the pixel has met the surface; threads as above.
void shared_light_splat(struct shared_light *shared, size_t pixel, const struct shared_splat *splat, rgb value);
// Variances of the luminance that one path adds to the pixel by the light of each part, as the paths so far have them.
void shared_light_variances(const struct shared_light *shared, size_t pixel, float variances[SHARED_PARTS]);
// Changes R, G and B (channels 0 to 2) of the film's image, the mean of `passes` passes, of which all or the last ones
// have been added. The variance stays that of the pixels' own samples.
enum status shared_light_apply(const struct shared_light *shared, size_t passes, struct image *image,
                               const struct run *run, struct error *error);

// For shared_filter.c.
enum { SHARED_BATCH = 8 }; // paths
struct shared_part {
    float light[3], product[3]; // sums, of weight * light the last
    float squares; // sum of the luminance of light^2
    float batch, batch_squares; // luminance of light in the running batch; sum of the squares of those of all before
};
struct shared_surface { // as one pixel sees it
    uint32_t surface; // 0: none
    float count; // paths that met it
    float p[3], n[3], weights[SHARED_WEIGHTS][3]; // sums
    struct shared_part parts[SHARED_PARTS];
};
struct shared_light {
    int width, height;
    float *paths; // of each pixel
    struct shared_surface *layers[SHARED_LAYERS]; // the first surface of each pixel, ...
};
