// The kernels' one source: KERNEL, KERNEL_NAME and VECTOR_LANES (floats a vector) are set by the file that includes it.
// Vectors run over samples; the MLP keeps 8 outputs (forward) or 4x4 weights (gradient) in registers.
#include <math.h>
#include <string.h>
#ifdef __AVX2__
#include <immintrin.h>
#endif

#include "net/kernel.h"

typedef float vfloat __attribute__((vector_size(4 * VECTOR_LANES), may_alias));
typedef int32_t vint __attribute__((vector_size(4 * VECTOR_LANES), may_alias));
typedef uint32_t vuint __attribute__((vector_size(4 * VECTOR_LANES), may_alias)); // keys wrap around
enum { PARTS = NET_LANES / VECTOR_LANES };

static inline vfloat splat(float v) { return v - (vfloat){0}; }

#include "net/gemm_body.h"

// --- Grids ---

static inline vint pick(vint mask, vint a, vint b) { return (a & mask) | (b & ~mask); }

static inline vfloat smaller(vfloat a, vfloat b) { // b where a is not a number
#if VECTOR_LANES == 16 && defined(__AVX512F__)
    return (vfloat)_mm512_min_ps((__m512)a, (__m512)b);
#elif VECTOR_LANES == 8 && defined(__AVX2__)
    return (vfloat)_mm256_min_ps((__m256)a, (__m256)b);
#else
    return (vfloat)pick(a < b, (vint)a, (vint)b);
#endif
}

static inline vfloat larger(vfloat a, vfloat b) { // b where a is not a number
#if VECTOR_LANES == 16 && defined(__AVX512F__)
    return (vfloat)_mm512_max_ps((__m512)a, (__m512)b);
#elif VECTOR_LANES == 8 && defined(__AVX2__)
    return (vfloat)_mm256_max_ps((__m256)a, (__m256)b);
#else
    return (vfloat)pick(a > b, (vint)a, (vint)b);
#endif
}

// Exchanges a and b, and what goes with them, where a < b.
static inline void order(vfloat *a, vfloat *b, vint *with_a, vint *with_b) {
    vfloat most = larger(*a, *b), least = smaller(*a, *b);
#if VECTOR_LANES == 16 && defined(__AVX512F__)
    __mmask16 swap = _mm512_cmp_ps_mask((__m512)*a, (__m512)*b, _CMP_LT_OQ);
    vint first = (vint)_mm512_mask_blend_epi32(swap, (__m512i)*with_a, (__m512i)*with_b);
    *with_b = (vint)_mm512_mask_blend_epi32(swap, (__m512i)*with_b, (__m512i)*with_a);
#else
    vint swap = *a < *b, first = pick(swap, *with_b, *with_a);
    *with_b = pick(swap, *with_a, *with_b);
#endif
    *with_a = first;
    *a = most;
    *b = least;
}

// Cells and fractions of `dims` coordinates: key of the cell, and of every axis the fraction and the key's step.
static inline __attribute__((always_inline)) vuint
locate(int dims, const struct grid_level *level, const float (*set)[NET_LANES], int part, vfloat *f, vint *step) {
    const vint zero = {0}, last = zero + (level->resolution - 1);
    vuint key = {0};
    for (int a = 0; a < dims; a++) {
        vfloat p = *(const vfloat *)(set[a] + part);
        p = smaller(larger(p, splat(0)), splat(1)) * (float)level->resolution;
        vint cell = __builtin_convertvector(p, vint);
        cell = pick(cell < last, cell, last);
        f[a] = p - __builtin_convertvector(cell, vfloat);
        step[a] = zero + (int32_t)level->stride[a];
        key += (vuint)cell * level->stride[a];
    }
    return key;
}

static inline __attribute__((always_inline)) void index_lookup(int dims, const struct grid_level *level,
                                                               const float (*set)[NET_LANES], const int32_t *slice,
                                                               int32_t *index, float *weight) {
    for (int part = 0; part < NET_LANES; part += VECTOR_LANES) {
        vfloat f[4];
        vint s[4];
        vuint key = locate(dims, level, set, part, f, s);
        if (dims == 2) {
            order(&f[0], &f[1], &s[0], &s[1]);
        } else if (dims == 3) {
            order(&f[0], &f[1], &s[0], &s[1]);
            order(&f[1], &f[2], &s[1], &s[2]);
            order(&f[0], &f[1], &s[0], &s[1]);
        } else if (dims == 4) {
            order(&f[0], &f[1], &s[0], &s[1]);
            order(&f[2], &f[3], &s[2], &s[3]);
            order(&f[0], &f[2], &s[0], &s[2]);
            order(&f[1], &f[3], &s[1], &s[3]);
            order(&f[1], &f[2], &s[1], &s[2]);
        }
        vuint base = *(const vuint *)(slice + part) * level->slice_entries + level->offset;
        for (int k = 0; k <= dims; k++) {
            *(vuint *)(index + k * NET_LANES + part) = base + (key & level->mask);
            *(vfloat *)(weight + k * NET_LANES + part) = (k > 0 ? f[k - 1] : splat(1)) - (k < dims ? f[k] : splat(0));
            if (k < dims) key += (vuint)s[k];
        }
    }
}

