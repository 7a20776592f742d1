// sconce_table1.
#include "api/api_run.h"
#include "evidence/table1.h"

enum sconce_status sconce_table1(const struct sconce_table1_options *options, const struct sconce_run *run, char **json,
                                 char **markdown, struct sconce_error *error) {
    struct api_run api;
    struct error inner = {0};
    api_run_init(&api, run);
    const struct table1_options table = {.folder = options->output,
                                         .data = options->data,
                                         .scale = options->scale > 0 ? options->scale : 1,
                                         .reference = options->reference > 0 ? options->reference : 1,
                                         .only = options->only};
    return api_status(table1_make(&table, &api.run, json, markdown, &inner), &inner, error);
}
