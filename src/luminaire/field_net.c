#include "luminaire/field_net.h"

#include <stdlib.h>
#include <string.h>

#include "net/kernel.h"

enum {
    MAX_CORNERS = GRID_MAX_LOOKUPS * (GRID_MAX_DIMS + 1),
    FEW = 4, // lines up to which one by one is faster than a block
};

static enum status set_up(struct field_net *net, const float center[3], float radius,
                          const struct encoding_options *options, struct error *error) {
    *net = (struct field_net){.radius = radius};
    memcpy(net->center, center, sizeof net->center);
    enum status status = encoding_options_check(options, error);
    if (status) return status;
    encoding_init(&net->encoding, options);
    net->shape = (struct mlp_shape){grid_input_count(&net->encoding.layout), FIELD_WIDTH, FIELD_OUTPUTS};
    return STATUS_OK;
}

enum status field_net_create(struct field_net *net, const float center[3], float radius,
                             const struct encoding_options *options, const struct trainer_rates *rates, uint64_t seed,
                             struct error *error) {
    enum status status = set_up(net, center, radius, options, error);
    if (status) return status;
    net->trainer = malloc(sizeof *net->trainer);
    if (!net->trainer) return error_set(error, STATUS_MEMORY, "out of memory for a network");
    status = trainer_init(net->trainer, &net->encoding.layout, FIELD_WIDTH, FIELD_OUTPUTS, rates, seed, error);
    if (status) {
        free(net->trainer);
        net->trainer = NULL;
    }
    return status;
}

size_t field_net_parameters(const struct field_net *net) { return mlp_layout(&net->shape).count; }

size_t field_net_bytes(const struct field_net *net) {
    return field_net_parameters(net) * sizeof *net->mlp + net->encoding.layout.entry_count * 2;
}

static void free_finished(struct field_net *net) {
    free(net->mlp);
    free(net->mlp_by_input);
    free(net->by_lookup);
    free(net->codes);
    net->mlp = net->mlp_by_input = NULL, net->by_lookup = NULL, net->codes = NULL;
}

static enum status allocate_finished(struct field_net *net, struct error *error) {
    net->mlp = calloc(field_net_parameters(net), sizeof(float));
    net->mlp_by_input = calloc(field_net_parameters(net), sizeof(float));
    net->by_lookup = aligned_alloc(_Alignof(struct grid_by_lookup), sizeof *net->by_lookup);
    net->codes = calloc((size_t)net->encoding.layout.entry_count * 2 + GRID_PADDING, 1);
    if (net->mlp && net->mlp_by_input && net->by_lookup && net->codes) return STATUS_OK;
    free_finished(net);
    return error_set(error, STATUS_MEMORY, "out of memory for a network");
}

static void derive(struct field_net *net) {
    mlp_transpose(&net->shape, net->mlp, net->mlp_by_input);
    grid_by_lookup_make(&net->encoding.layout, net->scale, net->by_lookup);
}

enum status field_net_restore(struct field_net *net, const float center[3], float radius,
                              const struct encoding_options *options, const struct field_net_numbers *numbers,
                              struct error *error) {
    enum status status = set_up(net, center, radius, options, error);
    if (status) return status;
    const struct grid_layout *layout = &net->encoding.layout;
    if (numbers->mlp_count != field_net_parameters(net) || numbers->entry_count != (size_t)layout->entry_count ||
        numbers->level_count != (size_t)layout->level_count)
        return error_set(error, STATUS_INVALID, "the tables' sizes do not fit the network that the file describes");
    status = allocate_finished(net, error);
    if (status) return status;
    memcpy(net->mlp, numbers->mlp, numbers->mlp_count * sizeof(float));
    memcpy(net->scale, numbers->scale, numbers->level_count * sizeof(float));
    memcpy(net->codes, numbers->codes, 2 * numbers->entry_count);
    derive(net);
    return STATUS_OK;
}

enum status field_net_finish(struct field_net *net, struct error *error) {
    if (!net->trainer) return STATUS_OK;
    enum status status = allocate_finished(net, error);
    if (status) return status;
    memcpy(net->mlp, net->trainer->mlp, net->trainer->mlp_count * sizeof(float));
    grid_quantise(&net->encoding.layout, net->trainer->table, net->codes, net->scale);
    derive(net);
    trainer_fini(net->trainer);
    free(net->trainer);
    net->trainer = NULL;
    return STATUS_OK;
}

void field_net_fini(struct field_net *net) {
    if (net->trainer) trainer_fini(net->trainer);
    free(net->trainer);
    free_finished(net);
    *net = (struct field_net){.radius = 0};
}

static void forward_few(const struct field_net *net, int count, const struct grid_input *input, float *z) {
    const struct kernel *kernel = kernel_best();
    memset(z, 0, sizeof(float) * FIELD_OUTPUTS * NET_LANES);
    for (int l = 0; l < count; l++) {
        float x[MLP_MAX_INPUTS], one[FIELD_OUTPUTS];
        kernel->lookup_lane(net->by_lookup, net->codes, input, l, x);
        kernel->forward_lane(&net->shape, net->mlp_by_input, x, one);
        for (int c = 0; c < FIELD_OUTPUTS; c++) z[c * NET_LANES + l] = one[c];
    }
}

static void forward_block(const struct field_net *net, const struct grid_input *input, float *z) {
    const struct kernel *kernel = kernel_best();
    const struct grid_layout *layout = &net->encoding.layout;
    _Alignas(64) float x[MLP_MAX_INPUTS * NET_LANES], h1[FIELD_WIDTH * NET_LANES], h2[FIELD_WIDTH * NET_LANES];
    if (net->trainer) {
        _Alignas(64) int32_t index[MAX_CORNERS * NET_LANES];
        _Alignas(64) float weight[MAX_CORNERS * NET_LANES];
        kernel->index(layout, input, index, weight);
        kernel->gather_float(layout, net->trainer->table, input, index, weight, x);
    } else
        kernel->lookup(layout, net->codes, net->scale, input, x);
    kernel->forward(&net->shape, net->trainer ? net->trainer->mlp : net->mlp, x, h1, h2, z);
}

void field_net_eval(const struct field_net *net, int count, const float (*point)[3], const float (*w)[3],
                    const struct hull_crossing *crossings, float *z, float *hit, float *passed) {
    struct line_block lines;
    struct grid_input input;
    line_block_load(&lines, net->center, net->radius, count, point, w);
    lines.crossings = crossings;
    encoding_encode(&net->encoding, &lines, &input);
    if (count <= FEW && !net->trainer)
        forward_few(net, count, &input, z);
    else
        forward_block(net, &input, z);
    memcpy(hit, lines.hit, sizeof lines.hit);
    if (passed) memcpy(passed, input.raw[net->encoding.anchor_raw], NET_LANES * sizeof *passed);
}
