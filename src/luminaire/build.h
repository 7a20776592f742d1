// Making a luminaire: what the baker (src/bake) feeds, and what comes out. All in lamp coordinates and units.
#pragma once

#include <stdbool.h>

#include "base/run.h"
#include "luminaire/luminaire.h"

struct view_field;

enum proxy_kind { PROXY_SPHERE, PROXY_BOX, PROXY_CYLINDER, PROXY_MESH };

struct proxy {
    enum proxy_kind kind;
    float center[3], radius; // bounding sphere of the proxy, always set; the sphere itself for PROXY_SPHERE
    float lower[3], upper[3]; // PROXY_BOX: axis aligned
    float axis[3], half_height, axis_radius; // PROXY_CYLINDER: unit axis through center
    float (*vertices)[3]; // PROXY_MESH: closed, outward winding; copied by whoever keeps it
    uint32_t *indices; // 3 * triangle_count
    size_t vertex_count, triangle_count;
};

// One training line: `point` anywhere on the line, w the unit direction of the light. The loss over lines is
//   sum mass * (L_hat) - target * log(L_hat)   (in the stabilised form of docs/design.md), so that
// - a traced camera line drawn with density p and radiance estimate y has mass = 1/p, target = y/p;
// - an untraced line drawn with density p has mass = 1/p, target = 0;
// - a particle's exit of flux y has mass = 0, target = y / (particles emitted per batch's share).
// The measure is dA_perp dw of lines (area perpendicular to w on the bounding sphere's disk times solid angle).
// Normalisation: all lines of the bounding sphere measure M = 4 pi^2 radius^2 (LINE_MEASURE). Over a batch of n lines
// mass is 1 / (p n M), so that the masses of a batch sum to 1 in expectation, and target is in units of radiance_unit:
//   camera line of radiance y: target = mass * y / radiance_unit;
//   exits: target = flux / (n_emitted M radiance_unit), n_emitted the particles that this batch's exits stand for;
// with radiance_unit = mean over channels of the lamp's flux / M, the targets of a batch sum to about 1 too. One
// constant factor common to mass and target in all batches of a training does no harm (Adam is free of scale); a factor
// between mass and target scales the radiance. The loss reported is the sum over the batch.
#define LINE_MEASURE(radius) (39.4784176f * (radius) * (radius))
struct line_sample {
    float point[3], w[3];
    float mass;
    float target[3];
};

// A light that left the lamp: where it crosses the bounding sphere, its direction, its flux (all exits of n_emitted
// particles together carry n_emitted times the lamp's flux).
struct line_exit {
    float point[3], w[3];
    float flux[3];
};

// What the training of a light field minimises.
enum light_loss {
    LIGHT_LOSS_LIKELIHOOD, // the above: unbiased by noise
    // (log(1 + L_hat) - log(1 + y))^2 of every traced line, as Zhu et al. 2021, for comparison. Lines of mass 0 teach
    // nothing then, and noise of y makes the lamp too dark.
    LIGHT_LOSS_LOGARITHM,
    LIGHT_LOSSES
};

struct light_field_options {
    struct proxy proxy;
    const float (*anchors)[3]; // centres of emission clusters
    size_t anchor_count; // 0..256
    float anchor_radius; // [length] scale of the perpendicular offset
    const float *shell_radii; // [fraction of proxy radius] radii where light leaves (quantiles of first hits)
    size_t shell_count; // 0..4
    bool use_grid4; // the 4D entry x exit grid
    float radiance_unit; // the mean radiance over all lines of the bounding sphere: L is learned in this unit
    int log2_entries; // table sizes, 10..20
    size_t steps; // planned optimiser steps (for the learning-rate schedule)
    uint64_t seed;
    enum light_loss loss;
};

struct light_field;
enum status light_field_create(struct light_field **field, const struct light_field_options *options,
                               struct error *error);
void light_field_destroy(struct light_field *field);
// One optimiser step. Deterministic for any `threads`. Returns the mean loss of the batch in *loss.
void light_field_train(struct light_field *field, const struct line_sample *samples, size_t n, int threads,
                       double *loss);
// The planned number of optimiser steps, where it becomes known only during training (a time budget).
void light_field_plan(struct light_field *field, size_t steps);
// Radiance in absolute units. From the float tables while training; a luminaire made of the field evaluates 8-bit ones.
void light_field_eval(const struct light_field *field, size_t n, const float (*point)[3], const float (*w)[3],
                      float (*radiance)[3]);
// Ends the training: from here on the quantised tables answer. Before the final scale, so that it takes out what
// rounding does to the flux.
enum status light_field_finish(struct light_field *field, struct error *error);
void light_field_set_scale(struct light_field *field,
                           const float scale[3]); // final scale per colour, to the traced flux
size_t light_field_bytes(const struct light_field *field); // in a file, about

