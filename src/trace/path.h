// The path tracer: unidirectional, wavefront, with next-event estimation and multiple importance sampling.
#pragma once

#include "trace/integrator.h"

extern const struct integrator_type path_integrator;

// Which strategies count: all give the same mean, which is what the tests compare. PATH_MIS leaves the caustics of
// baked lamps to particles (caustic.h), the others have none.
enum path_strategy { PATH_MIS, PATH_MIS_ALONE, PATH_LIGHTS_ONLY, PATH_BSDF_ONLY };
enum status path_create(const struct scene *scene, const struct run *run, enum path_strategy strategy, void **state,
                        struct error *error);
// Contributions that were not finite and were left out, over all passes.
size_t path_dropped(const void *state);
