// Path tracer: how many light samples a path draws where the camera looks, tile by tile. Each costs a part of what a
// path costs; and it lessens the noise of the light from lamps there, not of the rest. With D and R these variances of
// one light sample and of all else, and s light samples in the time of a path, the mean over the tiles of R + D / n
// times that of 1 + n / s is least at n = sqrt(s D / (mean of R + D / n)) (after Bolin and Meyer 1997, "An error metric
// for Monte Carlo ray tracing", who split paths like that). D and R come from earlier passes, of which a pass is
// independent otherwise.
#include "trace/path_state.h"

enum { ROUNDS = 3 };
// Measured, of 4 to 30. By the time that they take it would be 5 to 9, but the light from lamps has the sharper
// patterns, so pixels share more of the rest.
static const float samples_a_path = 10;
static const float most_noise = 2; // of a pixel's luminance squared: outliers are spread by what pixels share

static void measure(const struct path_tracer *tracer, int tile) {
    const struct film *film = tracer->film;
    const struct path_tile t = path_tile_of(tracer, tile);
    struct path_lights *lights = &tracer->tile_lights[tile];
    float lamps = 0, rest = 0;
    for (int y = t.y0; y < t.y1; y++) {
        for (int x = t.x0; x < t.x1; x++) {
            const size_t pixel = (size_t)y * (size_t)film->width + (size_t)x;
            float variances[SHARED_PARTS];
            shared_light_variances(tracer->shared, pixel, variances);
            for (int i = 0; i < SHARED_PARTS; i++) {
                const float noise = minf(variances[i] / sqrf(tracer->expected[pixel]), most_noise);
                *(i - i % SHARED_WEIGHTS == SHARED_DIRECT ? &lamps : &rest) += noise;
            }
        }
    }
    const float pixels = (float)(t.x1 - t.x0) * (float)(t.y1 - t.y0);
    lights->noise = lamps / pixels * (float)tracer->passes / lights->inverse_counts;
    lights->rest = rest / pixels;
}

static float mean_noise(const struct path_tracer *tracer) {
    float sum = 0;
    for (int tile = 0; tile < tracer->tile_count; tile++) {
        const struct path_lights *lights = &tracer->tile_lights[tile];
        sum += lights->rest + lights->noise / (float)lights->count;
    }
    return sum / (float)tracer->tile_count;
}

static void choose_counts(struct path_tracer *tracer) {
    for (int tile = 0; tile < tracer->tile_count; tile++) measure(tracer, tile);
    for (int round = 0; round < ROUNDS; round++) {
        const float mean = mean_noise(tracer);
        for (int tile = 0; mean > 0 && tile < tracer->tile_count; tile++) {
            struct path_lights *lights = &tracer->tile_lights[tile];
            const float count = roundf(sqrtf(samples_a_path * lights->noise / mean));
            lights->count = (int)minf(maxf(count, 1), PATH_MOST_LIGHTS);
        }
    }
}

void path_light_learn(struct path_tracer *tracer) {
    for (int tile = 0; tile < tracer->tile_count; tile++) {
        struct path_lights *lights = &tracer->tile_lights[tile];
        if (tracer->passes > 0) {
            lights->inverse_counts += 1 / (float)lights->count;
            lights->first += (uint32_t)lights->count;
        } else { // perhaps not the film's first pass: an earlier tracer has drawn no more than this
            *lights = (struct path_lights){.count = 1, .first = PATH_MOST_LIGHTS * (uint32_t)tracer->pass};
        }
    }
    if (tracer->shared && path_looks_back(tracer->film) && tracer->passes >= PATH_PASSES_BEFORE) choose_counts(tracer);
    tracer->passes++;
}
