// One room lit by one lamp: renderings in equal CPU time against a long one, with crops, differences and errors.
#pragma once

#include "evidence/kept_render.h"

struct room_crop { // fractions of the picture's width and height
    float x, y, side; // top left corner; side of the square as a fraction of the height
};

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
// The reference alone: bdpt of the geometry.
enum status compare_room_reference(struct figure_kit *kit, const struct room_comparison *room,
                                   struct kept_render *render, struct error *error);
#define ROOM_EQUAL_S 30 // CPU seconds at scale 1 of all but the reference
