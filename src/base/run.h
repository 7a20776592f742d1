// What a long job needs from its caller: threads, seed, where messages go, when to stop. The library itself never
// prints and never exits.
#pragma once

#include <stdbool.h>
#include <stdint.h>

enum message_level { MESSAGE_NOTE, MESSAGE_WARNING };

struct progress {
    const char *stage; // "tracing", "training", ...
    double fraction; // done, 0..1
    double elapsed_s; // since the stage began
    double eta_s; // estimated seconds left, < 0 when unknown
    const char *detail; // "loss 0.0123, held-out 0.0150", or NULL
};

struct run {
    int threads; // worker threads, >= 1
    uint64_t seed; // every random number is a pure function of it
    void (*message)(void *user, enum message_level level, const char *text); // may be NULL
    void (*progress)(void *user, const struct progress *progress); // may be NULL
    bool (*cancelled)(void *user); // may be NULL
    void *user;
};

// Formatted message to run->message; nothing when it is NULL.
void run_note(const struct run *run, const char *format, ...) __attribute__((format(printf, 2, 3)));
void run_warn(const struct run *run, const char *format, ...) __attribute__((format(printf, 2, 3)));
void run_progress(const struct run *run, const char *stage, double fraction, double elapsed_s, const char *detail);
bool run_cancelled(const struct run *run);

double clock_wall_s(void); // monotonic seconds
double clock_cpu_s(void); // CPU seconds of the process, all threads
