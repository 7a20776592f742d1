// The page, written into memory: the style sheet, the escapes and the pictures' base64 are here and nowhere else.
#include "report/page.h"

#include <math.h>
#include <stdlib.h>

#include "base/file.h"

static const char STYLE[] =
    ":root{color-scheme:light dark;--ink:#222;--paper:#fafafa;--soft:#666;--line:#ddd}"
    "@media(prefers-color-scheme:dark){:root{--ink:#ddd;--paper:#161616;--soft:#999;--line:#3a3a3a}}"
    "body{font:16px/1.5 system-ui,sans-serif;margin:2rem auto;max-width:1500px;padding:0 1rem;color:var(--ink);"
    "background:var(--paper)}"
    "h1{font-size:1.6rem}h2{font-size:1.2rem;margin-top:2.5rem}p{max-width:50rem}"
    ".row{display:flex;flex-wrap:wrap;gap:1rem;margin:1rem 0}"
    "figure{margin:0;flex:1 1 220px;max-width:450px}"
    "img{width:100%;display:block;border-radius:4px;background:#000;image-rendering:pixelated}"
    "figcaption{font-size:.9rem;margin-top:.3rem}"
    ".table{overflow-x:auto;margin:1rem 0}"
    "table{border-collapse:collapse;font-variant-numeric:tabular-nums}"
    "td,th{padding:.3rem .9rem;border-bottom:1px solid var(--line);text-align:right}"
    "td:first-child,th:first-child{text-align:left;padding-left:0}"
    "small{color:var(--soft)}";

static void put_text(FILE *file, const char *text) {
    for (; *text; text++) {
        switch (*text) {
        case '<':
            fputs("&lt;", file);
            break;
        case '>':
            fputs("&gt;", file);
            break;
        case '&':
            fputs("&amp;", file);
            break;
        case '"':
            fputs("&quot;", file);
            break;
        default:
            fputc(*text, file);
        }
    }
}

static void put_element(FILE *file, const char *before, const char *text, const char *after) {
    fputs(before, file);
    put_text(file, text);
    fputs(after, file);
}

static void put_base64(FILE *file, const unsigned char *bytes, size_t length) {
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (size_t i = 0; i < length; i += 3) {
        unsigned triple = (unsigned)bytes[i] << 16 | (unsigned)(i + 1 < length ? bytes[i + 1] : 0) << 8 |
                          (unsigned)(i + 2 < length ? bytes[i + 2] : 0);
        fputc(digits[triple >> 18 & 63], file);
        fputc(digits[triple >> 12 & 63], file);
        fputc(i + 1 < length ? digits[triple >> 6 & 63] : '=', file);
        fputc(i + 2 < length ? digits[triple & 63] : '=', file);
    }
}

enum status page_init(struct page *page, const char *title, struct error *error) {
    *page = (struct page){0};
    page->file = open_memstream(&page->bytes, &page->length);
    if (!page->file) return error_set(error, STATUS_MEMORY, "out of memory for the page \"%s\"", title);
    fputs("<!doctype html><html lang=\"en\"><head><meta charset=\"utf-8\">"
          "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">",
          page->file);
    put_element(page->file, "<title>", title, "</title><style>");
    fputs(STYLE, page->file);
    put_element(page->file, "</style></head><body><h1>", title, "</h1>\n");
    return STATUS_OK;
}

void page_fini(struct page *page) {
    if (page->file) fclose(page->file);
    free(page->bytes);
    *page = (struct page){0};
}

enum status page_save(struct page *page, const char *path, struct error *error) {
    fputs("</body></html>\n", page->file);
    int failed = ferror(page->file);
    failed |= fclose(page->file);
    page->file = NULL;
    if (failed) return error_set(error, STATUS_MEMORY, "%s: out of memory for the page", path);
    return file_write_atomic(path, page->bytes, page->length, error);
}

void page_heading(struct page *page, const char *text) { put_element(page->file, "<h2>", text, "</h2>\n"); }
void page_paragraph(struct page *page, const char *text) { put_element(page->file, "<p>", text, "</p>\n"); }
void page_small_print(struct page *page, const char *text) {
    put_element(page->file, "<p><small>", text, "</small></p>\n");
}

void page_row_begin(struct page *page) { fputs("<div class=\"row\">\n", page->file); }
void page_row_end(struct page *page) { fputs("</div>\n", page->file); }

void page_picture_png(struct page *page, const void *png, size_t length, const char *name, const char *note) {
    put_element(page->file, "<figure><img alt=\"", name, "\" src=\"data:image/png;base64,");
    put_base64(page->file, png, length);
    put_element(page->file, "\"><figcaption><b>", name, "</b> ");
    put_element(page->file, "", note, "</figcaption></figure>\n");
}

enum status page_picture(struct page *page, const struct image *image, float exposure, const char *name,
                         const char *note, struct error *error) {
    unsigned char *png;
    size_t length;
    enum status status = image_encode_png(image, exposure, &png, &length, error);
    if (status) return status;
    page_picture_png(page, png, length, name, note);
    free(png);
    return STATUS_OK;
}

void page_table_begin(struct page *page, const char *const *heads) {
    fputs("<div class=\"table\"><table><tr>", page->file);
    for (; *heads; heads++) put_element(page->file, "<th>", *heads, "</th>");
    fputs("</tr>\n", page->file);
}

void page_table_end(struct page *page) { fputs("</table></div>\n", page->file); }

void page_table_row(struct page *page, const char *name) { put_element(page->file, "<tr><td>", name, "</td>"); }
void page_cell(struct page *page, const char *text) { put_element(page->file, "<td>", text, "</td>"); }

void page_cell_number(struct page *page, const char *format, double value) {
    char text[64] = "-";
    if (!isnan(value)) snprintf(text, sizeof text, format, value);
    page_cell(page, text);
}
