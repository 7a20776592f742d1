// <spectrum type="..."> as Mitsuba 3 has it, with its parameters inside: uniform, d65, blackbody, srgb, regular,
// irregular. As in its RGB variants, d65 is white.
#include <string.h>

#include "base/param.h"
#include "format/description_private.h"
#include "format/spectrum.h"

enum { NUMBERS_MAX = 1024 };

static enum status number_of(struct object *object, const char *name, double fallback, double *number,
                             struct error *error) {
    struct property *p = object_property(object, name);
    *number = fallback;
    if (!p) return STATUS_OK;
    p->used = true;
    if (p->type != PROPERTY_FLOAT && p->type != PROPERTY_INT)
        return error_at(error, p->place, "'%s' of a spectrum must be a <float>", name);
    *number = p->number;
    return STATUS_OK;
}

static enum status numbers_of(struct object *object, const char *name, double *numbers, size_t *count,
                              struct error *error) {
    struct property *p = object_property(object, name);
    if (!p)
        return error_at(error, object->place, "a spectrum of type '%s' needs the parameter '%s'", object->type, name);
    p->used = true;
    return parse_numbers(p->string, p->place, name, numbers, NUMBERS_MAX, count, error);
}

static enum status set_pairs(struct arena *arena, struct object *object, bool regular, struct property *property,
                             struct error *error) {
    double nm[NUMBERS_MAX], values[NUMBERS_MAX], first = 0, last = 0;
    size_t count = 0, n = 0;
    enum status status = numbers_of(object, "values", values, &n, error);
    if (!status && !regular) status = numbers_of(object, "wavelengths", nm, &count, error);
    if (!status && regular) status = number_of(object, "wavelength_min", 360, &first, error);
    if (!status && regular) status = number_of(object, "wavelength_max", 830, &last, error);
    if (status) return status;
    if (!regular && count != n)
        return error_at(error, object->place, "the spectrum has %zu wavelengths and %zu values", count, n);
    float *wavelengths = arena_alloc(arena, n, sizeof *wavelengths), *copy = arena_alloc(arena, n, sizeof *copy);
    if (!wavelengths || !copy) return error_set(error, STATUS_MEMORY, "out of memory for a spectrum");
    for (size_t i = 0; i < n; i++) {
        double t = n > 1 ? (double)i / (double)(n - 1) : 0;
        wavelengths[i] = (float)(regular ? first + (last - first) * t : nm[i]);
        copy[i] = (float)values[i];
    }
    property->type = PROPERTY_SPECTRUM;
    return spectrum_finish(property, wavelengths, copy, n, error);
}

static enum status set_blackbody(struct object *object, struct property *property, struct error *error) {
    double scale;
    enum status status = number_of(object, "temperature", 5000, &property->number, error);
    if (!status) status = number_of(object, "scale", 1, &scale, error);
    if (status) return status;
    if (!(property->number >= 1 && property->number <= 1e6))
        return error_at(error, object->place, "temperature must lie between 1 and 1000000 K");
    property->type = PROPERTY_BLACKBODY;
    property->color = rgb_scale(spectrum_blackbody_rgb(property->number), (float)scale);
    return STATUS_OK;
}

// One number, or a colour, times a scale.
static enum status set_color(struct object *object, const char *name, struct property *property, struct error *error) {
    struct property *color = object_property(object, name);
    double scale;
    enum status status = number_of(object, "scale", 1, &scale, error);
    if (status) return status;
    property->type = PROPERTY_RGB;
    property->color = rgb_gray((float)scale);
    if (!color) return STATUS_OK;
    color->used = true;
    bool is_number = color->type == PROPERTY_FLOAT || color->type == PROPERTY_INT;
    if (!is_number && color->type != PROPERTY_RGB && color->type != PROPERTY_SPECTRUM)
        return error_at(error, color->place, "'%s' of a spectrum must be a <float> or an <rgb>", color->name);
    property->color = rgb_scale(is_number ? rgb_gray((float)color->number) : color->color, (float)scale);
    return STATUS_OK;
}

static enum status unknown_spectrum(const struct object *object, struct error *error) {
    static const char *const types[] = {"uniform", "d65", "blackbody", "srgb", "regular", "irregular"};
    const char *near = nearest_name(object->type, types, sizeof types / sizeof *types);
    return error_at(error, object->place,
                    "unknown spectrum '%.60s'%s%s%s; there are uniform, d65, blackbody, srgb, regular, irregular",
                    object->type, near ? "; did you mean '" : "", near ? near : "", near ? "'?" : "");
}

enum status property_set_spectrum(struct arena *arena, struct object *object, struct property *property,
                                  struct error *error) {
    static const char *const harmless[] = {"wavelength_min", "wavelength_max"};
    enum status status;
    property->string = object->type;
    property->transform = transform_identity();
    if (param_name_equal(object->type, "regular") || param_name_equal(object->type, "irregular"))
        status = set_pairs(arena, object, param_name_equal(object->type, "regular"), property, error);
    else if (param_name_equal(object->type, "blackbody"))
        status = set_blackbody(object, property, error);
    else if (param_name_equal(object->type, "uniform"))
        status = set_color(object, "value", property, error);
    else if (param_name_equal(object->type, "d65") || param_name_equal(object->type, "srgb"))
        status = set_color(object, "color", property, error);
    else
        status = unknown_spectrum(object, error);
    for (size_t i = 0; i < object->property_count && !status; i++) {
        const struct property *p = &object->properties[i];
        bool known = p->used || param_name_equal(p->name, harmless[0]) || param_name_equal(p->name, harmless[1]);
        if (!known)
            status =
                error_at(error, p->place, "no parameter '%.60s' in a spectrum of type '%s'", p->name, object->type);
    }
    return status;
}
