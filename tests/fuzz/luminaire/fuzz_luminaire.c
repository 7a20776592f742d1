// Any bytes as a luminaire file: refused with a message, or usable without a fault.
#include <math.h>
#include <stdlib.h>

#include "luminaire/hull.h"
#include "luminaire/luminaire.h"
#include "luminaire/view_field.h"

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t length);

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t length) {
    struct luminaire *luminaire;
    struct error error = {0};
    if (luminaire_parse(&luminaire, "fuzz", bytes, length, &error) != STATUS_OK) {
        if (luminaire || !error.text[0]) abort();
        return 0;
    }
    float center[3], radius, t_near, t_far, l[2][3], d[2][3], pdf[2];
    luminaire_bounds(luminaire, center, &radius);
    const float points[2][3] = {{center[0], center[1], center[2]},
                                {center[0] + 2 * radius, center[1], center[2] + radius}};
    const float w[2][3] = {{0, 0, 1}, {-0.6f, 0, -0.8f}}, u[2][3] = {{0.5f, 0.25f, 0.75f}, {0.99f, 0.1f, 0.2f}};
    luminaire_span(luminaire, points[1], w[1], &t_near, &t_far);
    luminaire_eval(luminaire, 2, points, w, l);
    luminaire_transmittance(luminaire, 2, points, w, l);
    luminaire_sample(luminaire, 2, points, u, d, pdf);
    luminaire_pdf(luminaire, 2, points, w, pdf);
    if (luminaire_hull(luminaire)) {
        struct view_point at = {.point = {center[0], center[1], center[2]}, .normal = {0, 0, 1}, .w = {0, 0.6f, 0.8f}};
        luminaire_view(luminaire, 1, &at, l);
    }
    const float factors[LUMINAIRE_MAX_GROUPS][3] = {{0.5f, 0, 2}, {1, 1, 1}, {0}, {3, 0, 0}};
    struct luminaire *dimmed;
    if (luminaire_dim(&dimmed, luminaire, factors, &error) == STATUS_OK) {
        luminaire_eval(dimmed, 2, points, w, l);
        luminaire_sample(dimmed, 2, points, u, d, pdf);
        luminaire_destroy(dimmed);
    }
    luminaire_destroy(luminaire);
    return 0;
}
