// Whole files: read, and written beside the target then renamed, so that no half-written file is ever left.
#pragma once

#include <stddef.h>
#include <stdint.h>

#include "base/error.h"

// *bytes is malloc'ed (caller frees), with a zero byte after the end that *length does not count.
enum status file_read(const char *path, uint8_t **bytes, size_t *length, struct error *error);
enum status file_write_atomic(const char *path, const void *bytes, size_t length, struct error *error);
// Makes a folder and those it lies in, where they are missing.
enum status folder_make(const char *path, struct error *error);
// `name` relative to the folder of `base_file`, or to the current folder where only that names something that exists;
// unchanged where it is absolute. Writes at most size bytes.
void path_resolve(char *result, size_t size, const char *base_file, const char *name);
