// All figures, in the order of the page. A new one is a file that defines it and its line here.
#pragma once

#include "evidence/figure.h"

#define FIGURE_TABLE(X)                                                                                                \
    X(views)                                                                                                           \
    X(sampling)                                                                                                        \
    X(masks)                                                                                                           \
    X(living_room)                                                                                                     \
    X(bedroom)                                                                                                         \
    X(elevator_room)                                                                                                   \
    X(diffuse_box)                                                                                                     \
    X(specular_box)                                                                                                    \
    X(near_far)                                                                                                        \
    X(equal_time)                                                                                                      \
    X(loft)                                                                                                            \
    X(crystal_room)                                                                                                    \
    X(ablation_sampling)                                                                                               \
    X(ablation_samples)                                                                                                \
    X(ablation_loss)                                                                                                   \
    X(ablation_size)

#define FIGURE_DECLARE(NAME) extern const struct figure figure_##NAME;
FIGURE_TABLE(FIGURE_DECLARE)
#undef FIGURE_DECLARE
