// The view field: radiance of a hull's surface towards whoever looks at it, L(x, n, w, part). Where the light field is
// keyed by lines and knows nothing of surfaces, this one lies on them, so that silhouettes and materials are crisp.
#pragma once

#include "base/error.h"
#include "net/trainer.h"

struct view_point { // on the hull, in lamp coordinates; w: unit direction of the light, away from the surface
    float point[3], normal[3], w[3]; // normal: unit, of either side
    uint32_t part;
};

// One term of the loss sum mass * L_hat - target * log(L_hat), as struct line_sample (build.h), with L_hat in units of
// radiance_unit: a looking line of n has mass 1/n and, where it was traced, target = radiance / (n radiance_unit); an
// exit has mass 0 and target = flux / (emitted LINE_MEASURE radiance_unit).
struct view_sample {
    struct view_point at;
    float mass, target[3];
};

enum { VIEW_MAX_ANCHORS = 64 };

struct view_field_options {
    float center[3], radius; // bounding sphere of the proxy
    int part_count; // 1..HULL_MAX_PARTS
    int log2_entries; // 10..20
    float radiance_unit;
    float anchors[VIEW_MAX_ANCHORS][3]; // centres of emission clusters, in lamp coordinates
    int anchor_count; // 0..VIEW_MAX_ANCHORS
};

struct view_field {
    struct view_field_options options;
    float scale[3];
    struct grid_layout layout;
    struct mlp_shape shape;
    struct trainer *trainer; // while training, else NULL
    float *mlp; // of the finished network; NULL while training
    int8_t *codes; // entry_count * 2 + GRID_PADDING
    float table_scale[GRID_MAX_LEVELS];
};

enum status view_field_create(struct view_field **field, const struct view_field_options *options, size_t steps,
                              uint64_t seed, struct error *error);
// A finished field from its numbers, all copied. Counts must fit the options' layout.
enum status view_field_restore(struct view_field **field, const struct view_field_options *options, const float *mlp,
                               size_t mlp_count, const int8_t *codes, size_t code_count, const float *table_scale,
                               size_t level_count, struct error *error);
void view_field_destroy(struct view_field *field);
size_t view_field_bytes(int log2_entries, size_t anchor_count); // of the MLP and the tables in a file
void view_field_plan(struct view_field *field, size_t steps); // as light_field_plan
// One optimiser step on n samples. Deterministic for any `threads`.
void view_field_train(struct view_field *field, const struct view_sample *samples, size_t n, int threads, double *loss);
enum status view_field_finish(struct view_field *field, struct error *error); // quantises; no training after it
void view_field_eval(const struct view_field *field, size_t n, const struct view_point *points, float (*radiance)[3]);
