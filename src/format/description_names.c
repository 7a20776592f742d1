// $names in the attributes of elements: <default>s and -D definitions are put in before anything else looks at them.
#include "format/description_private.h"

#include <ctype.h>
#include <stdio.h>
#include <string.h>

#include "base/param.h"

struct named_value *named_value_find(struct named_value *values, const char *name, size_t length) {
    for (struct named_value *v = values; v; v = v->next)
        if (!strncmp(v->name, name, length) && !v->name[length]) return v;
    return NULL;
}

static enum status value_unknown(const struct named_value *values, const char *name, int length, struct place place,
                                 struct error *error) {
    const char *names[64], *near;
    char wanted[64];
    size_t n = 0;
    for (const struct named_value *v = values; v && n < 64; v = v->next) names[n++] = v->name;
    snprintf(wanted, sizeof wanted, "%.*s", length, name);
    near = nearest_name(wanted, names, n);
    return error_at(error, place, "$%s has no value; %s%s%sgive -D %s=... or a <default name=\"%s\" value=\"...\"/>",
                    wanted, near ? "did you mean $" : "", near ? near : "", near ? "? Or " : "", wanted, wanted);
}

// `text` with every $name replaced by its value: the longest known name that fits.
static enum status text_substitute(struct arena *arena, struct named_value *values, const char *text,
                                   struct place place, const char **result, struct error *error) {
    char buffer[16384];
    size_t used = 0;
    const char *dollar;
    while ((dollar = strchr(text, '$'))) {
        size_t length = 0;
        while (length < 60 && (isalnum((unsigned char)dollar[1 + length]) || dollar[1 + length] == '_')) length++;
        struct named_value *value = NULL;
        for (size_t n = length; n && !value; n--) value = named_value_find(values, dollar + 1, n);
        if (!value && length) return value_unknown(values, dollar + 1, (int)length, place, error);
        if (value && value->used) *value->used = true;
        int written = snprintf(buffer + used, sizeof buffer - used, "%.*s%s", (int)(dollar - text), text,
                               value ? value->value : "$");
        if (written < 0 || (size_t)written >= sizeof buffer - used)
            return error_at(error, place, "an attribute with $names grows beyond %zu bytes", sizeof buffer);
        used += (size_t)written;
        text = dollar + 1 + (value ? strlen(value->name) : 0);
    }
    buffer[used] = 0;
    *result = used ? arena_printf(arena, "%s%s", buffer, text) : arena_strdup(arena, text);
    return *result ? STATUS_OK
                   : error_set(error, STATUS_MEMORY, "%s: out of memory while reading the scene", place.file);
}

enum status attributes_take(struct arena *arena, struct named_value *values, const char *tag, struct place place,
                            const char *const *raw, const char *const *known, size_t known_count,
                            const char **attributes, struct error *error) {
    size_t n = 0;
    for (; *raw; raw += 2, n += 2) {
        size_t k = 0;
        while (k < known_count && !param_name_equal(known[k], raw[0])) k++;
        if (k == known_count) {
            const char *near = nearest_name(raw[0], known, known_count);
            return error_at(error, place, "<%s> has no attribute '%.60s'%s%s%s", tag, raw[0],
                            near ? "; did you mean '" : "", near ? near : "", near ? "'?" : "");
        }
        if (n + 3 > ATTRIBUTES_CAPACITY) return error_at(error, place, "<%s> has too many attributes", tag);
        attributes[n] = known[k];
        enum status status = text_substitute(arena, values, raw[1], place, &attributes[n + 1], error);
        if (status) return status;
    }
    attributes[n] = NULL;
    return STATUS_OK;
}
