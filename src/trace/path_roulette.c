// Russian roulette by what a pixel is expected to hold (after Vorba and Krivanek 2016, "Adjoint-driven Russian roulette
// and splitting in light transport simulation", with the brightness of the whole picture in place of a cache of
// radiance): paths that bring little beside it go on with a probability in proportion. The expectation comes from
// earlier passes, of which a pass is independent otherwise, so its mean is the same whatever they found.
#include "trace/path_state.h"

enum { REACH = 2 };
static const float least = 0.05f; // of the typical luminance: what darker pixels count as
static const float most = 8; // likewise of single bright pixels, which may be outliers
static const float least_survival = 0.1f; // so that no weight grows by more than its inverse
static const float met = 2.5f; // of the typical luminance: what a path is taken to meet (measured: 1.5 to 7 cost more)
static const float guided_met = 2; // in its place, of the radiance that the guide expects from there
static const float least_met = 0.75f; // of the typical luminance: what a guided path is taken to meet at least

static float pixel_luminance(const struct film *film, int x, int y) {
    const double *mean = &film->mean[3 * ((size_t)y * (size_t)film->width + (size_t)x)];
    return maxf(rgb_luminance(rgb_make((float)mean[0], (float)mean[1], (float)mean[2])), 0);
}

float path_expected_luminance(const struct film *film, int x, int y, float typical) {
    const float bound = most * typical;
    float sum = 0;
    int count = 0;
    for (int v = y - REACH; v <= y + REACH; v++) {
        for (int u = x - REACH; u <= x + REACH; u++) {
            if (u < 0 || v < 0 || u >= film->width || v >= film->height) continue;
            sum += minf(pixel_luminance(film, u, v), bound);
            count++;
        }
    }
    return maxf(sum / (float)count, least * typical);
}

float path_typical_luminance(const struct film *film) {
    double sum = 0, bounded = 0, count = (double)film->width * (double)film->height;
    for (int y = 0; y < film->height; y++)
        for (int x = 0; x < film->width; x++) sum += (double)pixel_luminance(film, x, y);
    for (int y = 0; y < film->height; y++)
        for (int x = 0; x < film->width; x++)
            bounded += (double)minf(pixel_luminance(film, x, y), (float)(sum / count));
    return (float)(bounded / count);
}

void path_expect(struct path_tracer *tracer) {
    const struct film *film = tracer->film;
    if (!path_looks_back(film)) return;
    tracer->typical = path_typical_luminance(film);
    for (int y = 0; y < film->height; y++)
        for (int x = 0; x < film->width; x++)
            tracer->expected[(size_t)y * (size_t)film->width + (size_t)x] =
                path_expected_luminance(film, x, y, tracer->typical);
}

float path_survival(const struct path_tracer *tracer, const struct path *path, float incoming) {
    float weight = rgb_max(path->beta) * sqrf(path->eta);
    bool late = path->depth >= tracer->scene->rr_depth;
    const float meets = incoming > 0 ? guided_met * maxf(incoming, least_met * tracer->typical) : met * tracer->typical;
    if (path->expected > 0) weight = maxf(weight * meets / path->expected, least_survival);
    return path->expected > 0 || late ? minf(weight, late ? 0.95f : 1) : 1;
}
