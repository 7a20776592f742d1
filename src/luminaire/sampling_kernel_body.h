// The sampling kernels' one source: SAMPLING_KERNEL is set by the file that includes it. Every loop over the lanes is
// free of branches and calls, so that the compiler makes vectors of it; what needs tables by the byte is done lane by
// lane in between.
#include <math.h>
#ifdef __AVX512F__
#include <immintrin.h>
#endif

#include "luminaire/sampling_kernel.h"

enum { LANES = SAMPLING_LANES };
#define EACH_LANE for (int i = 0; i < LANES; i++)

typedef float lane_array[LANES] __attribute__((aligned(64)));

struct lane_views { // struct sampling_view, of points outside
    int cell[LANES] __attribute__((aligned(64)));
    int inside[LANES] __attribute__((aligned(64)));
    lane_array axis[3], s[3], t[3], rim;
};

struct lane_mixtures {
    struct lane_views view;
    lane_array map_share, anchor_share, uniform_density; // of the map's image: 1 / its solid angle
    float weight[SAMPLING_MAX_ANCHORS][LANES] __attribute__((aligned(64))); // not normalised
    lane_array total; // of the weights
};

static inline float least(float a, float b) { return a < b ? a : b; }
static inline float most(float a, float b) { return a > b ? a : b; }

// octahedral_from_direction of any vector: cells of count x count.
static inline int octahedral_cell(float x, float y, float z, int count) {
    float scale = 1 / (fabsf(x) + fabsf(y) + fabsf(z));
    x *= scale;
    y *= scale;
    float folded_x = copysignf(1 - fabsf(y), x), folded_y = copysignf(1 - fabsf(x), y);
    x = z < 0 ? folded_x : x;
    y = z < 0 ? folded_y : y;
    float n = (float)count, last = n - 0.5f;
    int column = (int)least(most((0.5f * x + 0.5f) * n, 0), last),
        row = (int)least(most((0.5f * y + 0.5f) * n, 0), last);
    return row * count + column;
}

// table[cell] of INTENSITY_CELLS numbers.
static inline void look_up(const float *table, const int *cell, float *found) {
#ifdef __AVX512F__
    _Static_assert(INTENSITY_CELLS == 4 * LANES, "two permutations of two registers each");
    const __m512i index = _mm512_load_si512(cell);
    const __m512 low = _mm512_permutex2var_ps(_mm512_loadu_ps(table), index, _mm512_loadu_ps(table + LANES));
    const __m512 high =
        _mm512_permutex2var_ps(_mm512_loadu_ps(table + 2 * LANES), index, _mm512_loadu_ps(table + 3 * LANES));
    const __mmask16 upper = _mm512_cmpge_epi32_mask(index, _mm512_set1_epi32(2 * LANES));
    _mm512_store_ps(found, _mm512_mask_blend_ps(upper, low, high));
#else
    EACH_LANE found[i] = table[cell[i]];
#endif
}

// 1 - cosine of the half angle of the cone about a ball; 2 (all directions) from within it.
static inline float lane_cone_height(float radius2, float distance2) {
    float sin2 = radius2 / distance2;
    float rim = sin2 / (1 + sqrtf(most(1 - sin2, 0)));
    return sin2 < 0.998f ? rim : 2;
}

