#include "trace/lamp_draws.h"

#include <stdlib.h>

#include "trace/luminaire_crossing.h"

enum status lamp_draws_init(struct lamp_draws *draws, size_t capacity, struct error *error) {
    draws->points = calloc(capacity, sizeof *draws->points);
    draws->numbers = calloc(capacity, sizeof *draws->numbers);
    draws->directions = calloc(capacity, sizeof *draws->directions);
    draws->pdfs = calloc(capacity, sizeof *draws->pdfs);
    if (draws->points && draws->numbers && draws->directions && draws->pdfs) return STATUS_OK;
    return error_set(error, STATUS_MEMORY, "out of memory for %zu light samples", capacity);
}

void lamp_draws_fini(struct lamp_draws *draws) {
    free(draws->points);
    free(draws->numbers);
    free(draws->directions);
    free(draws->pdfs);
}

void lamp_draws_ask(struct lamp_draws *draws, size_t i, const struct luminaire_instance *lamp, vec3 point, vec2 u,
                    float third) {
    vec3_store(draws->points[i], luminaire_local_point(lamp, point));
    vec3_store(draws->numbers[i], (vec3){u.x, u.y, third});
}

void lamp_draws_answer(struct lamp_draws *draws, size_t count, const struct luminaire_instance *lamp) {
    luminaire_sample(lamp->luminaire, count, (const float(*)[3])draws->points, (const float(*)[3])draws->numbers,
                     draws->directions, draws->pdfs);
}

vec3 lamp_draws_direction(const struct lamp_draws *draws, size_t i, const struct luminaire_instance *lamp) {
    return luminaire_world_direction(lamp, vec3_from(draws->directions[i]));
}
