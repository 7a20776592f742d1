// The integrators, in the order of enum integrator_kind.
#include "trace/integrator.h"

#include <string.h>

extern const struct integrator_type path_integrator, bdpt_integrator, particle_integrator;

const struct integrator_type *const integrator_table[] = {&path_integrator, &bdpt_integrator, &particle_integrator,
                                                          NULL};

enum status integrator_image(const struct integrator_type *type, const void *state, const struct film *film,
                             const struct run *run, struct image *image, struct error *error) {
    enum status status = film_image(film, image, error);
    if (status || !state || !type->finish) return status;
    status = type->finish(state, film, image, run, error);
    if (status) image_fini(image);
    return status;
}

bool integrator_find(enum integrator_kind *kind, const char *name) {
    for (int i = 0; integrator_table[i]; i++) {
        if (strcmp(integrator_table[i]->name, name)) continue;
        *kind = (enum integrator_kind)i;
        return true;
    }
    return false;
}
