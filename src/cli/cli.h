// The program's commands: one file each, one line in command_table (main.c).
#pragma once

#include <argp.h>
#include <jansson.h>
#include <sconce/sconce.h>

enum exit_code { EXIT_FINE = 0, EXIT_FAILED = 1, EXIT_USAGE = 2 };

struct command {
    const char *name, *arguments, *summary;
    int (*run)(int argc, char **argv); // argv[0] is "sconce NAME"
};
extern const struct command command_bake, command_render, command_compare, command_evaluate, command_info,
    command_report, command_table1, command_figures, command_help;

// --- Options that every command understands (common.c). ---
struct common {
    struct sconce_run run; // messages to stderr, progress to the terminal, Ctrl-C as cancellation
    bool json, quiet, skip_missing;
    struct sconce_definition *definitions;
    size_t definition_count;
    struct terminal *terminal;
};

extern const struct argp_child common_children[]; // for argp; the child's input is a struct common *
void common_init(struct common *common); // call before argp_parse
void common_fini(struct common *common);
int common_fail(struct common *common, const struct sconce_error *error); // prints it; returns the exit code

double option_number(struct argp_state *state, const char *text, const char *option, double min,
                     double max); // or usage error
// `text` where it is one of the names (the last is NULL), or a usage error that lists them.
const char *option_choice(struct argp_state *state, const char *text, const char *option, const char *const *names);
// `input` with another extension, in buffer: where a command writes by default.
const char *option_default_output(char *buffer, size_t size, const char *input, const char *extension);
char *option_last_positional(struct argp_state *state, const char *text, char *previous, const char *what);

// --- Progress (terminal.c): a bar with elapsed time and ETA on a terminal, a plain line every ten seconds otherwise.
// ---
struct terminal *terminal_create(bool quiet);
void terminal_progress(void *terminal, const struct sconce_progress *progress);
void terminal_message(struct terminal *terminal, bool warning, const char *text);
void terminal_destroy(struct terminal *terminal); // ends an open bar

// --- Results (figures.c) ---
void json_print(json_t *json); // one line on stdout; takes the reference
void figures_print(const struct sconce_figures *figures, bool json);
