// Declared parameters to struct fields: the one place where values of a scene file are checked against their ranges.
#include "scene/params.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "format/spectrum.h"

struct reader {
    char *plugin;
    struct object *object;
    struct commit_context *context;
    const struct texture_maker *maker;
    struct error *error;
};

static bool is_checked(const struct param *param) { return param->min < param->max; }

static enum status out_of_range(const struct reader *reader, const struct param *param, struct place place,
                                double value) {
    const char *unit = param->unit && strcmp(param->unit, "1") ? param->unit : "";
    return error_at(reader->error, place, "'%s' is %g%s%s; it must lie between %g and %g%s%s", param->name, value,
                    *unit ? " " : "", unit, param->min, param->max, *unit ? " " : "", unit);
}

static enum status wrong_type(const struct reader *reader, const struct param *param, struct place place) {
    static const char *const wanted[] = {[PARAM_BOOL] = "a <boolean>",
                                         [PARAM_INT] = "an <integer>",
                                         [PARAM_FLOAT] = "a <float>",
                                         [PARAM_STRING] = "a <string>",
                                         [PARAM_CHOICE] = "a <string>",
                                         [PARAM_RGB] = "an <rgb>, <spectrum> or <float>",
                                         [PARAM_VEC3] = "a <point> or <vector>",
                                         [PARAM_TRANSFORM] = "a <transform>",
                                         [PARAM_TEXTURE] = "an <rgb>, <spectrum>, <float> or <texture>"};
    return error_at(reader->error, place, "'%s' of %s '%s' must be %s", param->name, reader->object->tag,
                    reader->object->type, wanted[param->type]);
}

static enum status read_choice(const struct reader *reader, const struct param *param, struct place place,
                               const char *text, int *choice) {
    int index = 0;
    for (const char *name = param->choices; *name; index++) {
        size_t length = strcspn(name, "|");
        char candidate[64];
        snprintf(candidate, sizeof candidate, "%.*s", (int)length, name);
        if (param_name_equal(candidate, text)) {
            *choice = index;
            return STATUS_OK;
        }
        name += length + (name[length] == '|');
    }
    return error_at(reader->error, place, "'%s' is '%.80s'; it must be one of %s", param->name, text, param->choices);
}

// A colour of a file: ranges are errors, but a measured spectrum whose colour Rec. 709 cannot hold is clamped, as in
// Mitsuba.
static enum status read_color(const struct reader *reader, const struct param *param, const struct property *p,
                              rgb *color) {
    enum spectrum_use use = strcmp(reader->object->tag, "emitter") ? SPECTRUM_REFLECTANCE : SPECTRUM_EMISSION;
    switch (p->type) {
    case PROPERTY_INT:
    case PROPERTY_FLOAT:
        *color = rgb_gray((float)p->number);
        break;
    case PROPERTY_RGB:
    case PROPERTY_BLACKBODY:
        *color = p->color;
        break;
    case PROPERTY_SPECTRUM:
        *color = p->pair_count ? spectrum_rgb(p->wavelengths_nm, p->values, p->pair_count, use)
                               : spectrum_uniform_rgb((float)p->number, use);
        if (p->pair_count && is_checked(param)) {
            float low = (float)param->min, high = (float)param->max;
            *color = (rgb){clampf(color->r, low, high), clampf(color->g, low, high), clampf(color->b, low, high)};
        }
        break;
    case PROPERTY_BOOL:
    case PROPERTY_STRING:
    case PROPERTY_VEC3:
    case PROPERTY_TRANSFORM:
        return wrong_type(reader, param, p->place);
    }
    const float channels[3] = {color->r, color->g, color->b};
    for (int i = 0; i < 3 && is_checked(param); i++)
        if (!(channels[i] >= (float)param->min && channels[i] <= (float)param->max))
            return out_of_range(reader, param, p->place, channels[i]);
    return STATUS_OK;
}

static enum status set_constant_texture(const struct reader *reader, const struct texture **field, rgb color) {
    struct texture *texture = arena_alloc(reader->context->arena, 1, sizeof *texture);
    if (!texture) return error_set(reader->error, STATUS_MEMORY, "out of memory for a texture");
    texture->value = color;
    *field = texture;
    return STATUS_OK;
}

