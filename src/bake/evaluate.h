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
    // score because both sides are Monte Carlo estimates.
    float irradiance_error[EVALUATION_DISTANCES], irradiance_noise[EVALUATION_DISTANCES];
    // Squared error of radiance averaged over small bundles of lines, less the noise of both sides, over the mean
    // square.
    float light_field_error;
    bool transparency_measured, sampling_measured;
    float transparency_error, transparency_error_opaque; // mean absolute, of the luminaire and of T = 0
    float transparency_noise; // what a perfect luminaire would score
    float sample_variance,
        sample_variance_uniform; // relative variance of L cos / p of one light sample; of uniform ones
    // Of the irradiance map on a square wall of 4 x 4 radii, 2 radii from the centre: relMSE less the noise of both
    // sides, what that noise alone would add; of both maps smoothed by 2 pixels: FLIP, extrapolated to no noise, and
    // what noise alone would score.
    bool wall_measured;
    float wall_relmse, wall_relmse_noise, wall_flip, wall_flip_noise;
    // Of orthographic pictures of the lamp from 8 directions as the light field shows it: mean squared error of
    // log(1 + x) less the noise, in dB below that of a black image; FLIP of both as for the wall, and of noise alone.
    bool view_measured;
    int view_samples; // a pixel
    float view_gain_db, view_flip, view_flip_black, view_flip_noise;
    bool surface_measured; // the same pictures as the hull shows the lamp, where there is one
    float surface_gain_db, surface_flip;
};

struct evaluation_effort {
    size_t particles, lines;
    size_t light_points, transparency_lines; // 0: not measured
    int wall_samples; // a pixel of the wall, of the luminaire; 0: the wall is not measured
    int view_samples; // a pixel of the pictures; 0: they are not measured
};
// Of a bake and of a measurement: fixed work, so that the same seed gives the same file and the same figures.
enum bake_quality { BAKE_DRAFT, BAKE_STANDARD, BAKE_HIGH };
extern const struct evaluation_effort evaluation_efforts[]; // from standard on noise of irradiance below 0.5 %
extern const struct evaluation_effort evaluation_effort_paper; // for the published networks, whose queries cost more

enum status evaluate_luminaire(const struct luminaire *luminaire, const struct scene *scene,
                               const struct evaluation_effort *effort, const struct run *run,
                               struct evaluation *evaluation, struct error *error);
// As a JSON object, malloc'ed; NULL when memory is out.
char *evaluation_json(const struct evaluation *evaluation);
