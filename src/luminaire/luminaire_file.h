// What the writer and the reader of the luminaire file share.
#pragma once

#include <stdio.h>

#include "luminaire/hull_file.h"

#define LUMINAIRE_FORMAT_KEY "format"
#define LUMINAIRE_FORMAT "sconce-luminaire"
#define LUMINAIRE_VERSION_KEY "format_version"
#define LUMINAIRE_VERSION "1"
#define LUMINAIRE_VERSION_GROUPS "2" // programs that know no groups must not take the first for the whole lamp
#define LUMINAIRE_GROUPS_KEY "groups"

enum { PROXY_NUMBERS = 16, NET_NUMBERS = 12, EMISSION_PREFIX = 24 };

// Of the tensors of a group: that of the first, or only, one is `name` alone.
static inline void emission_prefix(char prefix[EMISSION_PREFIX], int group, const char *name) {
    if (group)
        snprintf(prefix, EMISSION_PREFIX, "%d.%s", group, name);
    else
        snprintf(prefix, EMISSION_PREFIX, "%s", name);
}
