// The three networks, shared by paper.c, paper_sampling.c, paper_train.c and paper_file.c.
#pragma once

#include "luminaire/paper.h"
#include "luminaire/sampling.h"
#include "net/dense_trainer.h"

struct paper {
    float center[3], radius;
    float *parameters[PAPER_NETS]; // as in the file
    struct dense_packed packed[PAPER_NETS]; // the same
    struct dense_trainer trainer; // of the network `training`, whose parameters stand in here
    int training; // enum paper_net, or -1
};

extern const struct dense_shape paper_shapes[PAPER_NETS];
const struct dense_packed *paper_net(const struct paper *paper, enum paper_net net);

// x [inputs][DENSE_SLICE] of `count` lines; hit[l] = 0 where a line misses the bounding sphere.
void paper_encode_lines(const struct paper *paper, int count, const float (*point)[3], const float (*w)[3], float *x,
                        float hit[DENSE_SLICE]);
void paper_encode_points(const struct paper *paper, int count, const float (*s)[3], float *x);
// e^z - 1, in place; what no radiance can be becomes 0.
void paper_radiance_from_log(float *z, size_t count);
void paper_sigmoid(float *z, size_t count);
