// The report, from EXR files and the JSON that the verbs printed to one HTML page with the pictures inside it.
#include "report/report.h"

#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "base/file.h"
#include "report/compare.h"

static const char PAGE_HEAD[] =
    "<!doctype html><html lang=\"en\"><head><meta charset=\"utf-8\">"
    "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"><title>%s</title><style>"
    "body{font:16px/1.5 system-ui,sans-serif;margin:2rem auto;max-width:1500px;padding:0 "
    "1rem;color:#222;background:#fafafa}"
    "h1{font-size:1.6rem}h2{font-size:1.2rem;margin-top:2rem}"
    ".row{display:grid;grid-template-columns:repeat(auto-fit,minmax(280px,1fr));gap:1rem}"
    "figure{margin:0}img{width:100%%;display:block;border-radius:4px;background:#000}"
    "figcaption{font-size:.9rem;margin-top:.3rem}"
    "table{border-collapse:collapse;font-variant-numeric:tabular-nums}"
    "td,th{padding:.3rem .9rem;border-bottom:1px solid "
    "#ddd;text-align:right}td:first-child,th:first-child{text-align:left}"
    "small{color:#666}</style></head><body><h1>%s</h1>\n";

static void html_text(FILE *page, const char *text) {
    for (; *text; text++) {
        if (*text == '<')
            fputs("&lt;", page);
        else if (*text == '>')
            fputs("&gt;", page);
        else if (*text == '&')
            fputs("&amp;", page);
        else if (*text == '"')
            fputs("&quot;", page);
        else
            fputc(*text, page);
    }
}

static void html_base64(FILE *page, const unsigned char *bytes, size_t length) {
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (size_t i = 0; i < length; i += 3) {
        unsigned triple = (unsigned)bytes[i] << 16 | (unsigned)(i + 1 < length ? bytes[i + 1] : 0) << 8 |
                          (unsigned)(i + 2 < length ? bytes[i + 2] : 0);
        fputc(digits[triple >> 18 & 63], page);
        fputc(digits[triple >> 12 & 63], page);
        fputc(i + 1 < length ? digits[triple >> 6 & 63] : '=', page);
        fputc(i + 2 < length ? digits[triple & 63] : '=', page);
    }
}

static enum status html_picture(FILE *page, const struct image *image, float exposure, const char *name,
                                const char *note, struct error *error) {
    unsigned char *png;
    size_t length;
    enum status status = image_encode_png(image, exposure, &png, &length, error);
    if (status) return status;
    fputs("<figure><img alt=\"", page);
    html_text(page, name);
    fputs("\" src=\"data:image/png;base64,", page);
    html_base64(page, png, length);
    fputs("\"><figcaption><b>", page);
    html_text(page, name);
    fputs("</b> ", page);
    html_text(page, note);
    fputs("</figcaption></figure>\n", page);
    free(png);
    return STATUS_OK;
}

// |a - r| in RGB, for a picture.
static enum status difference_image(struct image *difference, const struct image *a, const struct image *r,
                                    struct error *error) {
    enum status status = image_init(difference, r->width, r->height, 3, error);
    size_t pixels = (size_t)r->width * (size_t)r->height;
    for (size_t i = 0; !status && i < pixels; i++)
        for (size_t c = 0; c < 3; c++)
            difference->pixels[3 * i + c] =
                fabsf(a->pixels[i * (size_t)a->channels + c] - r->pixels[i * (size_t)r->channels + c]);
    return status;
}

static json_t *json_open(const char *path) {
    return path ? json_load_file(path, 0, NULL) : NULL; // figures that are not there are left out of the page
}

static double json_figure(const json_t *json, const char *key) {
    const json_t *value = json_object_get(json, key);
    return json_is_number(value) ? json_number_value(value) : NAN;
}

static void html_cell(FILE *page, const char *format, double value) {
    if (isnan(value))
        fputs("<td>-</td>", page);
    else {
        fputs("<td>", page);
        fprintf(page, format, value);
        fputs("</td>", page);
    }
}

static void html_entry_row(FILE *page, const struct report_entry *entry, const struct comparison *comparison) {
    json_t *json = json_open(entry->json_path);
    fputs("<tr><td>", page);
    html_text(page, entry->name);
    fputs("</td>", page);
    html_cell(page, "%.1f", json_figure(json, "cpu_s"));
    html_cell(page, "%.0f", json_figure(json, "samples"));
    html_cell(page, "%.5f", comparison ? comparison->metrics.rel_mse : (double)NAN);
    html_cell(page, "%.5f", comparison ? comparison->rel_mse_corrected : (double)NAN);
    html_cell(page, "%.3f", comparison ? comparison->metrics.flip : (double)NAN);
    html_cell(page, "%.2f %%", comparison ? 100 * comparison->metrics.block_error_max : (double)NAN);
    fputs("</tr>\n", page);
    json_decref(json);
}