static void kernel_index(const struct grid_layout *layout, const struct grid_input *input, int32_t *index,
                         float *weight) {
    for (int j = 0; j < layout->lookup_count; j++) {
        const struct grid_lookup *lookup = &layout->lookups[j];
        const struct grid_level *level = &layout->levels[lookup->level];
        const float(*set)[NET_LANES] = input->set[lookup->set];
        const int32_t *slice = input->slice[lookup->set];
        int32_t *at = index + lookup->corner * NET_LANES;
        float *share = weight + lookup->corner * NET_LANES;
        if (level->dims == 4)
            index_lookup(4, level, set, slice, at, share);
        else if (level->dims == 3)
            index_lookup(3, level, set, slice, at, share);
        else if (level->dims == 2)
            index_lookup(2, level, set, slice, at, share);
        else
            index_lookup(1, level, set, slice, at, share);
    }
}

static inline vfloat load_float(const float *table, vint index, int feature) {
#if VECTOR_LANES == 16 && defined(__AVX512F__)
    return (vfloat)_mm512_i32gather_ps((__m512i)index, table + feature, 8);
#elif VECTOR_LANES == 8 && defined(__AVX2__)
    return (vfloat)_mm256_i32gather_ps(table + feature, (__m256i)index, 8);
#else
    vfloat result;
    for (int l = 0; l < VECTOR_LANES; l++) result[l] = table[2 * (size_t)index[l] + (size_t)feature];
    return result;
#endif
}

static void copy_raw(const struct grid_layout *layout, const struct grid_input *input, float *x) {
    int first = 2 * layout->lookup_count, rest = grid_input_count(layout) - first - layout->raw_count;
    memcpy(x + first * NET_LANES, input->raw, sizeof(float) * NET_LANES * (size_t)layout->raw_count);
    memset(x + (first + layout->raw_count) * NET_LANES, 0, sizeof(float) * NET_LANES * (size_t)rest);
}

static void kernel_gather_float(const struct grid_layout *layout, const float *table, const struct grid_input *input,
                                const int32_t *index, const float *weight, float *x) {
    for (int j = 0; j < layout->lookup_count; j++) {
        int corner = layout->lookups[j].corner, corners = layout->levels[layout->lookups[j].level].dims + 1;
        for (int part = 0; part < PARTS; part++) {
            vfloat sum0 = {0}, sum1 = {0};
            for (int k = corner; k < corner + corners; k++) {
                vint at = *(const vint *)(index + k * NET_LANES + part * VECTOR_LANES);
                vfloat share = *(const vfloat *)(weight + k * NET_LANES + part * VECTOR_LANES);
                sum0 += share * load_float(table, at, 0);
                sum1 += share * load_float(table, at, 1);
            }
            *(vfloat *)(x + 2 * j * NET_LANES + part * VECTOR_LANES) = sum0;
            *(vfloat *)(x + (2 * j + 1) * NET_LANES + part * VECTOR_LANES) = sum1;
        }
    }
    copy_raw(layout, input, x);
}

#include "net/kernel_lookup_body.h"

// --- MLP ---

// `count` outputs from o on, of y[o] = b[o] + sum_i w[o * stride_out + i * stride_in] x[i].
static inline __attribute__((always_inline)) void dense_rows(int count, int n_in, const float *w, size_t stride_out,
                                                             size_t stride_in, const float *b, const float *x, int relu,
                                                             float *y) {
    for (int part = 0; part < PARTS; part++) {
        vfloat sum[8];
        for (int o = 0; o < count; o++) sum[o] = splat(b ? b[o] : 0);
        for (int i = 0; i < n_in; i++) {
            vfloat xi = *(const vfloat *)(x + i * NET_LANES + part * VECTOR_LANES);
            for (int o = 0; o < count; o++) sum[o] += w[(size_t)o * stride_out + (size_t)i * stride_in] * xi;
        }
        for (int o = 0; o < count; o++) {
            vint positive = sum[o] > splat(0);
            *(vfloat *)(y + o * NET_LANES + part * VECTOR_LANES) = relu ? (vfloat)((vint)sum[o] & positive) : sum[o];
        }
    }
}

