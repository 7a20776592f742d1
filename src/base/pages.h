// Memory for large tables that are read and written in no order.
#pragma once

#include <stddef.h>

// Zeroed, and there from the start, in large pages where the system has some: memory of calloc costs a copied page
// wherever it is read before it is written, which stops all threads, and a page of 4 KiB for every few entries. NULL
// when memory is out or the size overflows; to be freed with free.
void *pages_alloc(size_t count, size_t size);
