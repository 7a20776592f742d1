// The texts of attributes to values: numbers, colours, spectra. Everything is strict: a number must fill its text, be
// finite and fit into a float. Numbers in lists are separated by commas or white space.
#include "format/description_private.h"

#include <ctype.h>
#include <float.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "format/spectrum.h"

static bool is_separator(char c) { return c == ',' || isspace((unsigned char)c); }
static const char *skip_space(const char *text) {
    while (isspace((unsigned char)*text)) text++;
    return text;
}

// The number at *text, which moves behind it. False: there is none, or it is not finite as a float.
static bool scan_number(const char **text, double *number) {
    const char *start = *text;
    size_t length = strspn(start, "0123456789+-.eE"); // keeps strtod from "nan", "inf" and hexadecimals
    char *end;
    if (!length) return false;
    *number = strtod(start, &end);
    if (end != start + length || !(*number >= -FLT_MAX && *number <= FLT_MAX)) return false;
    *text = end;
    return true;
}

enum status parse_number(const char *text, struct place place, const char *what, double *number, struct error *error) {
    const char *end = skip_space(text);
    if (!scan_number(&end, number) || *skip_space(end))
        return error_at(error, place, "%s is '%s', which is not a finite number", what, text);
    return STATUS_OK;
}

enum status parse_integer(const char *text, struct place place, const char *what, double *number, struct error *error) {
    const char *start = skip_space(text);
    char *end;
    long long value = strtoll(start, &end, 10);
    if (end == start || *skip_space(end) || value < INT_MIN || value > INT_MAX)
        return error_at(error, place, "%s is '%s', which is not a whole number of 32 bits", what, text);
    *number = (double)value;
    return STATUS_OK;
}

enum status parse_boolean(const char *text, struct place place, const char *what, bool *value, struct error *error) {
    if (strcasecmp(text, "true") && strcasecmp(text, "false"))
        return error_at(error, place, "%s is '%s'; write true or false", what, text);
    *value = strcasecmp(text, "true") == 0;
    return STATUS_OK;
}

enum status parse_numbers(const char *text, struct place place, const char *what, double *numbers, size_t capacity,
                          size_t *count, struct error *error) {
    *count = 0;
    const char *at = text;
    for (;;) {
        while (is_separator(*at)) at++;
        if (!*at) break;
        double number;
        if (!scan_number(&at, &number) || (*at && !is_separator(*at)))
            return error_at(error, place, "%s is '%.80s', which is not a list of finite numbers", what, text);
        if (*count == capacity) return error_at(error, place, "%s has more than %zu numbers", what, capacity);
        numbers[(*count)++] = number;
    }
    return STATUS_OK;
}

static float linear_from_encoded(double v) { // the sRGB transfer function, IEC 61966-2-1
    return (float)(v <= 0.04045 ? v / 12.92 : pow((v + 0.055) / 1.055, 2.4));
}

enum status parse_color(const char *text, struct place place, bool is_srgb, rgb *color, struct error *error) {
    const char *start = skip_space(text);
    double c[3];
    size_t count = 0;
    if (*start == '#') {
        size_t digits = strspn(start + 1, "0123456789abcdefABCDEF");
        if (digits != 6 || *skip_space(start + 7))
            return error_at(error, place, "the colour '%s' is not of the form #rrggbb", text);
        unsigned long value = strtoul(start + 1, NULL, 16);
        for (int i = 0; i < 3; i++) c[i] = (double)(value >> (16 - 8 * i) & 255) / 255;
        is_srgb = true;
    } else {
        enum status status = parse_numbers(text, place, "the colour", c, 3, &count, error);
        if (status) return status;
        if (count == 1)
            c[1] = c[2] = c[0];
        else if (count != 3)
            return error_at(error, place, "the colour '%s' has %zu numbers; write three, or one for gray", text, count);
    }
    *color = is_srgb ? (rgb){linear_from_encoded(c[0]), linear_from_encoded(c[1]), linear_from_encoded(c[2])}
                     : (rgb){(float)c[0], (float)c[1], (float)c[2]};
    return STATUS_OK;
}

