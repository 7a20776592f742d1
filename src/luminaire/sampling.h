// The sampling density: which direction from a shading point s towards the lamp. A mixture of
//   1. a uniform share over the cone of the bounding sphere (s inside it: over all directions),
//   2. a residual map: for the cell of s (direction and distance from the centre; inside: a cell of a 4x4x4 grid) a
//   16x16
//      image over that cone, uniform in solid angle, in a 4-bit square-root code,
//   3. nested cones about the anchors, chosen by the anchors' intensities towards s over the squared distance.
// docs/design.md 3 ("sampling") has the measurements behind it. Sampling and density agree exactly.
#pragma once

#include "luminaire/build.h"
#include "math/vec.h"

enum {
    MAP_SIDE = 16,
    MAP_PIXELS = MAP_SIDE * MAP_SIDE,
    MAP_BYTES = MAP_PIXELS / 2,
    DISTANCE_BINS = 3,
    INSIDE_SIDE = 4,
    INSIDE_CELLS = INSIDE_SIDE * INSIDE_SIDE * INSIDE_SIDE,
    INTENSITY_SIDE = 8,
    INTENSITY_CELLS = INTENSITY_SIDE * INTENSITY_SIDE,
    CONE_COUNT = 3,
    SAMPLING_MAX_ANCHORS = 256,
    SAMPLING_MAX_DIRECTIONS = 64,
};

#define SAMPLING_UNIFORM_SHARE 0.05f
#define SAMPLING_OUTSIDE2 1.0001f // from this distance^2 on, in radii, a point is outside
#define SAMPLING_BIN_1 1.4f // where the distance bins begin, in radii; the first at the sphere
#define SAMPLING_BIN_2 2.5f

struct sampling_density {
    vec3 center;
    float radius;
    int directions; // cells of directions: directions x directions over the octahedral square
    uint8_t *codes; // [cell][MAP_BYTES]: pixel 2k in the low half of byte k
    uint8_t *residual_share; // [cell] share of the map against the anchors, of 255
    uint16_t *prefix; // [cell][MAP_SIDE][MAP_SIDE + 1] and [cell][MAP_SIDE + 1] of the rows: derived from codes
    uint16_t *rows;
    float (*sides)[3]; // [direction cell] the image's x axis before it is turned towards the centre: derived
    int anchor_count;
    float (*anchors)[3];
    float *intensity; // [anchor][INTENSITY_CELLS] mean radiant intensity towards the octahedral cells
    float cone_radius[CONE_COUNT], cone_share[CONE_COUNT]; // [length] about the anchor, ascending; shares sum to 1
};

size_t sampling_cell_count(const struct sampling_density *density);
enum status sampling_allocate(struct sampling_density **density, const struct proxy *proxy, int directions,
                              int anchor_count, struct error *error);
void sampling_derive(struct sampling_density *density); // prefix sums from the codes; an empty cell becomes uniform

// The cell of a shading point and the frame of its image: z towards the centre.
struct sampling_view {
    size_t cell;
    bool inside;
    struct frame frame;
    float rim; // 1 - cosine of the cone's half angle
};
struct sampling_view sampling_view_make(const struct sampling_density *density, vec3 s);
// Image coordinates in [0,1)^2 of a direction, false outside the cone; and back.
bool sampling_image_from_direction(const struct sampling_view *view, vec3 direction, vec2 *p);
vec3 sampling_direction_from_image(const struct sampling_view *view, vec2 p);

void sampling_sample(const struct sampling_density *density, vec3 s, vec3 u, vec3 *direction, float *pdf_sa);
float sampling_pdf(const struct sampling_density *density, vec3 s, vec3 direction);
// Any n; by vector kernels (sampling_kernel.h), equal to the above up to rounding.
void sampling_sample_batch(const struct sampling_density *density, size_t n, const float (*s)[3], const float (*u)[3],
                           float (*direction)[3], float *pdf_sa);
void sampling_pdf_batch(const struct sampling_density *density, size_t n, const float (*s)[3],
                        const float (*direction)[3], float *pdf_sa);
