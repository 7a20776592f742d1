// The page writer: escapes, base64 (the vectors of RFC 4648, section 10), nothing from outside; and the pictures'
// arithmetic.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#include "base/file.h"
#include "report/page.h"
#include "report/picture.h"

static const char PATH[] = "test_page.html";

static char *page_text(struct page *page) {
    struct error error;
    uint8_t *bytes;
    size_t length;
    assert_int_equal(page_save(page, PATH, &error), STATUS_OK);
    assert_int_equal(file_read(PATH, &bytes, &length, &error), STATUS_OK);
    page_fini(page);
    remove(PATH);
    return (char *)bytes;
}

static void test_escapes(void **state) {
    (void)state;
    struct page page;
    assert_int_equal(page_init(&page, "a<b> & \"c\"", NULL), STATUS_OK);
    page_heading(&page, "<script>");
    page_picture_png(&page, "f", 1, "\"><x", "1 < 2");
    page_table_begin(&page, (const char *[]){"<h>", "b", NULL});
    page_table_row(&page, "r&d");
    page_cell_number(&page, "%.1f", 2.25);
    page_cell_number(&page, "%.1f", NAN);
    page_table_end(&page);
    char *text = page_text(&page);
    assert_non_null(strstr(text, "<title>a&lt;b&gt; &amp; &quot;c&quot;</title>"));
    assert_non_null(strstr(text, "<h2>&lt;script&gt;</h2>"));
    assert_non_null(strstr(text, "alt=\"&quot;&gt;&lt;x\""));
    assert_non_null(strstr(text, "1 &lt; 2</figcaption>"));
    assert_non_null(strstr(text, "<th>&lt;h&gt;</th><th>b</th>"));
    assert_non_null(strstr(text, "<td>r&amp;d</td><td>2.2</td><td>-</td>"));
    assert_non_null(strstr(text, "</body></html>"));
    assert_null(strstr(text, "http"));
    assert_null(strstr(text, "<script"));
    free(text);
}

static void test_base64(void **state) {
    (void)state;
    static const char *const vectors[][2] = {{"", ""},
                                             {"f", "Zg=="},
                                             {"fo", "Zm8="},
                                             {"foo", "Zm9v"},
                                             {"foob", "Zm9vYg=="},
                                             {"fooba", "Zm9vYmE="},
                                             {"foobar", "Zm9vYmFy"},
                                             {"\xfb\xef\xff", "++//"}};
    for (size_t i = 0; i < sizeof vectors / sizeof vectors[0]; i++) {
        struct page page;
        char expected[80];
        assert_int_equal(page_init(&page, "", NULL), STATUS_OK);
        page_picture_png(&page, vectors[i][0], strlen(vectors[i][0]), "", "");
        char *text = page_text(&page);
        snprintf(expected, sizeof expected, "src=\"data:image/png;base64,%s\"", vectors[i][1]);
        assert_non_null(strstr(text, expected));
        free(text);
    }
}

static void test_pictures(void **state) {
    (void)state;
    struct image a, r, difference, crop;
    assert_int_equal(image_init(&a, 3, 2, 3, NULL), STATUS_OK);
    assert_int_equal(image_init(&r, 3, 2, 4, NULL), STATUS_OK);
    for (int i = 0; i < 18; i++) a.pixels[i] = (float)i;
    for (int i = 0; i < 24; i++) r.pixels[i] = 10;
    assert_int_equal(image_difference(&difference, &a, &r, NULL), STATUS_OK);
    for (int i = 0; i < 18; i++) assert_true(difference.pixels[i] == (float)abs(i - 10));
    assert_int_equal(image_crop(&crop, &a, 1, 1, 2, 1, 2, NULL), STATUS_OK);
    assert_int_equal(crop.width, 4);
    assert_int_equal(crop.height, 2);
    for (int y = 0; y < 2; y++)
        for (int x = 0; x < 4; x++)
            for (int c = 0; c < 3; c++)
                assert_true(crop.pixels[3 * (4 * y + x) + c] == (float)(9 + 3 * (1 + x / 2) + c));
    image_fini(&a);
    image_fini(&r);
    image_fini(&difference);
    image_fini(&crop);
}

static void test_unwritable(void **state) {
    (void)state;
    struct page page;
    struct error error;
    assert_int_equal(page_init(&page, "x", &error), STATUS_OK);
    assert_int_equal(page_save(&page, "no_such_folder/page.html", &error), STATUS_IO);
    assert_non_null(strstr(error.text, "no_such_folder/page.html"));
    page_fini(&page);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_escapes), cmocka_unit_test(test_base64),
                                       cmocka_unit_test(test_pictures), cmocka_unit_test(test_unwritable)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
