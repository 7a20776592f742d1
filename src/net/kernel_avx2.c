#define KERNEL kernel_avx2
#define KERNEL_NAME "avx2"
#define VECTOR_LANES 8
#include "net/kernel_body.h"
