#include "base/run.h"

#include <stdarg.h>
#include <stdio.h>
#include <time.h>

static void run_message(const struct run *run, enum message_level level, const char *format, va_list arguments) {
    if (!run || !run->message) return;
    char text[1200];
    vsnprintf(text, sizeof text, format, arguments);
    run->message(run->user, level, text);
}

void run_note(const struct run *run, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    run_message(run, MESSAGE_NOTE, format, arguments);
    va_end(arguments);
}

void run_warn(const struct run *run, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    run_message(run, MESSAGE_WARNING, format, arguments);
    va_end(arguments);
}

void run_progress(const struct run *run, const char *stage, double fraction, double elapsed_s, const char *detail) {
    if (!run || !run->progress) return;
    double eta_s = fraction > 1e-3 ? elapsed_s * (1 - fraction) / fraction : -1;
    run->progress(run->user, &(struct progress){stage, fraction, elapsed_s, eta_s, detail});
}

bool run_cancelled(const struct run *run) { return run && run->cancelled && run->cancelled(run->user); }

static double clock_s(clockid_t clock) {
    struct timespec now;
    clock_gettime(clock, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

double clock_wall_s(void) { return clock_s(CLOCK_MONOTONIC); }
double clock_cpu_s(void) { return clock_s(CLOCK_PROCESS_CPUTIME_ID); }
