// Directions from the picture that the sampling network draws: u.x chooses between the uniform share and the picture,
// (u.y, u.z) a row, a pixel of it, and the place within the pixel.
#include <math.h>

#include "luminaire/paper_private.h"
#include "math/warp.h"
#include "net/kernel.h"

static const float uniform_share = 0.05f;

// The picture's frame: the one for s straight below the centre (y is up) turned by the smallest angle, so that it
// changes smoothly with s everywhere but straight above (Frisvad 2012).
static struct frame picture_frame(vec3 n) {
    float across2 = n.x * n.x + n.z * n.z, lift = n.y < 0 ? across2 / (1 - n.y) : 1 + n.y;
    if (lift == 0) return (struct frame){{1, 0, 0}, {0, 0, 1}, n};
    float a = 1 / lift;
    return (struct frame){{1 - n.x * n.x * a, -n.x, -n.x * n.z * a}, {n.x * n.z * a, n.z, n.z * n.z * a - 1}, n};
}

static struct sampling_view view_make(const struct paper *paper, const float s[3]) {
    vec3 offset = vec3_make(s[0] - paper->center[0], s[1] - paper->center[1], s[2] - paper->center[2]);
    offset = vec3_scale(offset, 1 / paper->radius);
    float distance2 = vec3_dot(offset, offset), sin2 = 1 / fmaxf(distance2, 1);
    if (!(distance2 > 1.0001f)) return (struct sampling_view){0, true, picture_frame((vec3){0, 1, 0}), 2};
    vec3 to_center = vec3_scale(offset, -1 / sqrtf(distance2));
    return (struct sampling_view){0, false, picture_frame(to_center), sin2 / (1 + sqrtf(1 - sin2))};
}

void paper_view_direction(const struct paper *paper, const float s[3], const float p[2], float direction[3]) {
    struct sampling_view view = view_make(paper, s);
    vec3 d = sampling_direction_from_image(&view, (vec2){p[0], p[1]});
    vec3_store(direction, d);
}

struct picture {
    float importance[PAPER_PIXELS], rows[PAPER_SIDE], total;
};

// Of column `lane` of draw_pictures. A dark picture becomes uniform.
static void picture_make(const float *z, int lane, struct picture *picture) {
    picture->total = 0;
    for (int y = 0; y < PAPER_SIDE; y++) {
        picture->rows[y] = 0;
        for (int x = 0; x < PAPER_SIDE; x++) {
            int pixel = y * PAPER_SIDE + x;
            const float *at = z + 3 * pixel * DENSE_SLICE + lane;
            picture->importance[pixel] = at[0] + at[DENSE_SLICE] + at[2 * DENSE_SLICE];
            picture->rows[y] += picture->importance[pixel];
        }
        picture->total += picture->rows[y];
    }
    if (picture->total > 0) return;
    for (int i = 0; i < PAPER_PIXELS; i++) picture->importance[i] = 1;
    for (int y = 0; y < PAPER_SIDE; y++) picture->rows[y] = PAPER_SIDE;
    picture->total = PAPER_PIXELS;
}

// The entry of u * total in `weights`, and the place of u in it, in [0, 1). An entry of weight 0 is never chosen.
static int choose(const float weights[PAPER_SIDE], float total, float u, float *rest) {
    float at = u * total;
    int chosen = 0, last = -1;
    for (int i = 0; i < PAPER_SIDE; i++) {
        if (!(weights[i] > 0)) continue;
        last = i;
        if (at < weights[i]) break;
        at -= weights[i];
    }
    chosen = last < 0 ? 0 : last;
    *rest = weights[chosen] > 0 ? at / weights[chosen] : u;
    *rest = *rest > 0 ? (*rest < 1 ? *rest : 0x1.fffffep-1f) : 0;
    return chosen;
}

static vec2 picture_sample(const struct picture *picture, float u, float v) {
    vec2 rest;
    int y = choose(picture->rows, picture->total, v, &rest.y);
    int x = choose(picture->importance + y * PAPER_SIDE, picture->rows[y], u, &rest.x);
    return (vec2){((float)x + rest.x) / PAPER_SIDE, ((float)y + rest.y) / PAPER_SIDE};
}

static float mixture_pdf(const struct sampling_view *view, const struct picture *picture, vec3 direction) {
    vec2 p;
    if (!sampling_image_from_direction(view, direction, &p)) return 0;
    int x = (int)(p.x * PAPER_SIDE), y = (int)(p.y * PAPER_SIDE);
    x = x < PAPER_SIDE ? x : PAPER_SIDE - 1, y = y < PAPER_SIDE ? y : PAPER_SIDE - 1;
    float relative = picture->importance[y * PAPER_SIDE + x] / picture->total * PAPER_PIXELS;
    return (uniform_share + (1 - uniform_share) * relative) / (2 * PI_F * view->rim);
}

// The radiances [3 * pixel + channel][DENSE_SLICE] that the network sees from up to DENSE_SLICE points.
static void draw_pictures(const struct paper *paper, int count, const float (*s)[3], float *z) {
    _Alignas(64) float x[3 * DENSE_SLICE];
    paper_encode_points(paper, count, s, x);
    dense_packed_forward(paper_net(paper, PAPER_SAMPLING), count, x, z);
    size_t lanes = ((size_t)count + NET_LANES - 1) & ~(NET_LANES - 1UL);
    for (int row = 0; row < 3 * PAPER_PIXELS; row++) paper_radiance_from_log(z + row * DENSE_SLICE, lanes);
}

void paper_sample(const struct paper *paper, size_t n, const float (*s)[3], const float (*u)[3], float (*direction)[3],
                  float *pdf_sa) {
    _Alignas(64) float z[3 * PAPER_PIXELS * DENSE_SLICE];
    for (size_t first = 0; first < n; first += DENSE_SLICE) {
        int count = (int)(n - first < DENSE_SLICE ? n - first : DENSE_SLICE);
        draw_pictures(paper, count, s + first, z);
        for (int l = 0; l < count; l++) {
            size_t i = first + (size_t)l;
            struct sampling_view view = view_make(paper, s[i]);
            struct picture picture;
            picture_make(z, l, &picture);
            vec2 p = u[i][0] < uniform_share ? (vec2){u[i][1], u[i][2]} : picture_sample(&picture, u[i][1], u[i][2]);
            vec3 d = sampling_direction_from_image(&view, p);
            pdf_sa[i] = mixture_pdf(&view, &picture, d);
            vec3_store(direction[i], d);
        }
    }
}

void paper_pdf(const struct paper *paper, size_t n, const float (*s)[3], const float (*direction)[3], float *pdf_sa) {
    _Alignas(64) float z[3 * PAPER_PIXELS * DENSE_SLICE];
    for (size_t first = 0; first < n; first += DENSE_SLICE) {
        int count = (int)(n - first < DENSE_SLICE ? n - first : DENSE_SLICE);
        draw_pictures(paper, count, s + first, z);
        for (int l = 0; l < count; l++) {
            size_t i = first + (size_t)l;
            struct sampling_view view = view_make(paper, s[i]);
            struct picture picture;
            picture_make(z, l, &picture);
            pdf_sa[i] = mixture_pdf(&view, &picture, vec3_from(direction[i]));
        }
    }
}
