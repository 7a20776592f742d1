// sconce info: what a file holds.
#include <stdio.h>
#include <stdlib.h>

#include "cli.h"

struct info_input {
    struct common common;
    const char *path;
};

static error_t parse(int key, char *argument, struct argp_state *state) {
    struct info_input *input = state->input;
    switch (key) {
    case ARGP_KEY_INIT:
        state->child_inputs[0] = &input->common;
        return 0;
    case ARGP_KEY_ARG:
        input->path = option_last_positional(state, argument, (char *)(uintptr_t)input->path, "file");
        return 0;
    case ARGP_KEY_NO_ARGS:
        argp_error(state, "which file? A scene, a luminaire or an image");
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

static int run(int argc, char **argv) {
    static const struct argp argp = {0, parse, "FILE", "What a scene, a luminaire or an image holds.", common_children,
                                     0, 0};
    struct info_input input = {0};
    common_init(&input.common);
    if (argp_parse(&argp, argc, argv, 0, 0, &input)) return EXIT_USAGE;
    char *json;
    struct sconce_error error;
    if (sconce_info(input.path, input.common.definitions, input.common.definition_count, &input.common.run, &json,
                    &error))
        return common_fail(&input.common, &error);
    common_fini(&input.common);
    puts(json);
    free(json);
    return EXIT_FINE;
}

const struct command command_info = {"info", "FILE", "says what a scene, a luminaire or an image holds", run};
