// The options that every command has, and the wiring of messages, progress and Ctrl-C.
#include <errno.h>
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli.h"

enum { KEY_SEED = 1000, KEY_SKIP_MISSING };

static const struct argp_option OPTIONS[] = {
    {0, 'D', "NAME=VALUE", 0, "value of $NAME in the scene file", 9},
    {"threads", 't', "N", 0, "worker threads (default: all cores)", 9},
    {"seed", KEY_SEED, "N", 0, "seed of every random number (default 0)", 9},
    {"skip-missing", KEY_SKIP_MISSING, 0, 0, "a missing mesh is a warning, not an error", 9},
    {"json", 'j', 0, 0, "the result as JSON", 9},
    {"quiet", 'q', 0, 0, "no notes and no progress", 9},
    {0}};

static volatile sig_atomic_t interrupted; // a signal handler can reach nothing else

static void on_signal(int signal_number) {
    (void)signal_number;
    interrupted = 1;
    signal(signal_number, SIG_DFL); // the second Ctrl-C ends the program at once
}

static bool cancelled(void *user) {
    (void)user;
    return interrupted;
}

static void message(void *user, bool warning, const char *text) {
    terminal_message(((struct common *)user)->terminal, warning, text);
}
static void progress(void *user, const struct sconce_progress *p) {
    terminal_progress(((struct common *)user)->terminal, p);
}

void common_init(struct common *common) {
    *common = (struct common){0};
    common->run = (struct sconce_run){.message = message, .progress = progress, .cancelled = cancelled, .user = common};
    signal(SIGINT, on_signal);
    signal(SIGTERM, on_signal);
}

void common_fini(struct common *common) {
    terminal_destroy(common->terminal);
    common->terminal = NULL;
    free(common->definitions);
}

int common_fail(struct common *common, const struct sconce_error *error) {
    common_fini(common);
    fprintf(stderr, "sconce: %s\n", error->text);
    return EXIT_FAILED;
}

double option_number(struct argp_state *state, const char *text, const char *option, double min, double max) {
    char *end;
    errno = 0;
    double value = strtod(text, &end);
    if (end == text || *end || errno || !(value >= min && value <= max))
        argp_error(state, "%s takes a number from %g to %g, not '%s'", option, min, max, text);
    return value;
}

const char *option_choice(struct argp_state *state, const char *text, const char *option, const char *const *names) {
    char list[200] = "";
    for (int i = 0; names[i]; i++) {
        if (!strcmp(text, names[i])) return text;
        const char *before = i == 0 ? "" : names[i + 1] ? ", " : " or ";
        snprintf(list + strlen(list), sizeof list - strlen(list), "%s%s", before, names[i]);
    }
    argp_error(state, "%s takes %s, not '%s'", option, list, text);
    return text;
}

char *option_last_positional(struct argp_state *state, const char *text, char *previous, const char *what) {
    if (previous) argp_error(state, "one %s at a time: '%s' is too many", what, text);
    return (char *)(uintptr_t)text;
}

const char *option_default_output(char *buffer, size_t size, const char *input, const char *extension) {
    const char *dot = strrchr(input, '.');
    if (dot && strchr(dot, '/')) dot = NULL; // of a folder
    snprintf(buffer, size, "%.*s%s", (int)(dot ? dot - input : (long)strlen(input)), input, extension);
    return buffer;
}

static void define(struct common *common, struct argp_state *state, char *text) {
    char *equals = strchr(text, '=');
    if (!equals || equals == text) argp_error(state, "-D takes name=value, not '%s'", text);
    struct sconce_definition *grown = realloc(common->definitions, (common->definition_count + 1) * sizeof *grown);
    if (!grown) abort();
    *equals = 0;
    grown[common->definition_count++] = (struct sconce_definition){text, equals + 1};
    common->definitions = grown;
}

static error_t parse(int key, char *argument, struct argp_state *state) {
    struct common *common = state->input;
    switch (key) {
    case 'D':
        define(common, state, argument);
        return 0;
    case 't':
        common->run.threads = (int)option_number(state, argument, "--threads", 1, 1024);
        return 0;
    case KEY_SEED:
        common->run.seed = (uint64_t)option_number(state, argument, "--seed", 0, 9007199254740992.0);
        return 0;
    case KEY_SKIP_MISSING:
        common->skip_missing = true;
        return 0;
    case 'j':
        common->json = true;
        return 0;
    case 'q':
        common->quiet = true;
        return 0;
    case ARGP_KEY_SUCCESS:
        common->terminal = terminal_create(common->quiet);
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

static const struct argp COMMON = {OPTIONS, parse, 0, 0, 0, 0, 0};
const struct argp_child common_children[] = {{&COMMON, 0, "Common options:", 8}, {0}};
