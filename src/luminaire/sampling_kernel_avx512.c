#ifdef __AVX512F__
#define SAMPLING_KERNEL sampling_kernel_avx512
#include "luminaire/sampling_kernel_body.h"
#else
#include "luminaire/sampling_kernel.h"
const struct sampling_kernel sampling_kernel_avx512 = {0};
#endif
