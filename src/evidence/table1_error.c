// With d = mean of the pictures - mean of the references, E d^2 = bias^2 + s, where s is the noise of both means; a
// half and its twin differ by noise only, so s is known from (o1 - o2)^2 / 4 + (r1 - r2)^2 / 4. Then d^2 - s is the
// mean of the products (o1 - r1)(o2 - r2) and (o1 - r2)(o2 - r1) of independent differences. Its variance is 4 bias^2 s
// + 4 s^2 for normal noise, and E 4 d^2 s is just that: d and the differences are independent.
#include "evidence/table1_error.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "image/metric.h"

static double square(double x) { return x * x; }

struct error_parts error_split(const struct image *const pictures[2], const struct image *const references[2],
                               const struct image *mask) {
    struct error_parts parts = {0};
    double variance = 0;
    size_t pixels = (size_t)pictures[0]->width * (size_t)pictures[0]->height, count = 0;
    for (size_t i = 0; i < pixels; i++) {
        if (mask && !(mask->pixels[i * (size_t)mask->channels] > 0.5f)) continue;
        for (size_t c = 0; c < 3; c++) {
            const double o1 = pictures[0]->pixels[i * (size_t)pictures[0]->channels + c];
            const double o2 = pictures[1]->pixels[i * (size_t)pictures[1]->channels + c];
            const double r1 = references[0]->pixels[i * (size_t)references[0]->channels + c];
            const double r2 = references[1]->pixels[i * (size_t)references[1]->channels + c];
            const double r = 0.5 * (r1 + r2), weight = 1 / (r * r + 1e-3);
            const double noise = 0.25 * square(o1 - o2), reference_noise = 0.25 * square(r1 - r2);
            const double s = noise + reference_noise, difference = square(0.5 * (o1 + o2) - r);
            parts.noise += weight * noise;
            parts.reference_noise += weight * reference_noise;
            parts.bias += weight * (difference - s);
            variance += 4 * square(weight) * difference * s;
            count++;
        }
    }
    const double n = count ? (double)count : 1;
    parts.noise /= n;
    parts.reference_noise /= n;
    parts.bias /= n;
    parts.bias_error = sqrt(variance) / n;
    return parts;
}

static int descending(const void *a, const void *b) {
    const double x = *(const double *)a, y = *(const double *)b;
    return (x < y) - (x > y);
}

// The pixels' squared relative errors; -1 outside the mask. NULL without memory.
static double *pixel_errors(const struct image *picture, const struct image *reference, const struct image *mask,
                            size_t *count) {
    const size_t pixels = (size_t)reference->width * (size_t)reference->height;
    double *errors = calloc(pixels, sizeof *errors);
    *count = 0;
    for (size_t i = 0; errors && i < pixels; i++) {
        errors[i] = -1;
        if (mask && !(mask->pixels[i * (size_t)mask->channels] > 0.5f)) continue;
        errors[i] = pixel_relative_error(&picture->pixels[i * (size_t)picture->channels],
                                         &reference->pixels[i * (size_t)reference->channels]);
        ++*count;
    }
    return errors;
}

double error_share_of_worst(const struct image *picture, const struct image *reference, struct image *mask, bool drop) {
    const size_t pixels = (size_t)reference->width * (size_t)reference->height;
    size_t count;
    double *errors = pixel_errors(picture, reference, mask, &count), *sorted = malloc(pixels * sizeof *sorted);
    double sum = 0, worst = 0;
    if (errors && sorted && count) {
        memcpy(sorted, errors, pixels * sizeof *sorted);
        qsort(sorted, pixels, sizeof *sorted, descending);
        const size_t few = (count + 999) / 1000;
        size_t left = few; // among equals the first
        for (size_t i = 0; i < count; i++) sum += sorted[i];
        for (size_t i = 0; i < few; i++) worst += sorted[i];
        for (size_t i = 0; drop && i < pixels && left; i++) {
            if (errors[i] < sorted[few - 1]) continue;
            mask->pixels[i * (size_t)mask->channels] = 0;
            left--;
        }
    }
    free(errors);
    free(sorted);
    return sum > 0 ? worst / sum : (double)NAN;
}

double error_samples(double noise_of_one, double bias, double target) {
    return target > bias ? noise_of_one / (target - bias) : (double)INFINITY;
}
