// A baked luminaire: the light field L(u, w), the transparency T(u, w) and a sampling density, on a proxy.
// Everything here is in the lamp's own coordinates and length unit. A *line* is given by any point on it and the unit
// direction w in which its light travels (out of the lamp). Batches are arrays of float[3].
#pragma once

#include <stddef.h>
#include <stdint.h>

#include "base/error.h"
#include "base/run.h"

struct luminaire;

enum { LUMINAIRE_MAX_GROUPS = 16, LUMINAIRE_NAME_SIZE = 64 };

enum status luminaire_load(struct luminaire **luminaire, const char *path, struct error *error);
enum status luminaire_parse(struct luminaire **luminaire, const char *name, const uint8_t *bytes, size_t length,
                            struct error *error);
enum status luminaire_save(const struct luminaire *luminaire, const char *path, struct error *error);
void luminaire_destroy(struct luminaire *luminaire); // NULL is allowed

// Groups of emitters that were baked separately: L is the sum of theirs. 0: the lamp's light is one. `flux` (or NULL):
// of the group, as baked; the name lives as long as the luminaire.
size_t luminaire_group_count(const struct luminaire *luminaire);
const char *luminaire_group(const struct luminaire *luminaire, size_t index, float flux[3]);
// A copy whose groups are multiplied by factors[luminaire_group_count], per colour and >= 0; without groups there is
// one factor, for the whole lamp. Flux, radiance and light samples are those of the dimmed lamp. It shares everything
// with the original, which must outlive it; both may be used by any number of threads.
enum status luminaire_dim(struct luminaire **dimmed, const struct luminaire *original, const float (*factors)[3],
                          struct error *error);

// The proxy. `center` and `radius` of its bounding sphere. luminaire_span gives where the line origin + t direction
// (unit) crosses it, entry <= exit in t (either may be negative); false: misses.
void luminaire_bounds(const struct luminaire *luminaire, float center[3], float *radius);
int luminaire_span(const struct luminaire *luminaire, const float origin[3], const float direction[3], float *t_near,
                   float *t_far);

// Hot calls: no checks; thread-safe; any n >= 1. Lines that miss the proxy have radiance 0 and transmittance 1.
void luminaire_eval(const struct luminaire *luminaire, size_t n, const float (*point)[3], const float (*w)[3],
                    float (*radiance)[3]);
void luminaire_transmittance(const struct luminaire *luminaire, size_t n, const float (*point)[3], const float (*w)[3],
                             float (*transmittance)[3]);
// The same for lines of which luminaire_span has said that they meet the proxy: it is not asked again.
void luminaire_eval_met(const struct luminaire *luminaire, size_t n, const float (*point)[3], const float (*w)[3],
                        float (*radiance)[3]);
void luminaire_transmittance_met(const struct luminaire *luminaire, size_t n, const float (*point)[3],
                                 const float (*w)[3], float (*transmittance)[3]);
// Whether a line meets anything of the lamp. Always true where the file holds no hull. Beside the lamp's silhouette the
// light field has a dim glow: rays that look at the lamp leave it out where this says false.
int luminaire_seen(const struct luminaire *luminaire, const float point[3], const float w[3]);
// Directions from shading points s (anywhere: near, far, inside the proxy) towards the lamp: `direction` points from s
// to the lamp, so the light travels along -direction. u: three numbers in [0,1) each. pdf_sa [1/sr] is > 0 and exact.
void luminaire_sample(const struct luminaire *luminaire, size_t n, const float (*s)[3], const float (*u)[3],
                      float (*direction)[3], float *pdf_sa);
void luminaire_pdf(const struct luminaire *luminaire, size_t n, const float (*s)[3], const float (*direction)[3],
                   float *pdf_sa);

// The hull for rays that look at the lamp, with its view field; NULL where the file holds none.
struct hull;
struct view_point;
const struct hull *luminaire_hull(const struct luminaire *luminaire);
void luminaire_view(const struct luminaire *luminaire, size_t n, const struct view_point *points,
                    float (*radiance)[3]); // only with a hull

// Of the room's light that meets the lamp and is not let through (1 - T), evenly from all sides: the shares that leave
// it again, to the side they came from and to the other. Each in [0, 1], their sum too. Zero where the file has none.
void luminaire_scattering(const struct luminaire *luminaire, float back[3], float onward[3]);
enum status luminaire_set_scattering(struct luminaire *luminaire, const float back[3], const float onward[3],
                                     struct error *error);

void luminaire_flux(const struct luminaire *luminaire, float flux[3]); // total emitted flux per channel, lamp units
const char *luminaire_metadata(const struct luminaire *luminaire,
                               const char *key); // or NULL; keys in docs/luminaire-format.md
const char *luminaire_metadata_key(const struct luminaire *luminaire, size_t index); // NULL past the last
size_t luminaire_bytes(const struct luminaire *luminaire); // of the file; of the tensors alone where it was not loaded
