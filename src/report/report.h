// The HTML report: pictures, differences and figures of several renderings against one reference, in one file.
#pragma once

#include "base/error.h"

#include <stddef.h>

struct report_entry {
    const char *name, *image_path;
    const char *json_path; // of `sconce render --json`, or NULL
};

struct report_options {
    const char *output, *title;
    struct report_entry reference;
    const struct report_entry *entries;
    size_t entry_count;
    const char *mask_path; // or NULL
    const char *bake_json_path; // of `sconce bake --json`, or NULL
};

enum status report_write(const struct report_options *options, struct error *error);
