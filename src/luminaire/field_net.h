// The network of a field over lines, while it is trained (float tables) and afterwards (8-bit tables): encoding ->
// grids -> MLP -> one value per output, for the light field and the transparency alike.
#pragma once

#include "luminaire/encoding.h"
#include "net/trainer.h"

enum { FIELD_OUTPUTS = 3, FIELD_WIDTH = 32 };

struct field_net {
    float center[3], radius; // bounding sphere of the proxy
    struct encoding encoding;
    struct mlp_shape shape;
    struct trainer *trainer; // while training, else NULL
    float *mlp; // of the finished network; NULL while training
    float *mlp_by_input; // the same by mlp_transpose, and the layout by lookup: for single lines
    struct grid_by_lookup *by_lookup;
    int8_t *codes; // entry_count * 2 + GRID_PADDING
    float scale[GRID_MAX_LEVELS];
};

// Checks the options. The network trains.
enum status field_net_create(struct field_net *net, const float center[3], float radius,
                             const struct encoding_options *options, const struct trainer_rates *rates, uint64_t seed,
                             struct error *error);
// A finished network from its numbers, all copied. Counts must fit the options' layout.
struct field_net_numbers {
    const float *mlp, *scale;
    const int8_t *codes;
    size_t mlp_count, entry_count, level_count;
};
enum status field_net_restore(struct field_net *net, const float center[3], float radius,
                              const struct encoding_options *options, const struct field_net_numbers *numbers,
                              struct error *error);
// Ends the training: quantises the tables and frees everything that only training needs.
enum status field_net_finish(struct field_net *net, struct error *error);
void field_net_fini(struct field_net *net);
size_t field_net_parameters(const struct field_net *net); // of the MLP
size_t field_net_bytes(const struct field_net *net); // of the MLP and the tables in a file

// z [FIELD_OUTPUTS][NET_LANES] of `count` <= NET_LANES lines, each the same bit for bit in whatever company; hit[l] = 0
// where a line misses the bounding sphere. `crossings`: NET_LANES of them, positions in the unit ball, where the
// encoding uses the hull; else NULL. passed[l]: how far a line passes from the nearest anchor, by anchor_contract; or
// NULL.
void field_net_eval(const struct field_net *net, int count, const float (*point)[3], const float (*w)[3],
                    const struct hull_crossing *crossings, float *z, float *hit, float *passed);
