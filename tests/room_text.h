// Rooms as scene text: their pieces, and one that is furnished.
#pragma once

#define HEAD(depth, size, from, to)                                                                                    \
    "<scene version='3.0.0'><integrator type='path'><integer name='max_depth' value='" depth                           \
    "'/></integrator><sensor type='perspective'><float name='fov' value='70'/><transform name='to_world'><lookat "     \
    "origin='" from "' target='" to                                                                                    \
    "' up='0,0,1'/></transform><film type='hdrfilm'><integer name='width' value='" size                                \
    "'/><integer name='height' value='" size "'/><rfilter type='box'/></film></sensor>"
#define BOX(scale, place, material)                                                                                    \
    "<shape type='cube'><transform name='to_world'><scale " scale "/><translate " place                                \
    "/></transform><boolean name='flip_normals' value='true'/>" material "</shape>"
#define SLAB(scale, place, material)                                                                                   \
    "<shape type='cube'><transform name='to_world'><scale " scale "/><translate " place "/></transform>" material      \
    "</shape>"
#define DIFFUSE(value) "<bsdf type='diffuse'><rgb name='reflectance' value='" value "'/></bsdf>"
#define PANEL(scale, turn, place, value)                                                                               \
    "<shape type='rectangle'><transform name='to_world'><scale " scale "/><rotate x='1' angle='" turn                  \
    "'/><translate " place "/></transform><emitter type='area'><rgb name='radiance' value='" value                     \
    "'/></emitter></shape>"

// Lit by way of its ceiling.
static const char *const furnished_room =
    HEAD("-1", "64", "0,-1.9,0", "0,2,-0.2") BOX("x='2' y='2' z='1.5'", "x='0'", DIFFUSE("0.8 0.6 0.5"))
        SLAB("x='0.5' y='0.3' z='0.4'", "x='0.7' y='0.6' z='-1.1'",
             "<bsdf type='plastic'><rgb name='diffuse_reflectance' value='0.2 0.4 0.6'/></bsdf>")
            SLAB("x='0.3' y='0.3' z='0.6'", "x='-0.9' y='0.9' z='-0.9'",
                 "<bsdf type='roughconductor'><float name='alpha' value='0.2'/></bsdf>")
                SLAB("x='0.02' y='0.8' z='0.8'", "x='-1.8' y='0.2' z='0'", "<bsdf type='conductor'/>")
                    PANEL("x='0.3' y='0.3'", "0", "x='0.5' y='0.5' z='0.8'", "30") "</scene>";
