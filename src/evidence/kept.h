// Numbers that are kept on disk with a key that says from what they were made.
#pragma once

#include <jansson.h>
#include <stdint.h>

#include "base/error.h"

// Adds the bytes of a file to a hash (base/hash.h).
enum status kept_hash_file(uint64_t *hash, const char *path, struct error *error);
enum status kept_save(const char *path, json_t *object, struct error *error); // takes the reference
json_t *kept_load(const char *path, const char *key); // NULL: absent, damaged or of another key (NULL: of any)
