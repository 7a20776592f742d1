// Every scattering function there is: a new one is a file beside this one and a line in the list.
#include "scene/bsdf.h"

#define BSDFS(X)                                                                                                       \
    X(blend)                                                                                                           \
    X(bumpmap)                                                                                                         \
    X(conductor)                                                                                                       \
    X(dielectric)                                                                                                      \
    X(difftrans)                                                                                                       \
    X(diffuse)                                                                                                         \
    X(mask)                                                                                                            \
    X(mixture)                                                                                                         \
    X(normalmap)                                                                                                       \
    X(null)                                                                                                            \
    X(plastic)                                                                                                         \
    X(principled)                                                                                                      \
    X(roughconductor)                                                                                                  \
    X(roughdielectric)                                                                                                 \
    X(roughplastic)                                                                                                    \
    X(thindielectric)                                                                                                  \
    X(twosided)

#define DECLARE(name) extern const struct bsdf_type bsdf_##name;
BSDFS(DECLARE)

#define ENTRY(name) &bsdf_##name,
const struct bsdf_type *const bsdf_table[] = {BSDFS(ENTRY) NULL};
