// sconce render: a scene to a picture.
#include <stdio.h>

#include "cli.h"

struct render_input {
    struct common common;
    struct sconce_render_options options;
};

enum { KEY_SPP = 2000, KEY_SIZE, KEY_MAX_DEPTH, KEY_EXPOSURE, KEY_MASK, KEY_PNG, KEY_EXACT, KEY_UNBIASED };

static const struct argp_option OPTIONS[] = {
    {"output", 'o', "FILE", 0, "the picture: .exr (with each pixel's variance) or .png; default SCENE.exr", 1},
    {"integrator", 'i', "NAME", 0, "path, bdpt or particle (default: the scene's)", 1},
    {"spp", KEY_SPP, "N", 0, "samples per pixel (default: the scene's)", 1},
    {"seconds", 's', "S", 0, "as many samples as fit in this time instead", 1},
    {"size", KEY_SIZE, "WxH", 0, "pixels (default: the scene's)", 1},
    {"max-depth", KEY_MAX_DEPTH, "N", 0, "longest path in edges, -1: no limit (default: the scene's)", 1},
    {"exact", KEY_EXACT, 0, 0, "path: every pixel by its own paths alone, each followed to its end", 1},
    {"unbiased", KEY_UNBIASED, 0, 0, "trace the geometry of baked lamps too, so that their errors cancel in the mean",
     1},
    {"exposure", KEY_EXPOSURE, "X", 0, "factor before conversion to .png (default: automatic)", 1},
    {"png", KEY_PNG, "FILE", 0, "also write a .png", 1},
    {"mask", KEY_MASK, "FILE", 0, "also write a mask: 1 where the camera sees no baked lamp", 1},
    {0}};

static error_t parse(int key, char *argument, struct argp_state *state) {
    struct render_input *input = state->input;
    struct sconce_render_options *o = &input->options;
    char rest;
    switch (key) {
    case ARGP_KEY_INIT:
        state->child_inputs[0] = &input->common;
        return 0;
    case 'o':
        o->output = argument;
        return 0;
    case 'i':
        o->integrator =
            option_choice(state, argument, "--integrator", (const char *[]){"path", "bdpt", "particle", NULL});
        return 0;
    case KEY_SPP:
        o->samples = (int)option_number(state, argument, "--spp", 1, 1e9);
        return 0;
    case 's':
        o->seconds = option_number(state, argument, "--seconds", 0.01, 1e8);
        return 0;
    case KEY_SIZE:
        if (sscanf(argument, "%dx%d%c", &o->width, &o->height, &rest) != 2 || o->width < 1 || o->height < 1 ||
            o->width > 65536 || o->height > 65536)
            argp_error(state, "--size takes WIDTHxHEIGHT such as 640x480, not '%s'", argument);
        return 0;
    case KEY_MAX_DEPTH:
        o->max_depth = (int)option_number(state, argument, "--max-depth", -1, 1e6);
        return 0;
    case KEY_EXACT:
        o->exact = true;
        return 0;
    case KEY_UNBIASED:
        o->unbiased = true;
        return 0;
    case KEY_EXPOSURE:
        o->exposure = (float)option_number(state, argument, "--exposure", 1e-20, 1e20);
        return 0;
    case KEY_MASK:
        o->mask = argument;
        return 0;
    case KEY_PNG:
        o->png = argument;
        return 0;
    case ARGP_KEY_ARG:
        o->scene = option_last_positional(state, argument, (char *)(uintptr_t)o->scene, "scene");
        return 0;
    case ARGP_KEY_NO_ARGS:
        argp_error(state, "which scene? Give a Mitsuba XML file");
        return 0;
    case ARGP_KEY_END:
        if (o->samples && o->seconds > 0) argp_error(state, "--spp and --seconds exclude each other");
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

static int run(int argc, char **argv) {
    static const struct argp argp = {OPTIONS, parse, "SCENE.xml", "Renders a scene.", common_children, 0, 0};
    struct render_input input = {0};
    char output[4096];
    common_init(&input.common);
    if (argp_parse(&argp, argc, argv, 0, 0, &input)) return EXIT_USAGE;
    if (!input.options.output)
        input.options.output = option_default_output(output, sizeof output, input.options.scene, ".exr");
    input.options.definitions = input.common.definitions;
    input.options.definition_count = input.common.definition_count;
    input.options.skip_missing = input.common.skip_missing;
    struct sconce_render_result r;
    struct sconce_error error;
    if (sconce_render(&input.options, &input.common.run, &r, &error)) return common_fail(&input.common, &error);
    bool json = input.common.json;
    common_fini(&input.common);
    if (json)
        json_print(json_pack("{s:s, s:i, s:i, s:s, s:i, s:f, s:f, s:f, s:f, s:[fff]}", "output", input.options.output,
                             "width", r.width, "height", r.height, "integrator", r.integrator, "samples", r.samples,
                             "wall_s", r.wall_s, "cpu_s", r.cpu_s, "load_s", r.load_s, "mpaths_per_cpu_s",
                             r.width * 1e-6 * r.height * r.samples / r.cpu_s, "mean", (double)r.mean[0],
                             (double)r.mean[1], (double)r.mean[2]));
    else
        printf("%s: %dx%d, %s, %d spp, %.1f s (%.1f CPU s)\n", input.options.output, r.width, r.height, r.integrator,
               r.samples, r.wall_s, r.cpu_s);
    return EXIT_FINE;
}

const struct command command_render = {"render", "SCENE.xml -o OUT.exr", "renders a scene", run};
