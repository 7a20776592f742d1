// One room lit by one lamp: renderings in equal CPU time against a long one, with crops, differences and errors.
#pragma once

#include "evidence/kept_render.h"

enum { ROOM_CROPS = 2 };

struct room_comparison {
    const char *room, *lamp; // names of the files
    const char *size; // of the lamp in rooms with that variable, or NULL
    bool furnished; // see render_request
    int width, height; // at scale 1
    bool path_too; // the path tracer of the geometry stands beside bdpt
    struct room_crop crops[ROOM_CROPS]; // side 0: none
};

enum status compare_room(struct figure_kit *kit, const struct room_comparison *room, struct sheet *sheet,
                         struct error *error);
int compare_room_steps(const struct room_comparison *room);
