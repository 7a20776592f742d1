// A generator is one file that defines `model`; lamps/writer gives it its main: make_NAME FOLDER writes all the model's
// files, the same on every run.
#pragma once

#include <stdio.h>

#include "mesh_writer.h"

struct model_file {
    const char *name;
    void (*text)(FILE *file); // one of the two
    void (*mesh)(struct mesh_writer *mesh);
};

struct model {
    const char *program;
    const struct model_file *files; // ends with a NULL name
};

extern const struct model model;
