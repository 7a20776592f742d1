// The integrators, in the order of enum integrator_kind.
#include "trace/integrator.h"

extern const struct integrator_type path_integrator, bdpt_integrator, particle_integrator;

const struct integrator_type *const integrator_table[] = {&path_integrator, &bdpt_integrator, &particle_integrator,
                                                          NULL};
