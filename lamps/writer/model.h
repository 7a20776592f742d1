// A generator is one file that defines `model`; lamps/writer gives it its main: make_NAME FOLDER writes all the model's
// files, the same on every run.
#pragma once

#include <stdio.h>

#include "mesh_writer.h"
#include "texture_writer.h"

struct model_file {
    const char *name;
    void (*text)(FILE *file); // one of the three
    void (*mesh)(struct mesh_writer *mesh);
    struct color (*texture)(double u, double v); // a PNG; u and v in [0, 1], its first row at v = 0
};

struct model {
    const char *program;
    const struct model_file *files; // ends with a NULL name
};

extern const struct model model;
