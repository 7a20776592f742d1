// sconce report: pictures and figures of several renderings on one page.
#include <stdio.h>
#include <string.h>

#include "cli.h"

enum { MAX_ENTRIES = 16, KEY_BAKE = 2000, KEY_TITLE };

struct report_input {
    struct common common;
    struct sconce_report_options options;
    struct sconce_report_entry entries[MAX_ENTRIES];
};

static const struct argp_option OPTIONS[] = {
    {"output", 'o', "FILE", 0, "the page (default report.html)", 1},
    {"reference", 'r', "NAME=IMAGE[,JSON]", 0, "the reference; JSON: the file with what render --json printed", 1},
    {"mask", 'm', "FILE", 0, "compare only pixels where this image is > 0.5", 1},
    {"bake", KEY_BAKE, "FILE", 0, "what bake --json printed", 1},
    {"title", KEY_TITLE, "TEXT", 0, "the page's heading", 1},
    {0}};

static struct sconce_report_entry entry_parse(struct argp_state *state, char *text) {
    char *image = strchr(text, '=');
    if (!image) argp_error(state, "an entry is NAME=IMAGE.exr[,RENDER.json], not '%s'", text);
    *image++ = 0;
    char *json = strchr(image, ',');
    if (json) *json++ = 0;
    return (struct sconce_report_entry){text, image, json};
}

static error_t parse(int key, char *argument, struct argp_state *state) {
    struct report_input *input = state->input;
    struct sconce_report_options *o = &input->options;
    switch (key) {
    case ARGP_KEY_INIT:
        state->child_inputs[0] = &input->common;
        return 0;
    case 'o':
        o->output = argument;
        return 0;
    case 'r':
        o->reference = entry_parse(state, argument);
        return 0;
    case 'm':
        o->mask = argument;
        return 0;
    case KEY_BAKE:
        o->bake_json = argument;
        return 0;
    case KEY_TITLE:
        o->title = argument;
        return 0;
    case ARGP_KEY_ARG:
        if (o->entry_count == MAX_ENTRIES) argp_error(state, "at most %d pictures", MAX_ENTRIES);
        input->entries[o->entry_count++] = entry_parse(state, argument);
        return 0;
    case ARGP_KEY_END:
        if (!o->reference.image || !o->entry_count)
            argp_error(state, "a --reference and at least one NAME=IMAGE are needed");
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

static int run(int argc, char **argv) {
    static const struct argp argp = {
        OPTIONS, parse, "NAME=IMAGE[,JSON]...", "Puts pictures and their figures on one HTML page.", common_children,
        0,       0};
    struct report_input input = {.options = {.output = "report.html", .title = "sconce"}};
    input.options.entries = input.entries;
    common_init(&input.common);
    if (argp_parse(&argp, argc, argv, 0, 0, &input)) return EXIT_USAGE;
    struct sconce_error error;
    if (sconce_report(&input.options, &error)) return common_fail(&input.common, &error);
    common_fini(&input.common);
    puts(input.options.output);
    return EXIT_FINE;
}

const struct command command_report = {"report", "-r REF=IMG NAME=IMG ... -o R.html",
                                       "puts pictures and figures on one page", run};
