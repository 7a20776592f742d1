// Elements that carry a value (<float>, <rgb>, <spectrum>, ...) to properties.
#include "format/description_private.h"

#include <ctype.h>
#include <limits.h>
#include <stdio.h>
#include <string.h>

#include "base/file.h"
#include "format/spectrum.h"

const struct property_tag property_tags[] = {
    {"boolean", PROPERTY_BOOL, {"value"}},
    {"integer", PROPERTY_INT, {"value"}},
    {"float", PROPERTY_FLOAT, {"value"}},
    {"string", PROPERTY_STRING, {"value"}},
    {"point", PROPERTY_VEC3, {"value", "x", "y", "z"}},
    {"vector", PROPERTY_VEC3, {"value", "x", "y", "z"}},
    {"rgb", PROPERTY_RGB, {"value", "intent", "type"}},
    {"srgb", PROPERTY_RGB, {"value", "intent"}},
    {"spectrum", PROPERTY_SPECTRUM, {"value", "filename", "intent", "type"}},
    {"blackbody", PROPERTY_BLACKBODY, {"temperature", "scale"}},
    {"transform", PROPERTY_TRANSFORM, {NULL}},
    {NULL, PROPERTY_BOOL, {NULL}},
};

static enum status spectrum_value(struct arena *arena, const char *const *a, struct property *property,
                                  struct error *error) {
    const char *filename = attribute_value(a, "filename");
    if (!filename) return parse_spectrum(arena, property->string, property, error);
    char path[PATH_MAX];
    path_resolve(path, sizeof path, property->place.file, filename);
    return load_spd(arena, path, property, error);
}

static enum status blackbody_value(const char *const *a, struct property *property, struct error *error) {
    const char *text = attribute_value(a, "temperature"), *scale_text = attribute_value(a, "scale");
    double scale = 1;
    if (!text) return error_at(error, property->place, "<blackbody> needs the attribute temperature, in kelvin");
    char digits[32];
    snprintf(digits, sizeof digits, "%s", text);
    size_t length = strlen(digits);
    if (length && toupper((unsigned char)digits[length - 1]) == 'K') digits[length - 1] = 0;
    enum status status = parse_number(digits, property->place, "temperature", &property->number, error);
    if (!status && !(property->number >= 1 && property->number <= 1e6))
        status = error_at(error, property->place, "temperature must lie between 1 and 1000000 K");
    if (!status && scale_text) status = parse_number(scale_text, property->place, "scale", &scale, error);
    if (!status) property->color = rgb_scale(spectrum_blackbody_rgb(property->number), (float)scale);
    property->string = text;
    return status;
}

static enum status vector_value(const char *const *a, struct property *property, struct error *error) {
    double n[3] = {0};
    size_t count = 3;
    enum status status = STATUS_OK;
    if (attribute_value(a, "value"))
        status = parse_numbers(property->string, property->place, property->name, n, 3, &count, error);
    for (int i = 0; i < 3 && !attribute_value(a, "value") && !status; i++) {
        const char axis[2] = {(char)('x' + i), 0}, *text = attribute_value(a, axis);
        if (text) status = parse_number(text, property->place, axis, &n[i], error);
    }
    if (!status && count != 3)
        status = error_at(error, property->place, "'%s' has %zu numbers; write three", property->name, count);
    property->vector = vec3_make((float)n[0], (float)n[1], (float)n[2]);
    return status;
}

enum status property_set(struct arena *arena, const struct property_tag *tag, const char *const *a, struct property *p,
                         struct error *error) {
    const char *text = attribute_value(a, "value");
    bool needs_value = tag->attributes[0] && !strcmp(tag->attributes[0], "value") && tag->type != PROPERTY_VEC3;
    if (needs_value && !text && !attribute_value(a, "filename"))
        return error_at(error, p->place, "<%s name=\"%s\"> needs the attribute value", tag->tag, p->name);
    p->type = tag->type;
    p->string = text ? text : "";
    p->transform = transform_identity();
    switch (tag->type) {
    case PROPERTY_BOOL:
        return parse_boolean(text, p->place, p->name, &p->boolean, error);
    case PROPERTY_INT:
        return parse_integer(text, p->place, p->name, &p->number, error);
    case PROPERTY_FLOAT:
        return parse_number(text, p->place, p->name, &p->number, error);
    case PROPERTY_VEC3:
        return vector_value(a, p, error);
    case PROPERTY_RGB:
        return parse_color(text, p->place, !strcmp(tag->tag, "srgb"), &p->color, error);
    case PROPERTY_SPECTRUM:
        return spectrum_value(arena, a, p, error);
    case PROPERTY_BLACKBODY:
        return blackbody_value(a, p, error);
    case PROPERTY_STRING:
    case PROPERTY_TRANSFORM:
        break;
    }
    return STATUS_OK;
}
