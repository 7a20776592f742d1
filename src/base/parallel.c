#include "base/parallel.h"

#include <omp.h>
#include <sched.h>

void parallel_for(int threads, size_t count, void (*body)(void *user, size_t index, int worker), void *user) {
    if (threads <= 1 || count <= 1) {
        for (size_t i = 0; i < count; i++) body(user, i, 0);
        return;
    }
#pragma omp parallel for schedule(dynamic, 1) num_threads(threads)
    for (size_t i = 0; i < count; i++) body(user, i, omp_get_thread_num());
}

int parallel_cores(void) {
    cpu_set_t set;
    if (sched_getaffinity(0, sizeof set, &set) == 0) return CPU_COUNT(&set);
    return omp_get_num_procs();
}
