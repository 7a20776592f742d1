// sconce evaluate: a luminaire file against the lamp it was baked from.
#include <stdio.h>

#include "cli.h"

struct evaluate_input {
    struct common common;
    struct sconce_evaluate_options options;
};

static const struct argp_option OPTIONS[] = {{"quality", 'Q', "NAME", 0,
                                              "of the measurement: draft (some 20 s on two cores), standard (the "
                                              "default, some minutes) or high (its direct views from 512 "
                                              "lines a pixel)",
                                              1},
                                             {0}};

static error_t parse(int key, char *argument, struct argp_state *state) {
    struct evaluate_input *input = state->input;
    struct sconce_evaluate_options *o = &input->options;
    switch (key) {
    case ARGP_KEY_INIT:
        state->child_inputs[0] = &input->common;
        return 0;
    case 'Q':
        o->quality = option_choice(state, argument, "--quality", (const char *[]){"draft", "standard", "high", NULL});
        return 0;
    case ARGP_KEY_ARG:
        if (!o->luminaire)
            o->luminaire = argument;
        else
            o->lamp = option_last_positional(state, argument, (char *)(uintptr_t)o->lamp, "lamp");
        return 0;
    case ARGP_KEY_END:
        if (!o->lamp) argp_error(state, "two files are needed: the luminaire and its lamp");
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

static int run(int argc, char **argv) {
    static const struct argp argp = {
        OPTIONS, parse, "LAMP.safetensors LAMP.xml", "Measures a luminaire on held-out light.", common_children, 0, 0};
    struct evaluate_input input = {0};
    common_init(&input.common);
    if (argp_parse(&argp, argc, argv, 0, 0, &input)) return EXIT_USAGE;
    input.options.definitions = input.common.definitions;
    input.options.definition_count = input.common.definition_count;
    input.options.skip_missing = input.common.skip_missing;
    struct sconce_figures figures;
    struct sconce_error error;
    if (sconce_evaluate(&input.options, &input.common.run, &figures, &error)) return common_fail(&input.common, &error);
    bool json = input.common.json;
    common_fini(&input.common);
    figures_print(&figures, json);
    return EXIT_FINE;
}

const struct command command_evaluate = {"evaluate", "LAMP.safetensors LAMP.xml",
                                         "measures a luminaire on held-out light", run};
