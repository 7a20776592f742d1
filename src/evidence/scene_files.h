// What a scene is made of on disk: for keys that say from what a result came, and for a lamp's size in bytes.
#pragma once

#include "base/error.h"
#include "format/description.h"

#include <stddef.h>
#include <stdint.h>

struct scene_files {
    uint64_t hash; // of all bytes, see kept.h
    size_t bytes;
};

// The file itself (.xml or .safetensors), and everything that a scene's `filename`s name, lamps included.
enum status scene_files_measure(struct scene_files *files, const char *path, const struct definition *definitions,
                                size_t definition_count, struct error *error);
