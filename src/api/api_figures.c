// sconce_make_figures.
#include "api/api_run.h"
#include "evidence/figures.h"

enum sconce_status sconce_make_figures(const struct sconce_figure_options *options, const struct sconce_run *run,
                                       char **json, struct sconce_error *error) {
    struct api_run api;
    struct error inner = {0};
    api_run_init(&api, run);
    const struct figures_options figures = {.folder = options->output,
                                            .scale = options->scale > 0 ? options->scale : 1,
                                            .only = options->only,
                                            .paper = options->paper,
                                            .data = options->data};
    return api_status(figures_make(&figures, &api.run, json, &inner), &inner, error);
}