static inline void find_views(const struct sampling_density *density, const struct sampling_lanes *lanes,
                              struct lane_views *view) {
    const float scale = 1 / density->radius, *side = density->sides[0];
    const int n = density->directions;
    int place[LANES] __attribute__((aligned(64)));
    EACH_LANE {
        float x = (lanes->s[0][i] - density->center.x) * scale, y = (lanes->s[1][i] - density->center.y) * scale;
        float z = (lanes->s[2][i] - density->center.z) * scale, distance2 = x * x + y * y + z * z;
        view->inside[i] = !(distance2 > SAMPLING_OUTSIDE2);
        float safe2 = most(distance2, SAMPLING_OUTSIDE2), distance = sqrtf(safe2), inverse = -1 / distance;
        view->axis[0][i] = x * inverse;
        view->axis[1][i] = y * inverse;
        view->axis[2][i] = z * inverse;
        int direction = octahedral_cell(x, y, z, n);
        int bin = (distance >= SAMPLING_BIN_1 ? 1 : 0) + (distance >= SAMPLING_BIN_2 ? 1 : 0);
        view->cell[i] = bin * n * n + direction;
        float sin2 = 1 / safe2;
        view->rim[i] = sin2 / (1 + sqrtf(1 - sin2));
        place[i] = 3 * direction;
    }
    lane_array start[3]; // by itself: what is read by index may not alias what is written
    for (int c = 0; c < 3; c++) EACH_LANE start[c][i] = side[place[i] + c];
    EACH_LANE {
        float ax = view->axis[0][i], ay = view->axis[1][i], az = view->axis[2][i];
        float sx = start[0][i], sy = start[1][i], sz = start[2][i], along = sx * ax + sy * ay + sz * az;
        sx -= along * ax;
        sy -= along * ay;
        sz -= along * az;
        float inverse = 1 / sqrtf(sx * sx + sy * sy + sz * sz);
        view->s[0][i] = sx *= inverse;
        view->s[1][i] = sy *= inverse;
        view->s[2][i] = sz *= inverse;
        view->t[0][i] = ay * sz - az * sy;
        view->t[1][i] = az * sx - ax * sz;
        view->t[2][i] = ax * sy - ay * sx;
    }
}

static inline void find_mixtures(const struct sampling_density *density, const struct sampling_lanes *lanes,
                                 struct lane_mixtures *mixture) {
    find_views(density, lanes, &mixture->view);
    EACH_LANE {
        mixture->total[i] = 0;
        mixture->uniform_density[i] = 1 / (2 * PI_F * mixture->view.rim[i]);
    }
    const float floor2 = density->cone_radius[CONE_COUNT - 1] * density->cone_radius[CONE_COUNT - 1];
    for (int a = 0; a < density->anchor_count; a++) {
        const float *anchor = density->anchors[a], *intensity = density->intensity + (size_t)a * INTENSITY_CELLS;
        int cell[LANES] __attribute__((aligned(64)));
        lane_array fall_off;
        EACH_LANE {
            float x = lanes->s[0][i] - anchor[0], y = lanes->s[1][i] - anchor[1], z = lanes->s[2][i] - anchor[2];
            float distance2 = x * x + y * y + z * z;
            z = distance2 > 1e-30f ? z : 1;
            cell[i] = octahedral_cell(x, y, z, INTENSITY_SIDE);
            fall_off[i] = 1 / most(distance2, floor2);
        }
        lane_array weight; // by itself: what is read by index may not alias what is written
        look_up(intensity, cell, weight);
        EACH_LANE {
            weight[i] *= fall_off[i];
            mixture->weight[a][i] = weight[i];
            mixture->total[i] += weight[i];
        }
    }
    lane_array share;
    EACH_LANE share[i] = density->residual_share[mixture->view.cell[i]];
    EACH_LANE {
        float map = mixture->total[i] > 0 ? share[i] / 255 : 1;
        mixture->map_share[i] = (1 - SAMPLING_UNIFORM_SHARE) * map;
        mixture->anchor_share[i] = (1 - SAMPLING_UNIFORM_SHARE) * (1 - map);
    }
}

// Whether the line of any lane passes an anchor within its widest cone, or a little beyond: most pass most anchors by.
static inline bool any_near(const struct sampling_density *density, const struct sampling_lanes *lanes, int a) {
    const float *anchor = density->anchors[a];
    const float widest2 = 1.001f * density->cone_radius[CONE_COUNT - 1] * density->cone_radius[CONE_COUNT - 1];
    int near = 0;
    EACH_LANE {
        float x = anchor[0] - lanes->s[0][i], y = anchor[1] - lanes->s[1][i], z = anchor[2] - lanes->s[2][i];
        float dx = lanes->direction[0][i], dy = lanes->direction[1][i], dz = lanes->direction[2][i];
        float distance2 = x * x + y * y + z * z, along = x * dx + y * dy + z * dz;
        x -= along * dx;
        y -= along * dy;
        z -= along * dz;
        float across2 = x * x + y * y + z * z, reach2 = widest2 + 1e-6f * distance2;
        near |= ((along > 0) & (across2 <= reach2)) | (distance2 <= 1.01f * widest2);
    }
    return near != 0;
}

