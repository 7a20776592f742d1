// Unbiased rendering with baked lamps whose geometry is there as well (scene->unbiased). What the room sends into a
// lamp is path traced as on any other surface. A lamp's own light leaves it along lines; with its radiance R there
// (which the model L comes near) as the source, paths are split in two classes:
//   - near lines, which pass an emission cluster, are sampled by the baked density from where they light a surface. L
//     stands in for R as a control variate: L + (R' - L) / q with probability q, else L, where R' is one traced path's
//     estimate of R. The mean is R whatever L is;
//   - all others (glints in crystals, frosted glass) are rare and bright as seen from a surface: particles from the
//     emitters bring them (caustic.h) where the camera's first vertex scatters by no delta, as they bring the lamp's
//     own light that the camera sees so; L + (R' - L) / q the rest.
#pragma once

#include "math/distribution.h"
#include "trace/line_radiance.h"

struct residual;
enum status residual_create(struct residual **residual, const struct scene *scene, struct error *error);
void residual_destroy(struct residual *residual); // NULL is allowed

// Whether a line (any point of it and its direction) is near. A lamp whose R' is noisy even there has no near lines.
bool residual_line_is_near(const struct residual *residual, int luminaire, vec3 p, vec3 w);
// `model` is L of the line on which `walk` has begun. Draws from its own dimensions of `sampler`: `draw` tells apart
// the calls of one stream and sample. max_depth: of R', in edges from the line's origin. `looks`: the camera sees the
// line, directly or by mirrors; then R' alone is the answer.
rgb residual_correct(const struct residual *residual, const struct line_walk *walk, rgb model, bool looks,
                     struct sampler sampler, uint32_t draw, int max_depth);
float residual_power(const struct residual *residual, int luminaire); // of the lamp's emitters
// A particle from one of the lamp's emitters. u_emitter in [0,1). False: no light came out.
bool residual_emit(const struct residual *residual, int luminaire, float u_emitter, struct sampler *sampler,
                   struct emission_sample *emission, rgb *beta);
