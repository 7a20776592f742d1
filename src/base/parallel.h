// A parallel loop over independent work items. OpenMP is behind this file only.
#pragma once

#include <stddef.h>

// Calls body(user, index, worker) once for every index in [0, count), in any order, on up to `threads` threads;
// `worker` in [0, threads) names the calling thread, for per-worker scratch. Returns when all are done.
// Results must not depend on the order or on `worker`: then they are the same for any number of threads.
void parallel_for(int threads, size_t count, void (*body)(void *user, size_t index, int worker), void *user);
int parallel_cores(void); // processors this process may use
