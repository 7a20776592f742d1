// Sampling and density of the mixture; see sampling.h.
#include "luminaire/sampling.h"
#include "math/warp.h"

struct mixture { // for one shading point
    struct sampling_view view;
    float map_share, anchor_share, solid_angle;
    float weight[SAMPLING_MAX_ANCHORS]; // of the anchors; sums to 1
};

// 1 - cosine of the half angle of the cone about a ball; 2 (all directions) from within it.
static float cone_height(float radius, float distance2) {
    float sin2 = radius * radius / distance2;
    return sin2 < 0.998f ? sin2 / (1 + sqrtf(1 - sin2)) : 2;
}

static void mixture_make(const struct sampling_density *density, vec3 s, struct mixture *mixture) {
    mixture->view = sampling_view_make(density, s);
    mixture->solid_angle = 2 * PI_F * mixture->view.rim;
    mixture->map_share = 1 - SAMPLING_UNIFORM_SHARE;
    mixture->anchor_share = 0;
    if (density->anchor_count == 0) return;
    float total = 0, floor2 = sqrf(density->cone_radius[CONE_COUNT - 1]);
    for (int i = 0; i < density->anchor_count; i++) {
        vec3 to_s = vec3_sub(s, vec3_from(density->anchors[i]));
        float distance2 = vec3_dot(to_s, to_s), side = 1 / sqrtf(fmaxf(distance2, 1e-30f));
        vec2 square = octahedral_from_direction(distance2 > 1e-30f ? vec3_scale(to_s, side) : vec3_make(0, 0, 1));
        int x = (int)(square.x * INTENSITY_SIDE), y = (int)(square.y * INTENSITY_SIDE);
        x = x < INTENSITY_SIDE ? x : INTENSITY_SIDE - 1, y = y < INTENSITY_SIDE ? y : INTENSITY_SIDE - 1;
        mixture->weight[i] =
            density->intensity[i * INTENSITY_CELLS + y * INTENSITY_SIDE + x] / fmaxf(distance2, floor2);
        total += mixture->weight[i];
    }
    if (!(total > 0)) return;
    float share = (float)density->residual_share[mixture->view.cell] / 255;
    mixture->map_share = (1 - SAMPLING_UNIFORM_SHARE) * share;
    mixture->anchor_share = 1 - SAMPLING_UNIFORM_SHARE - mixture->map_share;
    for (int i = 0; i < density->anchor_count; i++) mixture->weight[i] /= total;
}

static float mixture_pdf(const struct sampling_density *density, const struct mixture *mixture, vec3 s,
                         vec3 direction) {
    float pdf = 0;
    vec2 p;
    if (sampling_image_from_direction(&mixture->view, direction, &p)) {
        int x = (int)(p.x * MAP_SIDE), y = (int)(p.y * MAP_SIDE);
        x = x < MAP_SIDE ? x : MAP_SIDE - 1, y = y < MAP_SIDE ? y : MAP_SIDE - 1;
        size_t cell = mixture->view.cell;
        const uint16_t *prefix = density->prefix + (cell * MAP_SIDE + (size_t)y) * (MAP_SIDE + 1);
        float total = (float)density->rows[cell * (MAP_SIDE + 1) + MAP_SIDE];
        float relative = (float)(prefix[x + 1] - prefix[x]) * MAP_PIXELS / total;
        pdf = (SAMPLING_UNIFORM_SHARE + mixture->map_share * relative) / mixture->solid_angle;
    }
    if (mixture->anchor_share == 0) return pdf;
    float sum = 0;
    for (int i = 0; i < density->anchor_count; i++) {
        vec3 to = vec3_sub(vec3_from(density->anchors[i]), s);
        float distance2 = vec3_dot(to, to), along = vec3_dot(to, direction);
        vec3 across = vec3_mad(direction, -along, to);
        // 1 - cosine of the angle between, without cancellation
        float across2 = vec3_dot(across, across), distance = sqrtf(distance2);
        float height =
            along > 0 ? across2 / (distance2 + along * distance) : 2 - across2 / (distance2 - along * distance);
        if (distance2 < 1e-30f) height = 0;
        for (int k = CONE_COUNT - 1; k >= 0; k--) { // nested: the widest first
            float rim = cone_height(density->cone_radius[k], fmaxf(distance2, 1e-30f));
            // A little beyond the rim: what rounding may do to a sample of the cone.
            if (height > rim * (1 + 1e-4f) + 3e-7f * sqrtf(rim)) break;
            sum += mixture->weight[i] * density->cone_share[k] / (2 * PI_F * rim);
        }
    }
    return pdf + mixture->anchor_share * sum;
}