enum status spectrum_finish(struct property *property, float *wavelengths, float *values, size_t n,
                            struct error *error) {
    if (n < 2)
        return error_at(error, property->place, "a spectrum needs one number or at least two wavelength:value pairs");
    for (size_t i = 1; i < n; i++)
        if (!(wavelengths[i] > wavelengths[i - 1]))
            return error_at(error, property->place, "the wavelengths of a spectrum must ascend: %g nm follows %g nm",
                            (double)wavelengths[i], (double)wavelengths[i - 1]);
    property->wavelengths_nm = wavelengths;
    property->values = values;
    property->pair_count = n;
    property->color = spectrum_rgb(wavelengths, values, n, SPECTRUM_REFLECTANCE);
    return STATUS_OK;
}

enum status parse_spectrum(struct arena *arena, const char *text, struct property *property, struct error *error) {
    double listed[3];
    size_t listed_count;
    if (!strchr(text, ':') && !parse_numbers(text, property->place, "the spectrum", listed, 3, &listed_count, NULL) &&
        listed_count == 3) { // as Mitsuba 0.5 reads it when it is built for RGB
        property->type = PROPERTY_RGB;
        property->color = (rgb){(float)listed[0], (float)listed[1], (float)listed[2]};
        return STATUS_OK;
    }
    if (!strchr(text, ':')) {
        enum status status = parse_number(text, property->place, "the spectrum", &property->number, error);
        property->color = rgb_gray((float)property->number);
        return status;
    }
    size_t capacity = 0, n = 0;
    for (const char *c = text; *c; c++) capacity += *c == ':';
    float *wavelengths = arena_alloc(arena, capacity, sizeof *wavelengths);
    float *values = arena_alloc(arena, capacity, sizeof *values);
    if (!wavelengths || !values) return error_set(error, STATUS_MEMORY, "out of memory for a spectrum");
    for (const char *at = text;;) {
        while (is_separator(*at)) at++;
        if (!*at) break;
        double wavelength, value;
        bool good = scan_number(&at, &wavelength) && *(at = skip_space(at)) == ':';
        if (good) at = skip_space(at + 1);
        if (!good || !scan_number(&at, &value) || (*at && !is_separator(*at)))
            return error_at(error, property->place, "pair %zu of the spectrum is not 'wavelength:value'", n + 1);
        wavelengths[n] = (float)wavelength;
        values[n++] = (float)value;
    }
    return spectrum_finish(property, wavelengths, values, n, error);
}

enum status load_spd(struct arena *arena, const char *path, struct property *property, struct error *error) {
    uint8_t *bytes;
    size_t length, capacity = 1, n = 0;
    enum status status = file_read(path, &bytes, &length, error);
    if (status) return status;
    for (size_t i = 0; i < length; i++) capacity += bytes[i] == '\n';
    float *wavelengths = arena_alloc(arena, capacity, sizeof *wavelengths);
    float *values = arena_alloc(arena, capacity, sizeof *values);
    if (!wavelengths || !values) status = error_set(error, STATUS_MEMORY, "out of memory for a spectrum");
    char *line = (char *)bytes;
    for (int number = 1; line && !status; number++) {
        char *end = strchr(line, '\n'), *comment;
        if (end) *end = 0;
        if ((comment = strchr(line, '#'))) *comment = 0;
        double pair[2];
        size_t count;
        status = parse_numbers(line, (struct place){path, number, 1}, "this line", pair, 2, &count, error);
        if (!status && count == 1)
            status = error_at(error, (struct place){path, number, 1}, "a wavelength without its value");
        if (!status && count == 2) {
            wavelengths[n] = (float)pair[0];
            values[n++] = (float)pair[1];
        }
        line = end ? end + 1 : NULL;
    }
    free(bytes);
    return status ? status : spectrum_finish(property, wavelengths, values, n, error);
}
