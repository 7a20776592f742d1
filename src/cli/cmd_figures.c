// sconce figures: the paper's figures, made with this program.
#include <stdio.h>
#include <stdlib.h>

#include "cli.h"

struct figures_input {
    struct common common;
    struct sconce_figure_options options;
};

enum { KEY_SCALE = 2000, KEY_ONLY, KEY_PAPER, KEY_DATA };

static const struct argp_option OPTIONS[] = {
    {"output", 'o', "FOLDER", 0, "where pictures, numbers and the page go (default out/figures)", 1},
    {"scale", KEY_SCALE, "S", 0, "of the time and the pixels: 1 (the default) takes some 40 minutes on two cores", 1},
    {"only", KEY_ONLY, "NAMES", 0, "such as 4,13 or ablations (default: all but the ablations)", 1},
    {"paper", KEY_PAPER, "FILE", 0, "the demonstration lamp baked with --preset paper, for figure 6", 1},
    {"data", KEY_DATA, "FOLDER", 0, "with scenes/ and lamps/ in it, instead of the program's own", 1},
    {0}};

static error_t parse(int key, char *argument, struct argp_state *state) {
    struct figures_input *input = state->input;
    struct sconce_figure_options *o = &input->options;
    switch (key) {
    case ARGP_KEY_INIT:
        state->child_inputs[0] = &input->common;
        return 0;
    case 'o':
        o->output = argument;
        return 0;
    case KEY_SCALE:
        o->scale = option_number(state, argument, "--scale", 0.001, 100);
        return 0;
    case KEY_ONLY:
        o->only = argument;
        return 0;
    case KEY_PAPER:
        o->paper = argument;
        return 0;
    case KEY_DATA:
        o->data = argument;
        return 0;
    case ARGP_KEY_ARG:
        argp_error(state, "'%s' is too many: figures takes options only", argument);
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

static int run(int argc, char **argv) {
    static const struct argp argp = {
        OPTIONS, parse, "", "Makes the paper's figures with this program's lamps and rooms.", common_children, 0, 0};
    struct figures_input input = {.options = {.output = "out/figures"}};
    common_init(&input.common);
    if (argp_parse(&argp, argc, argv, 0, 0, &input)) return EXIT_USAGE;
    char *json;
    struct sconce_error error;
    if (sconce_make_figures(&input.options, &input.common.run, &json, &error))
        return common_fail(&input.common, &error);
    bool print_json = input.common.json;
    common_fini(&input.common);
    if (print_json)
        puts(json);
    else
        printf("%s/figures.html\n", input.options.output);
    free(json);
    return EXIT_FINE;
}

const struct command command_figures = {"figures", "-o FOLDER --scale S", "makes the paper's figures anew", run};
