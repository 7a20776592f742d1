// Between the public structs and the library's own.
#pragma once

#include "base/error.h"
#include "base/run.h"
#include <sconce/sconce.h>

struct api_run {
    struct run run;
    const struct sconce_run *outer;
};

// `outer` may be NULL; it must outlive the result. The struct must not move (its address is the callbacks' user).
void api_run_init(struct api_run *api, const struct sconce_run *outer);
enum sconce_status api_status(enum status status, const struct error *inner, struct sconce_error *error);
