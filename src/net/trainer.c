// One step: slices (encode, gather, forward, loss, backward) in parallel -> reduce the MLP -> scatter and update each
// level in parallel. A batch longer than a chunk is worked through chunk by chunk before the one update.
#include "net/trainer.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"
#include "math/sampler.h"
#include "net/kernel.h"

enum {
    SLICE = 256,
    CHUNK = 4096,
    SLICE_BLOCKS = SLICE / NET_LANES,
    CHUNK_BLOCKS = CHUNK / NET_LANES,
    CHUNK_SLICES = CHUNK / SLICE
};
static const float beta1 = 0.9f, beta2 = 0.999f, epsilon = 1e-15f;

struct trainer_scratch {
    int32_t *index; // [block][corner][lane]
    float *weight; // the same
    float *d_x; // [block][2 * lookups][lane]
    float *slice_gradient; // [slice][mlp_count]
    float *slice_work; // per slice: x, h1, h2, d_z, d_h
    size_t slice_floats;
    double loss[CHUNK_SLICES];
    float *table_gradient; // [entry][2], zero between steps
    uint64_t *touched; // a bit an entry, zero between steps; each level starts on a word of its own
    uint32_t first_word[GRID_MAX_LEVELS];
    float *mlp_gradient;
};

static size_t round16(size_t n) { return (n + 15) & ~(size_t)15; }

static void *zeroed(size_t count, size_t size, int *failed) {
    void *memory = NULL;
    size_t bytes = count < SIZE_MAX / 2 / size ? count * size : SIZE_MAX;
    if (bytes == SIZE_MAX || posix_memalign(&memory, 64, bytes + 1)) {
        *failed = 1;
        return NULL;
    }
    memset(memory, 0, bytes);
    return memory;
}

enum status trainer_init(struct trainer *trainer, const struct grid_layout *layout, int width, int outputs,
                         const struct trainer_rates *rates, uint64_t seed, struct error *error) {
    *trainer =
        (struct trainer){.layout = *layout, .shape = {grid_input_count(layout), width, outputs}, .rates = *rates};
    trainer->mlp_count = mlp_layout(&trainer->shape).count;
    int failed = 0;
    struct trainer_scratch *scratch = trainer->scratch = zeroed(1, sizeof *scratch, &failed);
    if (failed) return error_set(error, STATUS_MEMORY, "out of memory for the training of a network");
    size_t entries = layout->entry_count, corners = (size_t)layout->corner_count,
           inputs = (size_t)trainer->shape.inputs;
    size_t words = 0;
    for (int k = 0; k < layout->level_count; k++) {
        scratch->first_word[k] = (uint32_t)words;
        words += ((size_t)layout->levels[k].slice_entries * layout->levels[k].slices + 63) / 64;
    }
    scratch->slice_floats = SLICE * (inputs + 4 * (size_t)width + (size_t)outputs);
    trainer->table = zeroed(entries * 2, sizeof(float), &failed);
    trainer->moments = zeroed(entries * 4, sizeof(float), &failed);
    trainer->mlp = zeroed(trainer->mlp_count, sizeof(float), &failed);
    trainer->mlp_moments = zeroed(trainer->mlp_count * 2, sizeof(float), &failed);
    scratch->index = zeroed(CHUNK * corners, sizeof(int32_t), &failed);
    scratch->weight = zeroed(CHUNK * corners, sizeof(float), &failed);
    scratch->d_x = zeroed(CHUNK * 2 * (size_t)layout->lookup_count, sizeof(float), &failed);
    scratch->slice_gradient = zeroed(CHUNK_SLICES * round16(trainer->mlp_count), sizeof(float), &failed);
    scratch->slice_work = zeroed(CHUNK_SLICES * scratch->slice_floats, sizeof(float), &failed);
    scratch->table_gradient = zeroed(entries * 2, sizeof(float), &failed);
    scratch->touched = zeroed(words, sizeof(uint64_t), &failed);
    scratch->mlp_gradient = zeroed(trainer->mlp_count, sizeof(float), &failed);
    if (failed) {
        trainer_fini(trainer);
        return error_set(error, STATUS_MEMORY, "out of memory for the training of a network");
    }
    mlp_init(&trainer->shape, trainer->mlp, seed);
    struct sampler sampler = sampler_make(seed, 0x67726964, 0);
    for (size_t i = 0; i < entries * 2; i++) trainer->table[i] = 1e-4f * (2 * sampler_1d(&sampler) - 1);
    return STATUS_OK;
}

