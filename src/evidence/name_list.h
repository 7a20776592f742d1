// Names in a list with commas between them, as --only takes it.
#pragma once

#include <stdbool.h>
#include <string.h>

static inline bool name_listed(const char *list, const char *name) {
    const size_t length = strlen(name);
    for (const char *p = list; p; p = strchr(p, ','), p += p != NULL)
        if (!strncmp(p, name, length) && (!p[length] || p[length] == ',')) return true;
    return false;
}
