// The tensors of the published networks, for luminaire_file.c.
#pragma once

#include "format/safetensors.h"
#include "luminaire/paper.h"

void paper_describe(const struct paper *paper, struct tensor tensors[PAPER_NETS]); // which point into the networks
bool paper_present(const struct safetensors *file);
// Checks everything; only where they are present.
enum status paper_read(const struct safetensors *file, const char *name, const struct proxy *proxy,
                       struct paper **paper, struct error *error);
