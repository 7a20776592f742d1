#include "net/kernel.h"

const struct kernel *kernel_best(void) {
#if defined(__x86_64__)
    if (kernel_avx512.name && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
        __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512vl"))
        return &kernel_avx512;
#endif
    return &kernel_avx2;
}