// The density of the anchors' cones about one anchor: a step for each cone that the direction is in. Both sides of
// height > rim = sin2 / (1 + cosine) are multiplied by the denominator: what is left is one root a cone.
static inline void add_cones(const struct sampling_density *density, const struct sampling_lanes *lanes, int a,
                             const float *weight, float *sum) {
    const float *anchor = density->anchors[a];
    float radius[CONE_COUNT], radius2[CONE_COUNT], share[CONE_COUNT];
    for (int k = 0; k < CONE_COUNT; k++) {
        radius[k] = density->cone_radius[k];
        radius2[k] = radius[k] * radius[k];
        share[k] = density->cone_share[k] / (2 * PI_F);
    }
    EACH_LANE {
        float x = anchor[0] - lanes->s[0][i], y = anchor[1] - lanes->s[1][i], z = anchor[2] - lanes->s[2][i];
        float dx = lanes->direction[0][i], dy = lanes->direction[1][i], dz = lanes->direction[2][i];
        float distance2 = x * x + y * y + z * z, along = x * dx + y * dy + z * dz;
        float safe2 = most(distance2, 1e-30f), distance = sqrtf(safe2), inverse2 = 1 / safe2;
        x -= along * dx;
        y -= along * dy;
        z -= along * dz;
        // 1 - cosine of the angle between, without cancellation
        float across2 = x * x + y * y + z * z, part = across2 / (safe2 + fabsf(along) * distance);
        float height = along > 0 ? part : 2 - part;
        height = distance2 < 1e-30f ? 0 : height;
        float density_sum = 0;
        for (int k = 0; k < CONE_COUNT; k++) {
            float sin2 = radius2[k] * inverse2, denominator = 1 + sqrtf(most(1 - sin2, 0));
            // A little beyond the rim: what rounding may do to a sample of the cone.
            float reach = sin2 * (1 + 1e-4f) + 4.3e-7f * radius[k] * inverse2 * distance;
            float value = height * denominator > reach ? 0 : share[k] / radius2[k] * denominator * safe2;
            density_sum += sin2 < 0.998f ? value : share[k] * 0.5f; // from within the ball: all directions
        }
        sum[i] += weight[i] * density_sum;
    }
}

// atan on [0, 1], error below 2e-7 (Chebyshev fit by odd powers).
static inline float lane_atan(float x) {
    float y = x * x;
    float p = -0.0040540580f;
    p = p * y + 0.0218612288f;
    p = p * y - 0.0559098861f;
    p = p * y + 0.0964200441f;
    p = p * y - 0.1390853351f;
    p = p * y + 0.1994653599f;
    p = p * y - 0.3332985605f;
    p = p * y + 0.9999993329f;
    return x * p;
}

static inline void mixture_densities(const struct sampling_density *density, const struct lane_mixtures *mixture,
                                     struct sampling_lanes *lanes) {
    const struct lane_views *view = &mixture->view;
    int pixel[LANES] __attribute__((aligned(64))), within[LANES] __attribute__((aligned(64)));
    EACH_LANE {
        float dx = lanes->direction[0][i], dy = lanes->direction[1][i], dz = lanes->direction[2][i];
        float x = dx * view->s[0][i] + dy * view->s[1][i] + dz * view->s[2][i];
        float y = dx * view->t[0][i] + dy * view->t[1][i] + dz * view->t[2][i];
        float z = dx * view->axis[0][i] + dy * view->axis[1][i] + dz * view->axis[2][i];
        float rim = view->rim[i], sin2 = x * x + y * y, r2 = sin2 / ((1 + z) * rim); // 1 - cosine over the rim's
        // A little beyond the rim: what rounding may do to a sample.
        within[i] = z > 0 && r2 <= 1 + 1e-4f + 4e-7f / sqrtf(rim);
        // Shirley and Chiu 1997, from the disk to the square.
        float ax = fabsf(x), ay = fabsf(y), larger = most(ax, ay), smaller = least(ax, ay);
        float r = 0.5f * sqrtf(least(r2, 1)), turn = r * (4 * INV_PI_F) * lane_atan(smaller / most(larger, 1e-30f));
        float u = 0.5f + copysignf(ax >= ay ? r : turn, x), v = 0.5f + copysignf(ax >= ay ? turn : r, y);
        int column = (int)least(most(u * MAP_SIDE, 0), MAP_SIDE - 0.5f);
        int row = (int)least(most(v * MAP_SIDE, 0), MAP_SIDE - 0.5f);
        pixel[i] = (view->cell[i] * MAP_SIDE + row) * (MAP_SIDE + 1) + column;
    }
    lane_array counts, totals, cones;
    EACH_LANE {
        const uint16_t *prefix = density->prefix + pixel[i];
        counts[i] = (float)(prefix[1] - prefix[0]);
        totals[i] = density->rows[view->cell[i] * (MAP_SIDE + 1) + MAP_SIDE];
    }
    EACH_LANE cones[i] = 0;
    for (int a = 0; a < density->anchor_count; a++)
        if (any_near(density, lanes, a)) add_cones(density, lanes, a, mixture->weight[a], cones);
    EACH_LANE {
        float map = (SAMPLING_UNIFORM_SHARE + mixture->map_share[i] * counts[i] * MAP_PIXELS / totals[i]) *
                    mixture->uniform_density[i];
        float anchors = mixture->anchor_share[i] * cones[i] / most(mixture->total[i], 1e-30f);
        lanes->pdf_sa[i] = (within[i] ? map : 0) + anchors;
    }
}

