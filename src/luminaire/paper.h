// The published system, for comparison: the three networks of Zhu et al. 2021, "Neural Complex Luminaires", with their
// sizes, losses and optimiser, in place of the light field, transparency and sampling density of the rest of this
// folder. Positions are relative to the bounding sphere's centre, in its radii.
//   eval          u where the line leaves the sphere, w its direction, each encoded by 10 frequencies -> log(1 + L)
//   transparency  the same -> T through a sigmoid
//   sampling      a shading point -> log(1 + x) of the 16x16 picture of the lamp as seen from it
// Losses: squared error of log(1 + x); for the picture also that of its mean. Adam: net/dense_trainer.h.
// What is ours: shading points outside the sphere are contracted to radius 2; the picture covers the sphere's cone
// uniformly in solid angle (sampling_view.c) instead of a square in perspective; samples come from it mixed with a
// small uniform share at their exact density, so that their weights are unbiased with respect to the model.
#pragma once

#include "luminaire/build.h"

enum paper_net { PAPER_EVAL, PAPER_TRANSPARENCY, PAPER_SAMPLING, PAPER_NETS };
enum { PAPER_SIDE = 16, PAPER_PIXELS = PAPER_SIDE * PAPER_SIDE };

size_t paper_parameters(enum paper_net net); // 1902083, 1902083, 461568

// All weights are 0 until they are trained: a black lamp.
enum status paper_create(struct paper **paper, const struct proxy *proxy, struct error *error);
void paper_destroy(struct paper *paper); // NULL is allowed

// One network is trained at a time; `most` samples a step at most.
enum status paper_train_begin(struct paper *paper, enum paper_net net, size_t most, uint64_t seed, struct error *error);
void paper_train_end(struct paper *paper, enum paper_net net);
// One step of the network being trained; the loss is the mean. PAPER_EVAL: target = mass * radiance, mass = 1 /
// density. PAPER_TRANSPARENCY: target = transmittance.
void paper_train_lines(struct paper *paper, enum paper_net net, const struct line_sample *samples, size_t n,
                       int threads, double *loss);
struct paper_view { // row-major: pixel y * PAPER_SIDE + x
    float s[3];
    float radiance[PAPER_PIXELS][3];
};
void paper_train_views(struct paper *paper, const struct paper_view *views, size_t n, int threads, double *loss);
// The direction in which the place p in [0,1)^2 of the picture is seen from s.
void paper_view_direction(const struct paper *paper, const float s[3], const float p[2], float direction[3]);

// As the calls of luminaire.h, on the bounding sphere.
void paper_eval(const struct paper *paper, size_t n, const float (*point)[3], const float (*w)[3],
                float (*radiance)[3]);
void paper_transmittance(const struct paper *paper, size_t n, const float (*point)[3], const float (*w)[3],
                         float (*transmittance)[3]);
void paper_sample(const struct paper *paper, size_t n, const float (*s)[3], const float (*u)[3], float (*direction)[3],
                  float *pdf_sa);
void paper_pdf(const struct paper *paper, size_t n, const float (*s)[3], const float (*direction)[3], float *pdf_sa);
