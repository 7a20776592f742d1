// Where the project's own rooms and lamps are: in the build tree or in what was installed, whatever the current folder.
#pragma once

#include <limits.h>

#include "base/error.h"

struct evidence_data { // folders
    char rooms[PATH_MAX]; // ROOM.xml
    char things[PATH_MAX]; // furniture/, textures/: what the rooms' variables of these names take
    char lamps[PATH_MAX]; // LAMP/LAMP.xml and its meshes
    char baked[PATH_MAX]; // LAMP.safetensors
};

// `folder`: with scenes/ and lamps/ in it, as an installation has them in share/sconce; NULL: found from where this
// library is. Errors: there is no such folder.
enum status evidence_data_find(struct evidence_data *data, const char *folder, struct error *error);
// Paths of files, which need not exist. Buffers have PATH_MAX bytes.
void evidence_room(char *path, const struct evidence_data *data, const char *room);
void evidence_thing(char *path, const struct evidence_data *data, const char *thing); // "furniture", "textures"
void evidence_lamp(char *path, const struct evidence_data *data, const char *lamp); // its geometry
void evidence_baked(char *path, const struct evidence_data *data, const char *lamp);
// The same for a file that must be there: said before anything long begins.
enum status evidence_baked_check(char *path, const struct evidence_data *data, const char *lamp, struct error *error);
