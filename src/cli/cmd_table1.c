// sconce table1: the paper's Table 1, measured anew.
#include <stdio.h>
#include <stdlib.h>

#include "cli.h"

enum { KEY_SCALE = 2000, KEY_REFERENCE, KEY_ONLY, KEY_DATA };

struct table1_input {
    struct common common;
    struct sconce_table1_options options;
};

static const struct argp_option OPTIONS[] = {
    {"output", 'o', "FOLDER", 0, "of the results; what is there is used again (default out/table1)", 1},
    {"scale", KEY_SCALE, "X", 0, "of the picture's sides and of all samples (default 1; 0.25 takes minutes)", 1},
    {"reference", KEY_REFERENCE, "X", 0, "samples of each reference, in terms of bdpt's (default 1)", 1},
    {"only", KEY_ONLY, "ROW[,ROW...]", 0, "statler, star, blossom, feather, vintage (default all)", 1},
    {"data", KEY_DATA, "FOLDER", 0, "with the project's scenes and lamps (default: where it was built or installed)",
     1},
    {0}};

static error_t parse(int key, char *argument, struct argp_state *state) {
    struct table1_input *input = state->input;
    switch (key) {
    case ARGP_KEY_INIT:
        state->child_inputs[0] = &input->common;
        return 0;
    case 'o':
        input->options.output = argument;
        return 0;
    case KEY_SCALE:
        input->options.scale = option_number(state, argument, "--scale", 0.01, 4);
        return 0;
    case KEY_REFERENCE:
        input->options.reference = option_number(state, argument, "--reference", 1, 64);
        return 0;
    case KEY_ONLY:
        input->options.only = argument;
        return 0;
    case KEY_DATA:
        input->options.data = argument;
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

static int run(int argc, char **argv) {
    static const struct argp argp = {
        OPTIONS,
        parse,
        "",
        "Measures the paper's Table 1 anew: bdpt of the lamps' geometry against the baked lamps.",
        common_children,
        0,
        0};
    struct table1_input input = {.options = {.output = "out/table1", .scale = 1, .reference = 1}};
    common_init(&input.common);
    if (argp_parse(&argp, argc, argv, 0, 0, &input)) return EXIT_USAGE;
    struct sconce_error error;
    char *json, *markdown;
    const enum sconce_status status = sconce_table1(&input.options, &input.common.run, &json, &markdown, &error);
    const bool as_json = input.common.json;
    if (!status) common_fini(&input.common);
    if (json) puts(as_json ? json : markdown);
    free(json);
    free(markdown);
    return status ? common_fail(&input.common, &error) : EXIT_FINE;
}

const struct command command_table1 = {"table1", "[--scale X] [-o FOLDER]", "measures the paper's Table 1 anew", run};