void trainer_fini(struct trainer *trainer) {
    struct trainer_scratch *scratch = trainer->scratch;
    if (scratch) {
        free(scratch->index);
        free(scratch->weight);
        free(scratch->d_x);
        free(scratch->slice_gradient);
        free(scratch->slice_work);
        free(scratch->table_gradient);
        free(scratch->touched);
        free(scratch->mlp_gradient);
    }
    free(scratch);
    free(trainer->table);
    free(trainer->moments);
    free(trainer->mlp);
    free(trainer->mlp_moments);
    memset(trainer, 0, sizeof *trainer);
}

struct step {
    struct trainer *trainer;
    const struct trainer_batch *batch;
    const struct kernel *kernel;
    size_t first, count; // samples of the chunk
    float table_rate;
};

static void prefetch_block(const float *table, const int32_t *index, int count) {
    for (int k = 0; k < count; k++) __builtin_prefetch(table + 2 * (size_t)index[k]);
}

static void work_slice(void *user, size_t slice, int worker) {
    (void)worker;
    const struct step *step = user;
    const struct trainer *trainer = step->trainer;
    struct trainer_scratch *scratch = trainer->scratch;
    const struct grid_layout *layout = &trainer->layout;
    const struct mlp_shape *shape = &trainer->shape;
    size_t done = slice * SLICE, samples = step->count - done < SLICE ? step->count - done : SLICE;
    size_t blocks = (samples + NET_LANES - 1) / NET_LANES, corners = (size_t)layout->corner_count * NET_LANES;
    size_t inputs = (size_t)shape->inputs * NET_LANES, hidden = (size_t)shape->width * NET_LANES;
    size_t outputs = (size_t)shape->outputs * NET_LANES, features = 2 * (size_t)layout->lookup_count * NET_LANES;
    float *x = scratch->slice_work + slice * scratch->slice_floats, *h1 = x + SLICE_BLOCKS * inputs;
    float *h2 = h1 + SLICE_BLOCKS * hidden, *d_h = h2 + SLICE_BLOCKS * hidden, *d_z = d_h + 2 * SLICE_BLOCKS * hidden;
    int32_t *index = scratch->index + slice * SLICE_BLOCKS * corners;
    float *weight = scratch->weight + slice * SLICE_BLOCKS * corners;
    float *gradient = scratch->slice_gradient + slice * round16(trainer->mlp_count);
    memset(gradient, 0, trainer->mlp_count * sizeof(float));
    double loss = 0;
    struct grid_input input[2];
    memset(input, 0, sizeof input);
    for (size_t b = 0; b <= blocks; b++) { // the corners of block b are prefetched while block b - 1 is gathered
        size_t at = done + b * NET_LANES;
        int count = (int)(step->count - at < NET_LANES ? step->count - at : NET_LANES);
        if (b < blocks) {
            step->batch->encode(step->batch->user, step->first + at, count, &input[b & 1]);
            step->kernel->index(layout, &input[b & 1], index + b * corners, weight + b * corners);
            prefetch_block(trainer->table, index + b * corners, (int)corners);
        }
        if (b == 0) continue;
        size_t p = b - 1, before = at - NET_LANES;
        count = (int)(step->count - before < NET_LANES ? step->count - before : NET_LANES);
        _Alignas(64) float z[MLP_MAX_OUTPUTS * NET_LANES];
        step->kernel->gather_float(layout, trainer->table, &input[p & 1], index + p * corners, weight + p * corners,
                                   x + p * inputs);
        step->kernel->forward(shape, trainer->mlp, x + p * inputs, h1 + p * hidden, h2 + p * hidden, z);
        loss += step->batch->loss(step->batch->user, step->first + before, count, z, d_z + p * outputs);
    }
    step->kernel->backward(shape, trainer->mlp, blocks, x, h1, h2, d_z, 2 * layout->lookup_count,
                           scratch->d_x + slice * SLICE_BLOCKS * features, d_h, gradient);
    scratch->loss[slice] = loss;
}

static void scatter_lookup(const struct step *step, int lookup) {
    struct trainer_scratch *scratch = step->trainer->scratch;
    const struct grid_layout *layout = &step->trainer->layout;
    const struct grid_level *level = &layout->levels[layout->lookups[lookup].level];
    uint64_t *touched = scratch->touched + scratch->first_word[layout->lookups[lookup].level];
    for (size_t first = 0; first < step->count; first += NET_LANES) {
        size_t block = first / NET_LANES, lanes = step->count - first < NET_LANES ? step->count - first : NET_LANES;
        size_t at = (block * (size_t)layout->corner_count + (size_t)layout->lookups[lookup].corner) * NET_LANES;
        const float *d_x = scratch->d_x + (block * 2 * (size_t)layout->lookup_count + 2 * (size_t)lookup) * NET_LANES;
        for (int k = 0; k <= level->dims; k++, at += NET_LANES)
            for (size_t l = 0; l < lanes; l++) {
                size_t entry = (size_t)scratch->index[at + l], local = entry - level->offset;
                scratch->table_gradient[2 * entry] += scratch->weight[at + l] * d_x[l];
                scratch->table_gradient[2 * entry + 1] += scratch->weight[at + l] * d_x[NET_LANES + l];
                touched[local >> 6] |= (uint64_t)1 << (local & 63);
            }
    }
}

