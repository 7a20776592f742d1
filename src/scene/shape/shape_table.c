// Every type of shape. A new one is a file and a line here.
#include "scene/shape.h"

extern const struct shape_type shape_obj, shape_ply, shape_serialized, shape_sphere, shape_rectangle, shape_disk,
    shape_cube, shape_cylinder;

const struct shape_type *const shape_table[] = {&shape_obj,    &shape_ply,       &shape_serialized,
                                                &shape_sphere, &shape_rectangle, &shape_disk,
                                                &shape_cube,   &shape_cylinder,  NULL};