struct transparency;
struct hull;
struct transparency_options {
    const struct proxy *proxy;
    // Of the lamp, copied, or NULL. With it silhouettes are exact, and the training needs only lines that
    // transparency_learns says true of.
    const struct hull *hull;
    int log2_entries; // table sizes, 10..20; with a hull at most 13 are used
    size_t steps; // planned optimiser steps
    uint64_t seed;
};
enum status transparency_create(struct transparency **t, const struct transparency_options *options,
                                struct error *error);
bool transparency_learns(const struct transparency *t, const float point[3], const float w[3]);
void transparency_destroy(struct transparency *t);
size_t transparency_bytes(const struct transparency *t); // in a file, about
// samples: point, w, target = throughput in [0,1], mass = weight. Squared error through a sigmoid (unbiased).
void transparency_plan(struct transparency *t, size_t steps);
void transparency_train(struct transparency *t, const struct line_sample *samples, size_t n, int threads, double *loss);
void transparency_eval(const struct transparency *t, size_t n, const float (*point)[3], const float (*w)[3],
                       float (*transmittance)[3]);

// The sampling density from the exits (DESIGN 3: cones at the anchors + residual map per direction and distance of s +
// a uniform share), built in one go.
struct sampling_density;
enum status sampling_density_build(struct sampling_density **density, const struct proxy *proxy,
                                   const float (*anchors)[3], size_t anchor_count, const struct line_exit *exits,
                                   size_t exit_count, uint64_t seed, int threads, struct error *error);
void sampling_density_destroy(struct sampling_density *density);
size_t sampling_density_bytes(size_t anchor_count); // in a file, at most
// Sets the ceiling of a finished field, before its final scale: no line that passes every anchor beyond the density's
// cones shows more than some radiance (mean of the channels, the colour is kept). What is brighter has been learned by
// heart from single exits, and makes most of the noise of light samples. The ceiling takes LIGHT_CEILING_SHARE of the
// flux of `exits`, light_field_exits' lines, or less where there is little such light; what it leaves of each channel's
// is `left`. Where it would take less than three tenths of the second moment of such light, and without anchors, there
// is none.
#define LIGHT_CEILING_SHARE 0.0025
enum status light_field_fit_ceiling(struct light_field *field, const struct sampling_density *density,
                                    const struct line_exit *exits, size_t exit_count, int threads, double left[3],
                                    struct error *error);

// Relative variance of L cos / p of the density's samples, over points at 1.2 to 12 radii that face the lamp and count
// by the square of its light there (and of their distance): what a room shows of it.
struct proxy_shape;
double sampling_density_noise(const struct sampling_density *density, const struct light_field *field,
                              const struct proxy_shape *shape, int threads);

// The same anew, by what the finished light field shows along lines that the density draws from 1.02 to 8 radii, in
// SAMPLING_ROUNDS rounds: the last has `lines` (0: none of this), those before a quarter each. The anchors' cones stay.
// After an error the density is that of the last round that was made.
enum { SAMPLING_ROUNDS = 3 };
struct sampling_refinement {
    size_t lines;
    uint64_t seed;
    int threads;
};
enum status sampling_density_refine(struct sampling_density **density, const struct light_field *field,
                                    const struct proxy_shape *shape, const struct sampling_refinement *plan,
                                    struct error *error);

// Takes ownership of the parts, also when it fails; they cannot be trained any more. transparency NULL: T = 0 on the
// proxy's lines. density NULL: directions uniform over the bounding sphere's cone. `metadata`: keys and values, copied;
// documented in docs/luminaire-format.md.
enum status luminaire_assemble(struct luminaire **luminaire, const struct proxy *proxy, struct light_field *field,
                               struct transparency *transparency, struct sampling_density *density, const float flux[3],
                               const char *const *keys, const char *const *values, size_t metadata_count,
                               struct error *error);
// The same for the published networks (luminaire/paper.h).
struct paper;
enum status luminaire_assemble_paper(struct luminaire **luminaire, const struct proxy *proxy, struct paper *paper,
                                     const float flux[3], const char *const *keys, const char *const *values,
                                     size_t metadata_count, struct error *error);

// Adds the light of another group of emitters to a luminaire with the same proxy; the one that it was assembled from
// is the first. Takes ownership, also when it fails. `view` goes with luminaire_set_view, which comes before; else
// NULL.
enum status luminaire_add_group(struct luminaire *luminaire, struct light_field *field,
                                struct sampling_density *density, struct view_field *view, const float flux[3],
                                struct error *error);
// Makes the emissions groups: names without ",;=" and space, shorter than LUMINAIRE_NAME_SIZE, all different.
enum status luminaire_name_groups(struct luminaire *luminaire, const char *const *names, struct error *error);

// Adds a hull with its view field, which need not be finished. Takes ownership, also when it fails.
enum status luminaire_set_view(struct luminaire *luminaire, struct hull *hull, struct view_field *view,
                               struct error *error);

// Training state, for --resume: everything that a later step depends on.
enum status light_field_save_state(const struct light_field *field, const char *path, struct error *error);
enum status light_field_load_state(struct light_field *field, const char *path, struct error *error);
enum status transparency_save_state(const struct transparency *t, const char *path, struct error *error);
enum status transparency_load_state(struct transparency *t, const char *path, struct error *error);