static void scatter_level(void *user, size_t level, int worker) {
    (void)worker;
    const struct step *step = user;
    for (int j = 0; j < step->trainer->layout.lookup_count; j++)
        if (step->trainer->layout.lookups[j].level == (int)level) scatter_lookup(step, j);
}

// Without bias correction: an entry's first steps are up to 6.5 times the learning rate long, which is when they are
// wanted. A long second moment matters: where rare bright samples raise it themselves, they are damped and the light
// field loses flux (0.99 loses 3.6 % on a lamp of small bulbs learned from particles, 0.999 2.9 %).
static void update_entry(float *value, float *moments, float *gradient, float rate) {
    for (int f = 0; f < 2; f++) {
        float g = gradient[f], m = beta1 * moments[f] + (1 - beta1) * g;
        float v = beta2 * moments[2 + f] + (1 - beta2) * g * g;
        moments[f] = m;
        moments[2 + f] = v;
        value[f] -= rate * m / (sqrtf(v) + epsilon);
        gradient[f] = 0;
    }
}

static void update_level(void *user, size_t index, int worker) {
    (void)worker;
    const struct step *step = user;
    struct trainer *trainer = step->trainer;
    const struct grid_level *level = &trainer->layout.levels[index];
    uint64_t *touched = trainer->scratch->touched + trainer->scratch->first_word[index];
    size_t words = ((size_t)level->slice_entries * level->slices + 63) / 64;
    for (size_t w = 0; w < words; w++) {
        for (uint64_t bits = touched[w]; bits; bits &= bits - 1) {
            size_t entry = level->offset + w * 64 + (size_t)__builtin_ctzll(bits);
            update_entry(trainer->table + 2 * entry, trainer->moments + 4 * entry,
                         trainer->scratch->table_gradient + 2 * entry, step->table_rate);
        }
        touched[w] = 0;
    }
}

static void update_mlp(struct trainer *trainer, float rate) {
    float *gradient = trainer->scratch->mlp_gradient, *m = trainer->mlp_moments, *v = m + trainer->mlp_count;
    float correct1 = 1 - powf(beta1, (float)trainer->step), correct2 = 1 - powf(beta2, (float)trainer->step);
    for (size_t i = 0; i < trainer->mlp_count; i++) {
        m[i] = beta1 * m[i] + (1 - beta1) * gradient[i];
        v[i] = beta2 * v[i] + (1 - beta2) * gradient[i] * gradient[i];
        trainer->mlp[i] -= rate * (m[i] / correct1) / (sqrtf(v[i] / correct2) + epsilon);
    }
}

double trainer_step(struct trainer *trainer, const struct trainer_batch *batch, int threads) {
    struct trainer_scratch *scratch = trainer->scratch;
    double half = 0.5 * (double)trainer->rates.steps, late = ((double)trainer->step - half) / (half > 1 ? half : 1);
    float fall = (float)pow(trainer->rates.end, late < 0 ? 0 : late > 1 ? 1 : late);
    struct step step = {trainer, batch, kernel_best(), 0, 0, trainer->rates.table * fall};
    double loss = 0;
    memset(scratch->mlp_gradient, 0, trainer->mlp_count * sizeof(float));
    size_t levels = (size_t)trainer->layout.level_count;
    for (step.first = 0; step.first < batch->n; step.first += CHUNK) {
        step.count = batch->n - step.first < CHUNK ? batch->n - step.first : CHUNK;
        size_t slices = (step.count + SLICE - 1) / SLICE;
        parallel_for(threads, slices, work_slice, &step);
        for (size_t s = 0; s < slices; s++) {
            const float *gradient = scratch->slice_gradient + s * round16(trainer->mlp_count);
            for (size_t i = 0; i < trainer->mlp_count; i++) scratch->mlp_gradient[i] += gradient[i];
            loss += scratch->loss[s];
        }
        parallel_for(threads, levels, scatter_level, &step);
    }
    trainer->step++;
    parallel_for(threads, levels, update_level, &step);
    update_mlp(trainer, trainer->rates.mlp * fall);
    return loss;
}
