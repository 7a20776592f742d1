// The operations of a <transform>, in the order they are written: each is applied after those before it.
#include "format/description_private.h"

#include <string.h>

#include "base/param.h"

const char *attribute_value(const char *const *attributes, const char *name) {
    for (; *attributes; attributes += 2)
        if (param_name_equal(attributes[0], name)) return attributes[1];
    return NULL;
}

// `name` as three numbers, or as one where `allow_one`.
static enum status vector_attribute(const char *const *attributes, const char *name, bool allow_one, struct place place,
                                    vec3 *v, struct error *error) {
    double n[3];
    size_t count;
    enum status status = parse_numbers(attribute_value(attributes, name), place, name, n, 3, &count, error);
    if (status) return status;
    if (allow_one && count == 1)
        n[1] = n[2] = n[0];
    else if (count != 3)
        return error_at(error, place, "%s has %zu numbers; write %s", name, count,
                        allow_one ? "one or three" : "three");
    *v = vec3_make((float)n[0], (float)n[1], (float)n[2]);
    return STATUS_OK;
}

// value="..." or x, y, z, where those absent are `fallback`.
static enum status value_or_xyz(const char *const *attributes, float fallback, bool allow_one, struct place place,
                                vec3 *v, struct error *error) {
    if (attribute_value(attributes, "value")) return vector_attribute(attributes, "value", allow_one, place, v, error);
    float *components[3] = {&v->x, &v->y, &v->z};
    for (int i = 0; i < 3; i++) {
        const char name[2] = {(char)('x' + i), 0}, *text = attribute_value(attributes, name);
        double number = fallback;
        enum status status = text ? parse_number(text, place, name, &number, error) : STATUS_OK;
        if (status) return status;
        *components[i] = (float)number;
    }
    return STATUS_OK;
}

static enum status look_at(const char *const *attributes, struct place place, struct transform *operation,
                           struct error *error) {
    vec3 origin, target, up = {0, 1, 0};
    if (!attribute_value(attributes, "origin") || !attribute_value(attributes, "target"))
        return error_at(error, place, "lookat needs the attributes origin and target");
    enum status status = vector_attribute(attributes, "origin", false, place, &origin, error);
    if (!status) status = vector_attribute(attributes, "target", false, place, &target, error);
    if (!status && attribute_value(attributes, "up"))
        status = vector_attribute(attributes, "up", false, place, &up, error);
    if (status) return status;
    float length = vec3_length(vec3_sub(target, origin));
    if (!(length > 0 && isfinite(length) && vec3_length(up) > 0))
        return error_at(error, place, "lookat: origin and target coincide, or up is zero");
    *operation = transform_look_at(origin, target, up);
    return STATUS_OK;
}

static enum status matrix(const char *const *attributes, struct place place, struct transform *operation,
                          struct error *error) {
    double n[16];
    size_t count;
    const char *text = attribute_value(attributes, "value");
    if (!text) return error_at(error, place, "matrix needs the attribute value");
    enum status status = parse_numbers(text, place, "matrix", n, 16, &count, error);
    if (status) return status;
    if (count != 16 && count != 9) return error_at(error, place, "matrix has %zu numbers; write 16, or 9", count);
    size_t size = count == 16 ? 4 : 3;
    float m[4][4] = {[3][3] = 1};
    for (size_t i = 0; i < count; i++) m[i / size][i % size] = (float)n[i];
    bool invertible;
    *operation = transform_from_matrix(m, &invertible);
    if (!invertible) return error_at(error, place, "matrix has no inverse");
    return STATUS_OK;
}

enum status transform_apply_element(const char *tag, const char *const *attributes, struct place place,
                                    struct transform *accumulated, struct error *error) {
    struct transform operation = transform_identity();
    enum status status = STATUS_OK;
    vec3 v;
    if (param_name_equal(tag, "translate")) {
        status = value_or_xyz(attributes, 0, false, place, &v, error);
        if (!status) operation = transform_translate(v);
    } else if (param_name_equal(tag, "scale")) {
        status = value_or_xyz(attributes, 1, true, place, &v, error);
        if (!status && (v.x == 0 || v.y == 0 || v.z == 0))
            status = error_at(error, place, "scale by 0 flattens everything; its factors must not be 0");
        if (!status) operation = transform_scale(v);
    } else if (param_name_equal(tag, "rotate")) {
        double degrees;
        const char *angle = attribute_value(attributes, "angle");
        if (!angle) return error_at(error, place, "rotate needs the attribute angle, in degrees");
        status = parse_number(angle, place, "angle", &degrees, error);
        if (!status) status = value_or_xyz(attributes, 0, false, place, &v, error);
        if (!status && !(vec3_length(v) > 0)) status = error_at(error, place, "rotate needs an axis, as in y=\"1\"");
        if (!status) operation = transform_rotate(v, (float)degrees);
    } else if (param_name_equal(tag, "lookat")) {
        status = look_at(attributes, place, &operation, error);
    } else {
        status = matrix(attributes, place, &operation, error);
    }
    if (status) return status;
    struct transform result = transform_multiply(&operation, accumulated);
    for (int i = 0; i < 16; i++)
        if (!isfinite(result.m[i / 4][i % 4]) || !isfinite(result.inverse[i / 4][i % 4]))
            return error_at(error, place, "the transform is too large or too small for 32-bit numbers");
    *accumulated = result;
    return STATUS_OK;
}