static void kernel_pdf(const struct sampling_density *density, struct sampling_lanes *lanes) {
    struct lane_mixtures mixture;
    find_mixtures(density, lanes, &mixture);
    mixture_densities(density, &mixture, lanes);
    EACH_LANE {
        if (!mixture.view.inside[i]) continue;
        lanes->pdf_sa[i] =
            sampling_pdf(density, vec3_make(lanes->s[0][i], lanes->s[1][i], lanes->s[2][i]),
                         vec3_make(lanes->direction[0][i], lanes->direction[1][i], lanes->direction[2][i]));
    }
}

// The interval of u * total in ascending sums[0..MAP_SIDE] and the place of u in it, as one coordinate in [0, 1).
static inline float find_place(const uint16_t *sums, float u) {
    float at = least(u, 0.9999998f) * (float)sums[MAP_SIDE]; // below the total after rounding too
    int below = 0;
    for (int k = 1; k < MAP_SIDE; k++) below += (float)sums[k] <= at ? 1 : 0;
    float rest = (at - (float)sums[below]) / (float)(sums[below + 1] - sums[below]);
    return ((float)below + least(most(rest, 0), 0x1.fffffep-1f)) * (1.0f / MAP_SIDE);
}

// What a sample will be of: a place in the image (*cone < 0), or in a cone about an anchor.
static inline void choose(const struct sampling_density *density, const struct lane_mixtures *mixture,
                          const struct sampling_lanes *lanes, int i, float place[2], int *anchor, int *cone) {
    float u = lanes->u[0][i], map = SAMPLING_UNIFORM_SHARE + mixture->map_share[i];
    place[0] = lanes->u[1][i];
    place[1] = lanes->u[2][i];
    *cone = -1;
    *anchor = 0;
    if (u < SAMPLING_UNIFORM_SHARE) return;
    if (u < map || !(mixture->anchor_share[i] > 0)) {
        size_t cell = (size_t)mixture->view.cell[i];
        place[1] = find_place(density->rows + cell * (MAP_SIDE + 1), lanes->u[2][i]);
        size_t row = (size_t)(place[1] * MAP_SIDE);
        place[0] = find_place(density->prefix + (cell * MAP_SIDE + row) * (MAP_SIDE + 1), lanes->u[1][i]);
        return;
    }
    float choice = (u - map) / mixture->anchor_share[i] * mixture->total[i];
    int a = 0, k = 0;
    for (; a + 1 < density->anchor_count && choice >= mixture->weight[a][i]; a++) choice -= mixture->weight[a][i];
    choice = mixture->weight[a][i] > 0 ? choice / mixture->weight[a][i] : 0;
    for (; k + 1 < CONE_COUNT && choice >= density->cone_share[k]; k++) choice -= density->cone_share[k];
    *anchor = a;
    *cone = k;
}

// sin and cos of x in [-pi/4, pi/4], errors below 1e-7 (Taylor).
static inline float lane_sin(float x) {
    float y = x * x;
    return x * (1 + y * (-1.0f / 6 + y * (1.0f / 120 + y * (-1.0f / 5040))));
}
static inline float lane_cos(float x) {
    float y = x * x;
    return 1 + y * (-0.5f + y * (1.0f / 24 + y * (-1.0f / 720 + y * (1.0f / 40320))));
}

