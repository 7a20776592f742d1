// The public callbacks seen from inside.
#include "api/api_run.h"

#include <stdio.h>

#include "base/parallel.h"

_Static_assert((int)SCONCE_UNSUPPORTED == (int)STATUS_UNSUPPORTED && (int)SCONCE_CANCELLED == (int)STATUS_CANCELLED &&
                   (int)SCONCE_IO == (int)STATUS_IO,
               "the public status codes are the internal ones");

static void message(void *user, enum message_level level, const char *text) {
    const struct sconce_run *outer = ((struct api_run *)user)->outer;
    if (outer && outer->message) outer->message(outer->user, level == MESSAGE_WARNING, text);
}

static void progress(void *user, const struct progress *p) {
    const struct sconce_run *outer = ((struct api_run *)user)->outer;
    if (outer && outer->progress)
        outer->progress(outer->user,
                        &(struct sconce_progress){p->stage, p->fraction, p->elapsed_s, p->eta_s, p->detail});
}

static bool cancelled(void *user) {
    const struct sconce_run *outer = ((struct api_run *)user)->outer;
    return outer && outer->cancelled && outer->cancelled(outer->user);
}

void api_run_init(struct api_run *api, const struct sconce_run *outer) {
    api->outer = outer;
    api->run = (struct run){.threads = outer && outer->threads > 0 ? outer->threads : parallel_cores(),
                            .seed = outer ? outer->seed : 0,
                            .message = message,
                            .progress = progress,
                            .cancelled = cancelled,
                            .user = api};
}

enum sconce_status api_status(enum status status, const struct error *inner, struct sconce_error *error) {
    if (status && error) {
        error->status = (enum sconce_status)status;
        snprintf(error->text, sizeof error->text, "%s", inner->text);
    }
    return (enum sconce_status)status;
}
