// sconce COMMAND ...: finds the command and hands over.
#include <stdio.h>
#include <string.h>

#include "cli.h"

static const struct command *const COMMANDS[] = {&command_bake,     &command_render,  &command_compare,
                                                 &command_evaluate, &command_info,    &command_report,
                                                 &command_table1,   &command_figures, &command_help};
enum { COMMAND_COUNT = sizeof COMMANDS / sizeof COMMANDS[0] };

static void usage(FILE *out) {
    fprintf(out, "sconce %s: bakes lamps into compact neural light fields and renders rooms with them\n\n",
            sconce_version());
    for (int i = 0; i < COMMAND_COUNT; i++)
        fprintf(out, "  sconce %-8s %-32s %s\n", COMMANDS[i]->name, COMMANDS[i]->arguments, COMMANDS[i]->summary);
    fprintf(out,
            "\nsconce COMMAND --help lists a command's options; sconce help shape sphere explains a scene's parts.\n");
}

int main(int argc, char **argv) {
    argp_err_exit_status = EXIT_USAGE;
    if (argc < 2 || !strcmp(argv[1], "--help") || !strcmp(argv[1], "-h"))
        return usage(argc < 2 ? stderr : stdout), argc < 2 ? EXIT_USAGE : EXIT_FINE;
    if (!strcmp(argv[1], "--version")) return printf("sconce %s\n", sconce_version()), EXIT_FINE;
    for (int i = 0; i < COMMAND_COUNT; i++) {
        if (strcmp(argv[1], COMMANDS[i]->name)) continue;
        char name[32];
        snprintf(name, sizeof name, "sconce %s", COMMANDS[i]->name);
        argv[1] = name;
        int code = COMMANDS[i]->run(argc - 1, argv + 1);
        if (fflush(stdout)) return perror("sconce: standard output"), EXIT_FAILED;
        return code;
    }
    fprintf(stderr, "sconce: there is no command '%s'\n\n", argv[1]);
    usage(stderr);
    return EXIT_USAGE;
}