static enum status read_property(const struct reader *reader, const struct param *param, struct property *p) {
    void *field = reader->plugin + param->offset;
    bool is_number = p->type == PROPERTY_INT || (p->type == PROPERTY_FLOAT && param->type == PARAM_FLOAT);
    rgb color;
    enum status status;
    p->used = true;
    switch (param->type) {
    case PARAM_BOOL:
        if (p->type != PROPERTY_BOOL) return wrong_type(reader, param, p->place);
        *(bool *)field = p->boolean;
        return STATUS_OK;
    case PARAM_INT:
    case PARAM_FLOAT:
        if (!is_number) return wrong_type(reader, param, p->place);
        if (is_checked(param) && !(p->number >= param->min && p->number <= param->max))
            return out_of_range(reader, param, p->place, p->number);
        if (param->type == PARAM_INT)
            *(int *)field = (int)p->number;
        else
            *(float *)field = (float)p->number;
        return STATUS_OK;
    case PARAM_STRING: // a number is taken too: an index of refraction may be either
        if (p->type != PROPERTY_STRING && p->type != PROPERTY_FLOAT && p->type != PROPERTY_INT)
            return wrong_type(reader, param, p->place);
        *(const char **)field = p->string;
        return STATUS_OK;
    case PARAM_CHOICE:
        if (p->type != PROPERTY_STRING) return wrong_type(reader, param, p->place);
        return read_choice(reader, param, p->place, p->string, field);
    case PARAM_RGB:
        return read_color(reader, param, p, field);
    case PARAM_VEC3:
        if (p->type != PROPERTY_VEC3) return wrong_type(reader, param, p->place);
        *(vec3 *)field = p->vector;
        return STATUS_OK;
    case PARAM_TRANSFORM:
        if (p->type != PROPERTY_TRANSFORM) return wrong_type(reader, param, p->place);
        *(struct transform *)field = p->transform;
        return STATUS_OK;
    case PARAM_TEXTURE:
        status = read_color(reader, param, p, &color);
        return status ? status : set_constant_texture(reader, field, color);
    }
    return STATUS_OK;
}

// The fallbacks are written by us: they are not checked.
static enum status set_fallback(const struct reader *reader, const struct param *param) {
    void *field = reader->plugin + param->offset;
    if (param->type == PARAM_TRANSFORM) {
        *(struct transform *)field = transform_identity();
        return STATUS_OK;
    }
    if (!*param->fallback) return STATUS_OK;
    float n[3] = {0};
    const char *at = param->fallback;
    int count = 0;
    for (char *end; count < 3; count++, at = end) {
        float value = strtof(at, &end);
        if (end == at) break;
        n[count] = value;
    }
    rgb color = count == 3 ? (rgb){n[0], n[1], n[2]} : rgb_gray(n[0]);
    switch (param->type) {
    case PARAM_BOOL:
        *(bool *)field = !strcmp(param->fallback, "true");
        break;
    case PARAM_INT:
        *(int *)field = atoi(param->fallback);
        break;
    case PARAM_FLOAT:
        *(float *)field = n[0];
        break;
    case PARAM_STRING:
        *(const char **)field = param->fallback;
        break;
    case PARAM_CHOICE:
        return read_choice(reader, param, reader->object->place, param->fallback, field);
    case PARAM_RGB:
        *(rgb *)field = color;
        break;
    case PARAM_VEC3:
        *(vec3 *)field = vec3_make(n[0], n[1], n[2]);
        break;
    case PARAM_TEXTURE:
        return set_constant_texture(reader, field, color);
    case PARAM_TRANSFORM:
        break;
    }
    return STATUS_OK;
}

static bool param_has_name(const struct param *param, const char *name) {
    return param_name_equal(param->name, name) || (param->alias && param_name_equal(param->alias, name));
}

static bool is_single_texture(const struct param *params, const struct param *param) {
    for (; params->name; params++)
        if (params != param && params->type == PARAM_TEXTURE) return false;
    return true;
}

// The child that a texture parameter takes: by name, or the only one of a plugin that takes a single texture.
static struct object_child *texture_child(const struct object *object, const struct param *params,
                                          const struct param *param) {
    for (size_t i = 0; i < object->child_count; i++)
        if (!strcmp(object->children[i].object->tag, "texture") && param_has_name(param, object->children[i].name))
            return &object->children[i];
    for (size_t i = 0; i < object->child_count && is_single_texture(params, param); i++)
        if (!strcmp(object->children[i].object->tag, "texture")) return &object->children[i];
    return NULL;
}

