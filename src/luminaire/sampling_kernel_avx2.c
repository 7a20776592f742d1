#define SAMPLING_KERNEL sampling_kernel_avx2
#include "luminaire/sampling_kernel_body.h"
