// sconce help: the parts of a scene, from the tables that parse them.
#include <stdio.h>
#include <stdlib.h>

#include "cli.h"

static int run(int argc, char **argv) {
    char *text;
    struct sconce_error error;
    if (argc > 3 || (argc > 1 && argv[1][0] == '-'))
        return fprintf(stderr, "usage: sconce help [KIND [TYPE]], such as: sconce help bsdf roughdielectric\n"),
               EXIT_USAGE;
    if (sconce_help(argc > 1 ? argv[1] : NULL, argc > 2 ? argv[2] : NULL, &text, &error))
        return fprintf(stderr, "sconce: %s\n", error.text), EXIT_FAILED;
    fputs(text, stdout);
    free(text);
    return EXIT_FINE;
}

const struct command command_help = {"help", "[bsdf diffuse | shape ...]", "explains the parts of a scene file", run};
