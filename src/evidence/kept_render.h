// A rendering of a room that is kept on disk: asked for again, it is read instead of made.
#pragma once

#include "evidence/figure.h"
#include "scene/scene.h"

struct room_crop { // a square part of a picture
    float x, y, side; // top left corner in widths and heights; side in heights, 0: no crop
};

struct render_request {
    const char *name; // of the kept files: FOLDER/kept/NAME.exr, NAME.json
    const char *room; // a scene file
    const char *lamp; // .xml or .safetensors
    const char *integrator;
    const char *appearance, *keep; // of a baked lamp; NULL: the room's
    const char *size; // value of the room's variable `size`, or NULL
    bool furnished; // the room has the variables `furniture` and `textures`
    enum lamp_mask mask; // of all baked lamps
    double cpu_seconds;
    int width, height; // of the whole picture
    struct room_crop crop; // the part that is rendered
    bool lamp_seen; // also make the mask of the pixels that do not look at the (baked) lamp
};

struct kept_render {
    struct image image;
    struct image outside; // 1 where no lamp is seen; only with lamp_seen
    double cpu_s;
    int samples;
};

enum status kept_render(struct figure_kit *kit, const struct render_request *request, struct kept_render *render,
                        struct error *error);
void kept_render_fini(struct kept_render *render);
