#define _DEFAULT_SOURCE // madvise
#include "base/pages.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

enum { LARGE_PAGE = 2 << 20 };

void *pages_alloc(size_t count, size_t size) {
    if (size && count > (SIZE_MAX / 2) / size) return NULL;
    const size_t bytes = (count * size / LARGE_PAGE + 1) * LARGE_PAGE;
    void *memory = aligned_alloc(LARGE_PAGE, bytes);
    if (!memory) return NULL;
#ifdef MADV_HUGEPAGE
    (void)madvise(memory, bytes, MADV_HUGEPAGE); // a wish
#endif
    memset(memory, 0, count * size);
    return memory;
}
