// Cells of shading points, and the equal-area map between the cone and the image (inside the sphere: cylindrical).
#include <stdlib.h>
#include <string.h>

#include "luminaire/sampling.h"
#include "math/warp.h"

size_t sampling_cell_count(const struct sampling_density *density) {
    return (size_t)density->directions * (size_t)density->directions * DISTANCE_BINS + INSIDE_CELLS;
}

static int cell_index(float p, int count) {
    int cell = (int)(p * (float)count);
    return cell < 0 ? 0 : cell < count ? cell : count - 1;
}

struct sampling_view sampling_view_make(const struct sampling_density *density, vec3 s) {
    vec3 offset = vec3_scale(vec3_sub(s, density->center), 1 / density->radius);
    float distance2 = vec3_dot(offset, offset);
    int n = density->directions;
    size_t outside = (size_t)n * (size_t)n * DISTANCE_BINS;
    struct sampling_view view;
    if (!(distance2 > SAMPLING_OUTSIDE2)) {
        int x = cell_index(0.5f + 0.5f * offset.x, INSIDE_SIDE), y = cell_index(0.5f + 0.5f * offset.y, INSIDE_SIDE);
        int z = cell_index(0.5f + 0.5f * offset.z, INSIDE_SIDE);
        view = (struct sampling_view){
            outside + (size_t)((z * INSIDE_SIDE + y) * INSIDE_SIDE + x), true, {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, 2};
        return view;
    }
    float distance = sqrtf(distance2);
    vec3 axis = vec3_scale(offset, -1 / distance);
    vec2 square = octahedral_from_direction(vec3_neg(axis));
    int x = cell_index(square.x, n), y = cell_index(square.y, n);
    int bin = (distance >= SAMPLING_BIN_1) + (distance >= SAMPLING_BIN_2);
    view.cell = ((size_t)bin * (size_t)n + (size_t)y) * (size_t)n + (size_t)x;
    view.inside = false;
    // The cell's own frame, turned as little as possible: images of one cell's points agree.
    const float *start = density->sides[y * n + x];
    vec3 side = {start[0], start[1], start[2]};
    view.frame.n = axis;
    view.frame.s = vec3_normalize(vec3_mad(axis, -vec3_dot(side, axis), side));
    view.frame.t = vec3_cross(axis, view.frame.s);
    float sin2 = 1 / distance2;
    view.rim = sin2 / (1 + sqrtf(1 - sin2));
    return view;
}

// Shirley and Chiu 1997, a low distortion map between disk and square.
static vec2 square_from_disk(vec2 p) {
    float r = sqrtf(p.x * p.x + p.y * p.y), a, b;
    if (r == 0) return (vec2){0.5f, 0.5f};
    if (fabsf(p.x) >= fabsf(p.y)) {
        a = copysignf(r, p.x);
        b = a * (4 * INV_PI_F) * atanf(p.y / p.x);
    } else {
        b = copysignf(r, p.y);
        a = b * (4 * INV_PI_F) * atanf(p.x / p.y);
    }
    return (vec2){0.5f + 0.5f * a, 0.5f + 0.5f * b};
}

bool sampling_image_from_direction(const struct sampling_view *view, vec3 direction, vec2 *p) {
    vec3 local = frame_local_from_world(&view->frame, direction);
    if (view->inside) {
        float turn = atan2f(local.y, local.x) * (0.5f * INV_PI_F);
        *p = (vec2){turn < 0 ? turn + 1 : turn, 0.5f - 0.5f * local.z};
        return true;
    }
    if (local.z <= 0) return false;
    float sin2 = local.x * local.x + local.y * local.y, height = sin2 / (1 + local.z); // 1 - cosine
    float r2 = height / view->rim;
    if (!(r2 <= 1 + 1e-4f + 4e-7f / sqrtf(view->rim)))
        return false; // a little beyond the rim: what rounding may do to a sample
    float scale = sin2 > 0 ? sqrtf(fminf(r2, 1) / sin2) : 0;
    *p = square_from_disk((vec2){local.x * scale, local.y * scale});
    return true;
}

vec3 sampling_direction_from_image(const struct sampling_view *view, vec2 p) {
    float height, x, y;
    if (view->inside) {
        height = 2 * p.y;
        x = cosf(2 * PI_F * p.x), y = sinf(2 * PI_F * p.x);
    } else {
        vec2 disk = warp_concentric_disk(p);
        float r2 = disk.x * disk.x + disk.y * disk.y, inverse = r2 > 0 ? 1 / sqrtf(r2) : 0;
        height = fminf(r2, 1) * view->rim;
        x = disk.x * inverse, y = disk.y * inverse;
    }
    float sine = sqrtf(fmaxf(0, height * (2 - height)));
    return vec3_normalize(frame_world_from_local(&view->frame, vec3_make(x * sine, y * sine, 1 - height)));
}

// --- Memory ---

static void find_sides(struct sampling_density *density) {
    int n = density->directions;
    for (int y = 0; y < n; y++)
        for (int x = 0; x < n; x++) {
            vec2 square = {((float)x + 0.5f) / (float)n, ((float)y + 0.5f) / (float)n};
            vec3 side = frame_from_normal(direction_from_octahedral(square)).s;
            memcpy(density->sides[y * n + x], (float[3]){side.x, side.y, side.z}, sizeof *density->sides);
        }
}

enum status sampling_allocate(struct sampling_density **density, const struct proxy *proxy, int directions,
                              int anchor_count, struct error *error) {
    struct sampling_density *d = *density = calloc(1, sizeof *d);
    if (!d) return error_set(error, STATUS_MEMORY, "out of memory for a sampling density");
    d->center = vec3_from(proxy->center);
    d->radius = proxy->radius;
    d->directions = directions;
    d->anchor_count = anchor_count;
    size_t cells = sampling_cell_count(d), anchors = (size_t)anchor_count;
    d->codes = calloc(cells, MAP_BYTES);
    d->residual_share = calloc(cells, 1);
    d->prefix = calloc(cells * MAP_SIDE * (MAP_SIDE + 1), sizeof(uint16_t));
    d->rows = calloc(cells * (MAP_SIDE + 1), sizeof(uint16_t));
    d->sides = calloc((size_t)directions * (size_t)directions, sizeof *d->sides);
    d->anchors = calloc(anchors + 1, sizeof *d->anchors);
    d->intensity = calloc((anchors + 1) * INTENSITY_CELLS, sizeof(float));
    if (d->codes && d->residual_share && d->prefix && d->rows && d->sides && d->anchors && d->intensity) {
        find_sides(d);
        return STATUS_OK;
    }
    sampling_density_destroy(d);
    *density = NULL;
    return error_set(error, STATUS_MEMORY, "out of memory for a sampling density");
}

void sampling_density_destroy(struct sampling_density *density) {
    if (!density) return;
    free(density->codes);
    free(density->residual_share);
    free(density->prefix);
    free(density->rows);
    free(density->sides);
    free(density->anchors);
    free(density->intensity);
    free(density);
}

void sampling_derive(struct sampling_density *density) {
    for (size_t cell = 0; cell < sampling_cell_count(density); cell++) {
        uint8_t *codes = density->codes + cell * MAP_BYTES;
        bool empty = true;
        for (int k = 0; k < MAP_BYTES; k++) empty = empty && codes[k] == 0;
        if (empty) memset(codes, 0x11, MAP_BYTES);
        uint16_t *rows = density->rows + cell * (MAP_SIDE + 1);
        for (int y = 0; y < MAP_SIDE; y++) { // at most 256 * 15^2 = 57600: fits
            uint16_t *prefix = density->prefix + (cell * MAP_SIDE + (size_t)y) * (MAP_SIDE + 1);
            for (int x = 0; x < MAP_SIDE; x++) {
                int code = codes[(y * MAP_SIDE + x) / 2] >> (x & 1 ? 4 : 0) & 15;
                prefix[x + 1] = (uint16_t)(prefix[x] + code * code);
            }
            rows[y + 1] = (uint16_t)(rows[y] + prefix[MAP_SIDE]);
        }
    }
}
