// sconce bake: a lamp's geometry to a compact luminaire file.
#include <stdio.h>
#include <string.h>

#include "cli.h"

struct bake_input {
    struct common common;
    struct sconce_bake_options options;
};

enum { KEY_PROXY = 2000, KEY_RESUME, KEY_SIZE, KEY_PRESET, KEY_VIEW, KEY_GROUPS };

static const struct argp_option OPTIONS[] = {
    {"output", 'o', "FILE", 0, "the luminaire; default LAMP.safetensors", 1},
    {"quality", 'Q', "NAME", 0,
     "draft (some 20 s on two cores), standard (the default, under 3 minutes) or high (half an hour)", 1},
    {"seconds", 's', "S", 0, "as much as fits in this time instead", 1},
    {"size", KEY_SIZE, "NAME", 0, "of the file: small (0.6 MB), default (2 MB) or large (8 MB)", 1},
    {"preset", KEY_PRESET, "NAME", 0,
     "compact (the default) or paper: the published networks, 17 MB, for comparison; they want days", 1},
    {"proxy", KEY_PROXY, "SHAPE", 0, "sphere, box, cylinder or a closed mesh's file (default: the tightest)", 1},
    {"view", KEY_VIEW, "NAME", 0,
     "hull (the default): the file also shows the lamp's surface, for appearance=surface; none: it does not", 1},
    {"groups", KEY_GROUPS, "NAME", 0,
     "none (the default); named or each: emitters are baked by groups, to be dimmed and tinted in the scene: by the "
     "name before the first '.' of their ids, or each alone",
     1},
    {"resume", KEY_RESUME, 0, 0, "go on from where an interrupted bake stopped", 1},
    {0}};

static error_t parse(int key, char *argument, struct argp_state *state) {
    struct bake_input *input = state->input;
    struct sconce_bake_options *o = &input->options;
    switch (key) {
    case ARGP_KEY_INIT:
        state->child_inputs[0] = &input->common;
        return 0;
    case 'o':
        o->output = argument;
        return 0;
    case 'Q':
        o->quality = option_choice(state, argument, "--quality", (const char *[]){"draft", "standard", "high", NULL});
        return 0;
    case 's':
        o->seconds = option_number(state, argument, "--seconds", 1, 1e8);
        return 0;
    case KEY_SIZE:
        o->size = option_choice(state, argument, "--size", (const char *[]){"small", "default", "large", NULL});
        return 0;
    case KEY_PRESET:
        o->preset = option_choice(state, argument, "--preset", (const char *[]){"compact", "paper", NULL});
        return 0;
    case KEY_PROXY:
        o->proxy = argument;
        return 0;
    case KEY_VIEW:
        o->view = option_choice(state, argument, "--view", (const char *[]){"hull", "none", NULL});
        return 0;
    case KEY_GROUPS:
        o->groups = option_choice(state, argument, "--groups", (const char *[]){"none", "named", "each", NULL});
        return 0;
    case KEY_RESUME:
        o->resume = true;
        return 0;
    case ARGP_KEY_ARG:
        o->lamp = option_last_positional(state, argument, (char *)(uintptr_t)o->lamp, "lamp");
        return 0;
    case ARGP_KEY_NO_ARGS:
        argp_error(state, "which lamp? Give a Mitsuba XML file");
        return 0;
    case ARGP_KEY_END:
        if (o->quality && o->seconds > 0) argp_error(state, "--quality and --seconds exclude each other");
        if (o->preset && !strcmp(o->preset, "paper") && (o->resume || o->size || o->view || o->groups))
            argp_error(state, "--preset paper has one form and no checkpoints: no --size, --view, --groups, --resume");
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

static int run(int argc, char **argv) {
    static const struct argp argp = {OPTIONS,         parse, "LAMP.xml", "Bakes a lamp into one small file.",
                                     common_children, 0,     0};
    struct bake_input input = {0};
    char output[4096];
    common_init(&input.common);
    if (argp_parse(&argp, argc, argv, 0, 0, &input)) return EXIT_USAGE;
    struct sconce_bake_options *o = &input.options;
    if (!o->output) o->output = option_default_output(output, sizeof output, o->lamp, ".safetensors");
    o->definitions = input.common.definitions;
    o->definition_count = input.common.definition_count;
    o->skip_missing = input.common.skip_missing;
    struct sconce_figures figures;
    struct sconce_error error;
    if (sconce_bake(o, &input.common.run, &figures, &error)) return common_fail(&input.common, &error);
    bool json = input.common.json;
    common_fini(&input.common);
    if (!json) printf("%s:\n", o->output);
    figures_print(&figures, json);
    return EXIT_FINE;
}

const struct command command_bake = {"bake", "LAMP.xml -o LAMP.safetensors", "bakes a lamp into one small file", run};
