// How far a luminaire is from its lamp, on particles and lines that it has never seen. Every reference is unbiased and
// its own noise is stated; a black image scores 1 in every error that is relative.
#pragma once

#include "luminaire/luminaire.h"
#include "scene/scene.h"

enum { EVALUATION_DISTANCES = 4 };
extern const float evaluation_distance_radii[EVALUATION_DISTANCES]; // 1.2, 2, 4, 10 bounding radii from the centre

struct evaluation {
    float flux[3], flux_noise[3]; // of the traced lamp, and its relative standard error
    float flux_error[3]; // relative, signed: luminaire / lamp - 1
    // Mean over the patches of a sphere of that radius of |E / E_ref - 1|; `noise` is what a perfect luminaire would
    // score because both sides are Monte Carlo estimates (an upper bound: of samples as if they were independent).
    float irradiance_error[EVALUATION_DISTANCES], irradiance_noise[EVALUATION_DISTANCES];
    // Squared error of radiance averaged over small bundles of lines, less the noise of both sides, over the mean
    // square.
    float light_field_error;
    float transparency_error, transparency_error_opaque; // mean absolute, of the luminaire and of T = 0
    float sample_variance,
        sample_variance_uniform; // relative variance of L cos / p of one light sample; of uniform ones
};

struct evaluation_effort {
    size_t particles, lines, light_points, transparency_lines;
};
extern const struct evaluation_effort evaluation_effort_full; // noise of irradiance about 1 %

enum status evaluate_luminaire(const struct luminaire *luminaire, const struct scene *scene,
                               const struct evaluation_effort *effort, const struct run *run,
                               struct evaluation *evaluation, struct error *error);
// As a JSON object, malloc'ed; NULL when memory is out.
char *evaluation_json(const struct evaluation *evaluation);
