// The finished luminaire, shared by luminaire.c and luminaire_file.c.
#pragma once

#include "luminaire/hull_file.h"
#include "luminaire/light_field.h"
#include "luminaire/paper.h"
#include "luminaire/proxy.h"
#include "luminaire/sampling.h"

struct emission { // of one group of emitters, or of the whole lamp
    struct light_field *light;
    struct sampling_density *density;
    struct view_field *view; // NULL without a hull
    float flux[3]; // as baked
    char name[LUMINAIRE_NAME_SIZE];
};

struct luminaire {
    struct proxy_shape shape;
    struct paper *paper; // the published networks, which then stand in place of transparency and emissions; or NULL
    struct transparency *transparency; // NULL: T = 0
    struct hull *hull; // every emission has a view field then; or NULL
    struct emission emissions[LUMINAIRE_MAX_GROUPS];
    int emission_count; // at least 1; with `paper` the one holds the flux alone
    bool grouped; // the emissions have names
    bool borrowed; // a dimmed copy: what it points to belongs to the original
    // The light of emission g is multiplied by factor[g]. Light samples are drawn from its density with probability
    // share[g]; the shares sum to 1.
    float factor[LUMINAIRE_MAX_GROUPS][3], share[LUMINAIRE_MAX_GROUPS];
    float flux[3]; // with the factors
    char **keys, **values;
    size_t metadata_count;
    float scattering[2][3]; // back, onward
    size_t bytes; // of the file
};

// Flux and shares from the emissions and the factors: after any change of them.
void luminaire_derive(struct luminaire *luminaire);

enum status luminaire_set_metadata(struct luminaire *luminaire, const char *const *keys, const char *const *values,
                                   size_t count, struct error *error);
size_t
luminaire_measure(const struct luminaire *luminaire); // size of the file that luminaire_save would write, in tensors
