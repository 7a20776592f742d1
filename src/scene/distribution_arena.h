// Distributions whose memory belongs to a scene's arena, so that emitters and shapes need no destructor.
#pragma once

#include "base/arena.h"
#include "math/distribution.h"

enum status distribution_init_arena(struct distribution *d, const float *weights, size_t n, struct arena *arena,
                                    struct error *error);
enum status distribution2d_init_arena(struct distribution2d *d, const float *weights, size_t width, size_t height,
                                      struct arena *arena, struct error *error);