float sampling_pdf(const struct sampling_density *density, vec3 s, vec3 direction) {
    struct mixture mixture;
    mixture_make(density, s, &mixture);
    return mixture_pdf(density, &mixture, s, direction);
}

// Finds the interval of u * total in ascending sums[0..MAP_SIDE] and the place of u in it, in [0, 1).
static int find_interval(const uint16_t *sums, float u, float *rest) {
    float at = fminf(u, 0.9999998f) * (float)sums[MAP_SIDE]; // below the total after rounding too
    int low = 0, high = MAP_SIDE;
    while (high - low > 1) {
        int middle = (low + high) / 2;
        if ((float)sums[middle] <= at)
            low = middle;
        else
            high = middle;
    }
    *rest = (at - (float)sums[low]) / (float)(sums[low + 1] - sums[low]);
    *rest = *rest < 0 ? 0 : *rest < 1 ? *rest : 0x1.fffffep-1f;
    return low;
}

static vec3 sample_map(const struct sampling_density *density, const struct sampling_view *view, vec2 u) {
    vec2 rest;
    int y = find_interval(density->rows + view->cell * (MAP_SIDE + 1), u.y, &rest.y);
    int x = find_interval(density->prefix + (view->cell * MAP_SIDE + (size_t)y) * (MAP_SIDE + 1), u.x, &rest.x);
    return sampling_direction_from_image(view, (vec2){((float)x + rest.x) / MAP_SIDE, ((float)y + rest.y) / MAP_SIDE});
}

static vec3 sample_anchor(const struct sampling_density *density, const struct mixture *mixture, vec3 s, float choice,
                          vec2 u) {
    int i = 0, k = 0;
    for (; i + 1 < density->anchor_count && choice >= mixture->weight[i]; i++) choice -= mixture->weight[i];
    choice = mixture->weight[i] > 0 ? choice / mixture->weight[i] : 0;
    for (; k + 1 < CONE_COUNT && choice >= density->cone_share[k]; k++) choice -= density->cone_share[k];
    vec3 to = vec3_sub(vec3_from(density->anchors[i]), s);
    float distance2 = fmaxf(vec3_dot(to, to), 1e-30f), rim = cone_height(density->cone_radius[k], distance2);
    struct frame frame =
        frame_from_normal(distance2 > 1e-30f ? vec3_scale(to, 1 / sqrtf(distance2)) : vec3_make(0, 0, 1));
    float height = u.x * rim, sine = sqrtf(fmaxf(0, height * (2 - height))), turn = 2 * PI_F * u.y;
    return vec3_normalize(frame_world_from_local(&frame, vec3_make(sine * cosf(turn), sine * sinf(turn), 1 - height)));
}

void sampling_sample(const struct sampling_density *density, vec3 s, vec3 u, vec3 *direction, float *pdf_sa) {
    struct mixture mixture;
    mixture_make(density, s, &mixture);
    vec2 place = {u.y, u.z};
    if (u.x < SAMPLING_UNIFORM_SHARE)
        *direction = sampling_direction_from_image(&mixture.view, place);
    else if (u.x < SAMPLING_UNIFORM_SHARE + mixture.map_share || mixture.anchor_share == 0)
        *direction = sample_map(density, &mixture.view, place);
    else
        *direction = sample_anchor(density, &mixture, s,
                                   (u.x - SAMPLING_UNIFORM_SHARE - mixture.map_share) / mixture.anchor_share, place);
    *pdf_sa = mixture_pdf(density, &mixture, s, *direction);
}
