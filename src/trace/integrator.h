// The integrators render passes of one sample per pixel into a film. integrator_table lists them.
#pragma once

#include <stdbool.h>

#include "base/error.h"
#include "base/run.h"
#include "scene/scene.h"
#include "trace/film.h"

struct integrator_type {
    const char *name, *help;
    // One pass (index `pass`) into film->pass. The result is a pure function of (scene, run->seed, pass) and, for path,
    // of the passes that this state has rendered before (its roulette, guide and cache learn from them); for any number
    // of threads: splats are gathered per block and added in block order. `state` is made by create, freed by destroy.
    enum status (*create)(const struct scene *scene, const struct run *run, void **state, struct error *error);
    enum status (*render_pass)(void *state, struct film *film, uint64_t pass, const struct run *run,
                               struct error *error);
    // What the state knows beyond the film changes the film's image; NULL: nothing does.
    enum status (*finish)(const void *state, const struct film *film, struct image *image, const struct run *run,
                          struct error *error);
    void (*destroy)(void *state);
};
extern const struct integrator_type
    *const integrator_table[]; // path, bdpt, particle in the order of enum integrator_kind; ends with NULL
// The picture so far: film_image, finished. `state`: of all the film's passes, of its last ones, or NULL.
enum status integrator_image(const struct integrator_type *type, const void *state, const struct film *film,
                             const struct run *run, struct image *image, struct error *error);
bool integrator_find(enum integrator_kind *kind, const char *name); // false: there is none of that name
