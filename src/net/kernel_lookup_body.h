// Lookups in 8-bit tables, a part of net/kernel_body.h: of a block, and of one sample with its lookups in the lanes.
// Neighbours along the first axis are neighbours in memory, so one gather of 32 bits brings the two corners that a step
// along that axis joins: the other axes alone are sorted, and each of their `dims` corners splits its weight between
// the pair. Both ways do the same arithmetic in the same order, so they agree bit for bit.

// The two entries from `index` on: four codes, the first in the lowest byte.
static inline vint load_entries(const int8_t *codes, vint index) {
#if VECTOR_LANES == 16 && defined(__AVX512F__)
    return (vint)_mm512_i32gather_epi32((__m512i)index, codes, 2);
#elif VECTOR_LANES == 8 && defined(__AVX2__)
    return (vint)_mm256_i32gather_epi32((const int *)(const void *)codes, (__m256i)index, 2);
#else
    vint result;
    for (int l = 0; l < VECTOR_LANES; l++) {
        int32_t four;
        memcpy(&four, codes + 2 * (size_t)index[l], 4);
        result[l] = four;
    }
    return result;
#endif
}

static inline vint load_words(const void *words, vint index) {
#if VECTOR_LANES == 16 && defined(__AVX512F__)
    return (vint)_mm512_i32gather_epi32((__m512i)index, words, 4);
#elif VECTOR_LANES == 8 && defined(__AVX2__)
    return (vint)_mm256_i32gather_epi32((const int *)words, (__m256i)index, 4);
#else
    vint result;
    for (int l = 0; l < VECTOR_LANES; l++) result[l] = ((const int32_t *)words)[index[l]];
    return result;
#endif
}

static inline int any(vint mask) {
#if VECTOR_LANES == 16 && defined(__AVX512F__)
    return _mm512_test_epi32_mask((__m512i)mask, (__m512i)mask) != 0;
#elif VECTOR_LANES == 8 && defined(__AVX2__)
    return !_mm256_testz_si256((__m256i)mask, (__m256i)mask);
#else
    int found = 0;
    for (int l = 0; l < VECTOR_LANES; l++) found |= mask[l];
    return found;
#endif
}

// Sums over the pairs of corners; f and step of axis 0, then of `others` more axes in any order.
static inline __attribute__((always_inline)) void add_pairs(int others, int hashed, const int8_t *codes, vuint base,
                                                            vuint mask, vuint key, vfloat *f, vint *step, vfloat *y0,
                                                            vfloat *y1) {
    if (others >= 2) order(&f[1], &f[2], &step[1], &step[2]);
    if (others >= 3) {
        order(&f[2], &f[3], &step[2], &step[3]);
        order(&f[1], &f[2], &step[1], &step[2]);
    }
    vfloat upper = splat(1), sum0 = {0}, sum1 = {0};
    for (int k = 1; k <= others + 1; k++) {
        vfloat lower = k <= others ? f[k] : splat(0);
        vfloat split = larger(smaller(f[0], upper), lower);
        vuint entry = key & mask;
        vint four = load_entries(codes, (vint)(base + entry));
        vint wraps = (vint)(entry == mask); // the next entry is then the slice's first
        if (hashed && any(wraps)) {
            vint next = load_entries(codes, (vint)(base + ((key + 1) & mask)));
            four = pick(wraps, (four & 0xffff) | next << 16, four);
        }
        sum0 += (upper - split) * __builtin_convertvector(four << 24 >> 24, vfloat);
        sum1 += (upper - split) * __builtin_convertvector(four << 16 >> 24, vfloat);
        sum0 += (split - lower) * __builtin_convertvector(four << 8 >> 24, vfloat);
        sum1 += (split - lower) * __builtin_convertvector(four >> 24, vfloat);
        upper = lower;
        if (k <= others) key += (vuint)step[k];
    }
    *y0 = sum0;
    *y1 = sum1;
}

