// Memory for large tables.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <cmocka.h>

#include "base/pages.h"

static void test_zeroed(void **unused) {
    (void)unused;
    const size_t counts[] = {0, 1, 1 << 18, (1 << 20) + 3};
    for (size_t k = 0; k < sizeof counts / sizeof *counts; k++) {
        uint64_t *table = pages_alloc(counts[k], sizeof *table);
        assert_non_null(table);
        for (size_t i = 0; i < counts[k]; i++) {
            assert_int_equal(table[i], 0);
            table[i] = UINT64_MAX; // what is freed is not zero
        }
        free(table);
    }
}

static void test_overflow(void **unused) {
    (void)unused;
    assert_null(pages_alloc(SIZE_MAX / 8, 16));
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_zeroed), cmocka_unit_test(test_overflow)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