static void dense(int n_in, int n_out, const float *w, size_t stride_out, size_t stride_in, const float *b,
                  const float *x, int relu, float *y) {
    int o = 0;
    for (; o + 8 <= n_out; o += 8)
        dense_rows(8, n_in, w + (size_t)o * stride_out, stride_out, stride_in, b ? b + o : NULL, x, relu,
                   y + o * NET_LANES);
    for (; o + 3 <= n_out; o += 3)
        dense_rows(3, n_in, w + (size_t)o * stride_out, stride_out, stride_in, b ? b + o : NULL, x, relu,
                   y + o * NET_LANES);
    for (; o < n_out; o++)
        dense_rows(1, n_in, w + (size_t)o * stride_out, stride_out, stride_in, b ? b + o : NULL, x, relu,
                   y + o * NET_LANES);
}

static void kernel_forward(const struct mlp_shape *shape, const float *parameters, const float *x, float *h1, float *h2,
                           float *z) {
    struct mlp_offsets at = mlp_layout(shape);
    size_t inputs = (size_t)shape->inputs, width = (size_t)shape->width;
    dense(shape->inputs, shape->width, parameters + at.w1, inputs, 1, parameters + at.b1, x, 1, h1);
    dense(shape->width, shape->width, parameters + at.w2, width, 1, parameters + at.b2, h1, 1, h2);
    dense(shape->width, shape->outputs, parameters + at.w3, width, 1, parameters + at.b3, h2, 0, z);
}

typedef vfloat vfloat_anywhere __attribute__((aligned(4)));

// The same sums for one sample, in the same order: vectors run over the outputs. w[i * n_out + o].
static void dense_lane(int n_in, int n_out, const float *w, const float *b, const float *x, int relu, float *y) {
    int o = 0;
    for (; o + 2 * VECTOR_LANES <= n_out; o += 2 * VECTOR_LANES) {
        vfloat sum0 = *(const vfloat_anywhere *)(b + o), sum1 = *(const vfloat_anywhere *)(b + o + VECTOR_LANES);
        for (int i = 0; i < n_in; i++) {
            const float *row = w + i * n_out + o;
            sum0 += *(const vfloat_anywhere *)row * x[i];
            sum1 += *(const vfloat_anywhere *)(row + VECTOR_LANES) * x[i];
        }
        *(vfloat_anywhere *)(y + o) = relu ? (vfloat)((vint)sum0 & (vint)(sum0 > splat(0))) : sum0;
        *(vfloat_anywhere *)(y + o + VECTOR_LANES) = relu ? (vfloat)((vint)sum1 & (vint)(sum1 > splat(0))) : sum1;
    }
    for (; o < n_out; o++) {
        float sum = b[o];
        for (int i = 0; i < n_in; i++) sum = fmaf(w[i * n_out + o], x[i], sum); // as the vectors do
        y[o] = relu && !(sum > 0) ? 0 : sum;
    }
}

static void kernel_forward_lane(const struct mlp_shape *shape, const float *by_input, const float *x, float *z) {
    struct mlp_offsets at = mlp_layout(shape);
    float h1[MLP_MAX_WIDTH], h2[MLP_MAX_WIDTH];
    dense_lane(shape->inputs, shape->width, by_input + at.w1, by_input + at.b1, x, 1, h1);
    dense_lane(shape->width, shape->width, by_input + at.w2, by_input + at.b2, h1, 1, h2);
    dense_lane(shape->width, shape->outputs, by_input + at.w3, by_input + at.b3, h2, 0, z);
}

static inline float sum_lanes(vfloat v) {
#if VECTOR_LANES == 16
    v += __builtin_shufflevector(v, v, 8, 9, 10, 11, 12, 13, 14, 15, 0, 1, 2, 3, 4, 5, 6, 7);
    v += __builtin_shufflevector(v, v, 4, 5, 6, 7, 0, 1, 2, 3, 4, 5, 6, 7, 0, 1, 2, 3);
    v += __builtin_shufflevector(v, v, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1);
#else
    v += __builtin_shufflevector(v, v, 4, 5, 6, 7, 0, 1, 2, 3);
    v += __builtin_shufflevector(v, v, 2, 3, 0, 1, 2, 3, 0, 1);
#endif
    return v[0] + v[1];
}

