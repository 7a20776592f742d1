// What the user sees while a command works: one line that redraws itself on a terminal, plain lines in a log.
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <time.h>
#include <unistd.h>

#include "cli.h"

enum { LOG_INTERVAL_S = 10, BAR_WIDTH = 24 };

struct terminal {
    bool quiet, interactive, bar_open;
    double last_s, last_fraction;
    char stage[64];
};

static double now_s(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

struct terminal *terminal_create(bool quiet) {
    struct terminal *terminal = calloc(1, sizeof *terminal);
    if (!terminal) abort();
    terminal->quiet = quiet;
    terminal->interactive = isatty(STDERR_FILENO);
    return terminal;
}

static void clock_text(char text[16], double seconds) {
    if (seconds < 0)
        strcpy(text, "--:--");
    else if (seconds < 36000)
        snprintf(text, 16, "%d:%02d", (int)seconds / 60, (int)seconds % 60);
    else
        snprintf(text, 16, "%dh", (int)(seconds / 3600));
}

static int columns(void) {
    struct winsize size;
    return ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 20 ? size.ws_col : 80;
}

static void bar_draw(const struct sconce_progress *progress) {
    char elapsed[16], eta[16], bar[BAR_WIDTH + 1], line[512];
    clock_text(elapsed, progress->elapsed_s);
    clock_text(eta, progress->eta_s);
    int filled = (int)(progress->fraction * BAR_WIDTH + 0.5);
    for (int i = 0; i < BAR_WIDTH; i++) bar[i] = i < filled ? '#' : '.';
    bar[BAR_WIDTH] = 0;
    snprintf(line, sizeof line, "%-10.20s [%s] %3.0f %%  %s, %s left  %s", progress->stage, bar,
             100 * progress->fraction, elapsed, eta, progress->detail ? progress->detail : "");
    fprintf(stderr, "\r\033[K%.*s", columns() - 1, line);
    fflush(stderr);
}

static void bar_close(struct terminal *terminal) {
    if (terminal->bar_open) fputc('\n', stderr);
    terminal->bar_open = false;
}

void terminal_progress(void *user, const struct sconce_progress *progress) {
    struct terminal *terminal = user;
    if (terminal->quiet) return;
    double now = now_s();
    bool new_stage = strncmp(terminal->stage, progress->stage, sizeof terminal->stage - 1) != 0;
    bool finished = progress->fraction >= 1;
    if (new_stage) {
        bar_close(terminal);
        snprintf(terminal->stage, sizeof terminal->stage, "%s", progress->stage);
        terminal->last_s = terminal->interactive ? 0 : now;
    }
    if (terminal->interactive) {
        if (!finished && now - terminal->last_s < 0.1) return;
        if (finished && !terminal->bar_open && !new_stage) return;
        bar_draw(progress);
        terminal->bar_open = true;
        if (finished) bar_close(terminal);
    } else if (!finished && now - terminal->last_s >= LOG_INTERVAL_S) {
        char eta[16];
        clock_text(eta, progress->eta_s);
        fprintf(stderr, "%s %.0f %%, %.0f s, %s left%s%s\n", progress->stage, 100 * progress->fraction,
                progress->elapsed_s, eta, progress->detail ? ", " : "", progress->detail ? progress->detail : "");
    } else
        return;
    terminal->last_s = now;
}

void terminal_message(struct terminal *terminal, bool warning, const char *text) {
    if (terminal->quiet && !warning) return;
    if (terminal->bar_open) fputs("\r\033[K", stderr);
    terminal->bar_open = false;
    fprintf(stderr, "%s%s\n", warning ? "warning: " : "note: ", text);
}

void terminal_destroy(struct terminal *terminal) {
    if (terminal) bar_close(terminal);
    free(terminal);
}