static enum status read_param(const struct reader *reader, const struct param *params, const struct param *param) {
    struct property *property = object_property(reader->object, param->name);
    if (!property && param->alias) property = object_property(reader->object, param->alias);
    struct object_child *child = param->type == PARAM_TEXTURE ? texture_child(reader->object, params, param) : NULL;
    if (child && property)
        return error_at(reader->error, child->place, "'%s' is given already at line %d", param->name,
                        property->place.line);
    if (property) return read_property(reader, param, property);
    if (child) {
        child->object->used = true;
        return reader->maker->make(reader->maker->user, child->object,
                                   (const struct texture **)(void *)(reader->plugin + param->offset), reader->error);
    }
    if (!param->fallback)
        return error_at(reader->error, reader->object->place, "%s '%s' needs the parameter '%s': %s",
                        reader->object->tag, reader->object->type, param->name, param->help ? param->help : "");
    return set_fallback(reader, param);
}

static const struct param *params_find(const struct param *params, const char *name) {
    for (; params && params->name; params++)
        if (param_has_name(params, name)) return params;
    return NULL;
}

enum status params_read(void *plugin, const struct param *params, const struct param *except, struct object *object,
                        struct commit_context *context, const struct texture_maker *maker, struct error *error) {
    const struct reader reader = {plugin, object, context, maker, error};
    for (const struct param *param = params; param && param->name; param++) {
        if (params_find(except, param->name)) continue;
        enum status status = read_param(&reader, params, param);
        if (status) return status;
    }
    return STATUS_OK;
}

void params_ignore(const struct object *object, const char *const *names) {
    for (; *names; names++) {
        struct property *property = object_property(object, *names);
        if (property) property->used = true;
    }
}

static const char *nearest_param(const char *name, const struct param *const *tables, size_t table_count) {
    const char *names[128];
    size_t n = 0;
    for (size_t i = 0; i < table_count; i++)
        for (const struct param *p = tables[i]; p && p->name && n < 127; p++) {
            names[n++] = p->name;
            if (p->alias) names[n++] = p->alias;
        }
    return nearest_name(name, names, n);
}

static enum status unknown_param(const struct object *object, const char *name, struct place place,
                                 const struct param *const *tables, size_t table_count, struct error *error) {
    const char *near = nearest_param(name, tables, table_count);
    return error_at(error, place, "no parameter '%.60s' in %s '%s'; %s%s%ssee `sconce help %s %s`", name, object->tag,
                    object->type, near ? "did you mean '" : "", near ? near : "", near ? "'? Or " : "", object->tag,
                    object->type);
}

enum status params_check_properties(const struct object *object, const struct param *const *tables, size_t table_count,
                                    struct error *error) {
    for (size_t i = 0; i < object->property_count; i++)
        if (!object->properties[i].used)
            return unknown_param(object, object->properties[i].name, object->properties[i].place, tables, table_count,
                                 error);
    return STATUS_OK;
}

enum status params_check_settings(const struct object *object, const struct param *const *tables, size_t table_count,
                                  const struct run *run, struct error *error) {
    for (size_t i = 0; i < object->property_count; i++) {
        const struct property *p = &object->properties[i];
        if (p->used) continue;
        if (nearest_param(p->name, tables, table_count))
            return unknown_param(object, p->name, p->place, tables, table_count, error);
        run_note(run, "%s:%d:%d: parameter '%.60s' of %s '%s' is ignored", p->place.file, p->place.line,
                 p->place.column, p->name, object->tag, object->type);
    }
    return STATUS_OK;
}

enum status params_check_used(const struct object *object, const struct param *const *tables, size_t table_count,
                              struct error *error) {
    enum status status = params_check_properties(object, tables, table_count, error);
    if (status) return status;
    for (size_t i = 0; i < object->child_count; i++) {
        const struct object_child *child = &object->children[i];
        bool taken = strcmp(child->object->tag, "texture") != 0;
        for (size_t t = 0; t < table_count && !taken; t++)
            for (const struct param *p = tables[t]; p && p->name && !taken; p++)
                taken = p->type == PARAM_TEXTURE && texture_child(object, tables[t], p) == child;
        if (!taken) return unknown_param(object, child->name, child->place, tables, table_count, error);
    }
    return STATUS_OK;
}