static void kernel_sample(const struct sampling_density *density, struct sampling_lanes *lanes) {
    struct lane_mixtures mixture;
    find_mixtures(density, lanes, &mixture);
    const struct lane_views *view = &mixture.view;
    lane_array place[2], to[3], radius2;
    int coned[LANES] __attribute__((aligned(64)));
    EACH_LANE {
        float p[2];
        int anchor, cone;
        if (view->inside[i]) // answered below
            p[0] = p[1] = 0.5f, anchor = 0, cone = -1;
        else
            choose(density, &mixture, lanes, i, p, &anchor, &cone);
        coned[i] = cone >= 0;
        place[0][i] = p[0];
        place[1][i] = p[1];
        radius2[i] = cone >= 0 ? density->cone_radius[cone] * density->cone_radius[cone] : 1;
        for (int c = 0; c < 3; c++)
            to[c][i] = cone >= 0 ? density->anchors[anchor][c] - lanes->s[c][i] : view->axis[c][i];
    }
    EACH_LANE {
        // The disk about the axis: concentric for the image, by radius and turn for a cone.
        float a = 2 * place[0][i] - 1, b = 2 * place[1][i] - 1, larger = most(fabsf(a), fabsf(b));
        float quotient = least(fabsf(a), fabsf(b)) / most(larger, 1e-30f);
        float sine = lane_sin(PI_F / 4 * quotient), cosine = lane_cos(PI_F / 4 * quotient);
        float image_x = copysignf(fabsf(a) > fabsf(b) ? cosine : sine, a);
        float image_y = copysignf(fabsf(a) > fabsf(b) ? sine : cosine, b);
        float quarter = 4 * place[1][i], whole = floorf(quarter + 0.5f); // turn = place[1]
        float angle = PI_F / 2 * (quarter - whole), s = lane_sin(angle), c = lane_cos(angle);
        int quadrant = (int)whole & 3;
        float turn_x = quadrant & 1 ? s : c, turn_y = quadrant & 1 ? c : s;
        turn_x = quadrant == 1 || quadrant == 2 ? -turn_x : turn_x;
        turn_y = quadrant >= 2 ? -turn_y : turn_y;
        float x = coned[i] ? turn_x : image_x, y = coned[i] ? turn_y : image_y;

        float nx = to[0][i], ny = to[1][i], nz = to[2][i], distance2 = most(nx * nx + ny * ny + nz * nz, 1e-30f);
        float cone_rim = lane_cone_height(radius2[i], distance2), inverse = 1 / sqrtf(distance2);
        nx *= inverse;
        ny *= inverse;
        nz *= inverse;
        float height = coned[i] ? place[0][i] * cone_rim : least(larger * larger, 1) * view->rim[i];
        float across = sqrtf(most(height * (2 - height), 0));
        // frame_from_normal, for the cones
        float sign = copysignf(1.0f, nz), k = -1 / (sign + nz), m = nx * ny * k;
        float sx = coned[i] ? 1 + sign * nx * nx * k : view->s[0][i], sy = coned[i] ? sign * m : view->s[1][i];
        float sz = coned[i] ? -sign * nx : view->s[2][i], tx = coned[i] ? m : view->t[0][i];
        float ty = coned[i] ? sign + ny * ny * k : view->t[1][i], tz = coned[i] ? -ny : view->t[2][i];
        x *= across;
        y *= across;
        float z = 1 - height;
        float dx = sx * x + tx * y + nx * z, dy = sy * x + ty * y + ny * z, dz = sz * x + tz * y + nz * z;
        float scale = 1 / sqrtf(dx * dx + dy * dy + dz * dz);
        lanes->direction[0][i] = dx * scale;
        lanes->direction[1][i] = dy * scale;
        lanes->direction[2][i] = dz * scale;
    }
    mixture_densities(density, &mixture, lanes);
    EACH_LANE {
        if (!view->inside[i]) continue;
        vec3 direction;
        sampling_sample(density, vec3_make(lanes->s[0][i], lanes->s[1][i], lanes->s[2][i]),
                        vec3_make(lanes->u[0][i], lanes->u[1][i], lanes->u[2][i]), &direction, &lanes->pdf_sa[i]);
        lanes->direction[0][i] = direction.x;
        lanes->direction[1][i] = direction.y;
        lanes->direction[2][i] = direction.z;
    }
}

const struct sampling_kernel SAMPLING_KERNEL = {kernel_sample, kernel_pdf};
