#include "net/kernel.h"
#ifdef __AVX512F__
#define KERNEL kernel_avx512
#define KERNEL_NAME "avx512"
#define VECTOR_LANES 16
#include "net/kernel_body.h"
#else
const struct kernel kernel_avx512 = {.name = NULL};
#endif
