// Every texture there is: a new one is a file beside this one and a line in the list.
#include "scene/texture.h"

#define TEXTURES(X) X(bitmap) X(checkerboard) X(scale)

#define DECLARE(name) extern const struct texture_type texture_##name;
TEXTURES(DECLARE)

#define ENTRY(name) &texture_##name,
const struct texture_type *const texture_table[] = {TEXTURES(ENTRY) NULL};