// d_w[o][i..i+3] += sum over blocks and lanes of d_y[o] x[i], `count` outputs.
static inline __attribute__((always_inline)) void gradient_tile(int count, size_t blocks, int n_in, int n_out,
                                                                const float *x, const float *d_y, float *d_w) {
    vfloat sum[4][4] = {{{0}}};
    for (size_t b = 0; b < blocks; b++)
        for (int part = 0; part < PARTS; part++) {
            const float *xb = x + b * (size_t)n_in * NET_LANES + part * VECTOR_LANES;
            const float *db = d_y + b * (size_t)n_out * NET_LANES + part * VECTOR_LANES;
            for (int o = 0; o < count; o++)
                for (int i = 0; i < 4; i++)
                    sum[o][i] += *(const vfloat *)(db + o * NET_LANES) * *(const vfloat *)(xb + i * NET_LANES);
        }
    for (int o = 0; o < count; o++)
        for (int i = 0; i < 4; i++) d_w[o * n_in + i] += sum_lanes(sum[o][i]);
}

static void gradient(size_t blocks, int n_in, int n_out, const float *x, const float *d_y, float *d_w, float *d_b) {
    for (int o = 0; o < n_out; o++) {
        vfloat sum = {0};
        for (size_t b = 0; b < blocks; b++)
            for (int part = 0; part < PARTS; part++)
                sum += *(const vfloat *)(d_y + (b * (size_t)n_out + (size_t)o) * NET_LANES + part * VECTOR_LANES);
        d_b[o] += sum_lanes(sum);
    }
    int o = 0;
    for (; o + 4 <= n_out; o += 4)
        for (int i = 0; i < n_in; i += 4)
            gradient_tile(4, blocks, n_in, n_out, x + i * NET_LANES, d_y + o * NET_LANES, d_w + o * n_in + i);
    for (; o < n_out; o++)
        for (int i = 0; i < n_in; i += 4)
            gradient_tile(1, blocks, n_in, n_out, x + i * NET_LANES, d_y + o * NET_LANES, d_w + o * n_in + i);
}

// Zeroes the gradient where the ReLU's output is 0.
static void mask_relu(const float *h, float *d_h, size_t count) {
    for (size_t i = 0; i < count; i++) d_h[i] = h[i] > 0 ? d_h[i] : 0;
}

static void kernel_backward(const struct mlp_shape *shape, const float *parameters, size_t blocks, const float *x,
                            const float *h1, const float *h2, const float *d_z, int d_inputs, float *d_x, float *d_h,
                            float *d_parameters) {
    struct mlp_offsets at = mlp_layout(shape);
    int width = shape->width;
    size_t hidden = (size_t)width * NET_LANES, outputs = (size_t)shape->outputs * NET_LANES;
    float *d_h1 = d_h, *d_h2 = d_h + blocks * hidden;
    for (size_t b = 0; b < blocks; b++)
        dense(shape->outputs, width, parameters + at.w3, 1, (size_t)width, NULL, d_z + b * outputs, 0,
              d_h2 + b * hidden);
    mask_relu(h2, d_h2, blocks * hidden);
    for (size_t b = 0; b < blocks; b++)
        dense(width, width, parameters + at.w2, 1, (size_t)width, NULL, d_h2 + b * hidden, 0, d_h1 + b * hidden);
    mask_relu(h1, d_h1, blocks * hidden);
    for (size_t b = 0; b < blocks; b++)
        dense(width, d_inputs, parameters + at.w1, 1, (size_t)shape->inputs, NULL, d_h1 + b * hidden, 0,
              d_x + b * (size_t)d_inputs * NET_LANES);
    gradient(blocks, width, shape->outputs, h2, d_z, d_parameters + at.w3, d_parameters + at.b3);
    gradient(blocks, width, width, h1, d_h2, d_parameters + at.w2, d_parameters + at.b2);
    gradient(blocks, shape->inputs, width, x, d_h1, d_parameters + at.w1, d_parameters + at.b1);
}

// e^x = 2^n e^r with |r| <= ln(2)/2, Taylor to the sixth power: relative error below 2e-7.
static void kernel_exponential(float *values, size_t count) {
    for (size_t i = 0; i < count; i++) {
        float n = floorf(values[i] * 1.44269504f + 0.5f);
        float r = (values[i] - n * 0.693145752f) - n * 1.42860677e-6f;
        float p = 1 + r * (1 + r * (0.5f + r * (1.0f / 6 + r * (1.0f / 24 + r * (1.0f / 120 + r * (1.0f / 720))))));
        union {
            int32_t bits;
            float value;
        } power = {((int32_t)n + 127) * (1 << 23)};
        values[i] = p * power.value;
    }
}

const struct kernel KERNEL = {KERNEL_NAME,        kernel_index,   kernel_gather_float, kernel_lookup,
                              kernel_lookup_lane, kernel_forward, kernel_forward_lane, kernel_backward,
                              kernel_exponential, GEMM_TILE,      kernel_gemm};