static inline __attribute__((always_inline)) void lookup(int dims, const struct grid_level *level,
                                                         const float (*set)[NET_LANES], const int32_t *slice,
                                                         const int8_t *codes, float scale, float *y) {
    for (int part = 0; part < NET_LANES; part += VECTOR_LANES) {
        vfloat f[4], y0, y1;
        vint step[4];
        vuint key = locate(dims, level, set, part, f, step), zero = {0};
        vuint base = *(const vuint *)(slice + part) * level->slice_entries + level->offset;
        add_pairs(dims - 1, level->mask != UINT32_MAX, codes, base, zero + level->mask, key, f, step, &y0, &y1);
        *(vfloat *)(y + part) = y0 * scale;
        *(vfloat *)(y + NET_LANES + part) = y1 * scale;
    }
}

static void kernel_lookup(const struct grid_layout *layout, const int8_t *codes, const float *scale,
                          const struct grid_input *input, float *x) {
    for (int j = 0; j < layout->lookup_count; j++) {
        const struct grid_lookup *at = &layout->lookups[j];
        const struct grid_level *level = &layout->levels[at->level];
        const float(*set)[NET_LANES] = input->set[at->set], unit = scale[at->level];
        const int32_t *slice = input->slice[at->set];
        float *y = x + 2 * j * NET_LANES;
        if (level->dims == 4)
            lookup(4, level, set, slice, codes, unit, y);
        else if (level->dims == 3)
            lookup(3, level, set, slice, codes, unit, y);
        else if (level->dims == 2)
            lookup(2, level, set, slice, codes, unit, y);
        else
            lookup(1, level, set, slice, codes, unit, y);
    }
    copy_raw(layout, input, x);
}

static void kernel_lookup_lane(const struct grid_by_lookup *grid, const int8_t *codes, const struct grid_input *input,
                               int lane, float *x) {
    for (int first = 0; first < grid->lookup_count; first += VECTOR_LANES) {
        vfloat f[4];
        vint step[4], set = *(const vint *)(grid->set + first), place = set * (GRID_MAX_DIMS * NET_LANES) + lane;
        vuint key = {0};
        for (int a = 0; a < GRID_MAX_DIMS; a++, place += NET_LANES) { // locate()
            const vint last = *(const vint *)(grid->last[a] + first);
            const vuint stride = *(const vuint *)(grid->stride[a] + first);
            vfloat p = (vfloat)load_words(input->set, place);
            p = smaller(larger(p, splat(0)), splat(1)) * *(const vfloat *)(grid->resolution[a] + first);
            vint cell = __builtin_convertvector(p, vint);
            cell = pick(cell < last, cell, last);
            f[a] = p - __builtin_convertvector(cell, vfloat);
            step[a] = (vint)stride;
            key += (vuint)cell * stride;
        }
        vuint slice = (vuint)load_words(input->slice, set * NET_LANES + lane);
        vuint base = slice * *(const vuint *)(grid->slice_entries + first) + *(const vuint *)(grid->offset + first);
        vfloat y0, y1, scale = *(const vfloat *)(grid->scale + first);
        add_pairs(GRID_MAX_DIMS - 1, 1, codes, base, *(const vuint *)(grid->mask + first), key, f, step, &y0, &y1);
        _Alignas(64) float even[VECTOR_LANES], odd[VECTOR_LANES];
        *(vfloat *)even = y0 * scale;
        *(vfloat *)odd = y1 * scale;
        int count = grid->lookup_count - first < VECTOR_LANES ? grid->lookup_count - first : VECTOR_LANES;
        for (int j = 0; j < count; j++) {
            x[2 * (first + j)] = even[j];
            x[2 * (first + j) + 1] = odd[j];
        }
    }
    int at = 2 * grid->lookup_count;
    for (int k = 0; k < grid->raw_count; k++) x[at++] = input->raw[k][lane];
    while (at < grid->input_count) x[at++] = 0;
}