static void html_bake(FILE *page, const char *path) {
    json_t *json = json_open(path);
    if (!json) return;
    fputs("<h2>The baked lamp</h2><table>", page);
    const char *key;
    json_t *value;
    json_object_foreach(json, key, value) {
        char *text = json_dumps(value, JSON_ENCODE_ANY | JSON_REAL_PRECISION(4) | JSON_COMPACT);
        if (!text) continue;
        fputs("<tr><td>", page);
        html_text(page, key);
        fputs("</td><td>", page);
        html_text(page, text);
        fputs("</td></tr>", page);
        free(text);
    }
    fputs("</table>\n", page);
    json_decref(json);
}

struct report_page {
    FILE *file;
    struct image reference, mask;
    bool has_mask;
    float exposure;
};

static enum status report_entries(struct report_page *page, const struct report_options *options, struct error *error) {
    enum status status =
        html_picture(page->file, &page->reference, page->exposure, options->reference.name, "reference", error);
    struct comparison *comparisons = calloc(options->entry_count + 1, sizeof *comparisons);
    if (!comparisons) return error_set(error, STATUS_MEMORY, "out of memory for the report");
    char *differences = NULL;
    size_t differences_length = 0;
    FILE *second = open_memstream(&differences, &differences_length);
    if (!second) status = error_set(error, STATUS_MEMORY, "out of memory for the report");
    for (size_t i = 0; !status && i < options->entry_count; i++) {
        struct image image = {0}, difference = {0};
        char note[80];
        status = image_load(&image, options->entries[i].image_path, false, error);
        if (!status)
            status =
                compare_images(&image, &page->reference, page->has_mask ? &page->mask : NULL, &comparisons[i], error);
        if (!status) status = difference_image(&difference, &image, &page->reference, error);
        if (!status) {
            snprintf(note, sizeof note, "relMSE %.5f, FLIP %.3f", comparisons[i].metrics.rel_mse,
                     comparisons[i].metrics.flip);
            status = html_picture(page->file, &image, page->exposure, options->entries[i].name, note, error);
        }
        if (!status)
            status = html_picture(second, &difference, page->exposure, options->entries[i].name, "absolute difference",
                                  error);
        image_fini(&image);
        image_fini(&difference);
    }
    if (second) fclose(second);
    if (!status) {
        fputs("</div><h2>Differences from the reference</h2><div class=\"row\">\n", page->file);
        fwrite(differences, 1, differences_length, page->file);
        fputs("</div><h2>Figures</h2><table><tr><th></th><th>CPU seconds</th><th>samples per pixel</th><th>relMSE</th>"
              "<th>relMSE less the reference's noise</th><th>FLIP</th><th>worst of 16 blocks</th></tr>\n",
              page->file);
        for (size_t i = 0; i < options->entry_count; i++)
            html_entry_row(page->file, &options->entries[i], &comparisons[i]);
        html_entry_row(page->file, &options->reference, NULL);
        fprintf(page->file,
                "</table><p><small>relMSE: mean of (a - r)&sup2; / (r&sup2; + 0.001)%s. FLIP: Andersson et al. "
                "2020.</small></p>\n",
                page->has_mask ? ", over the pixels that do not look at the lamp" : "");
    }
    free(differences);
    free(comparisons);
    return status;
}

enum status report_write(const struct report_options *options, struct error *error) {
    struct report_page page = {.has_mask = options->mask_path != NULL};
    char *bytes = NULL;
    size_t length = 0;
    enum status status = image_load(&page.reference, options->reference.image_path, false, error);
    if (!status && page.has_mask) status = image_load(&page.mask, options->mask_path, true, error);
    if (!status && !(page.file = open_memstream(&bytes, &length)))
        status = error_set(error, STATUS_MEMORY, "out of memory for the report");
    if (!status) {
        page.exposure = image_auto_exposure(&page.reference);
        fprintf(page.file, PAGE_HEAD, options->title, options->title);
        fputs("<div class=\"row\">\n", page.file);
        status = report_entries(&page, options, error);
        html_bake(page.file, options->bake_json_path);
        fputs("</body></html>\n", page.file);
        fclose(page.file);
    }
    if (!status) status = file_write_atomic(options->output, bytes, length, error);
    free(bytes);
    image_fini(&page.reference);
    image_fini(&page.mask);
    return status;
}
