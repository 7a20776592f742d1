// Small JSON files, written whole or not at all.
#include "evidence/kept.h"

#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/hash.h"

enum status kept_hash_file(uint64_t *hash, const char *path, struct error *error) {
    uint8_t *bytes;
    size_t length;
    enum status status = file_read(path, &bytes, &length, error);
    if (status) return status;
    *hash = hash_bytes(*hash, bytes, length);
    free(bytes);
    return STATUS_OK;
}

enum status kept_save(const char *path, json_t *object, struct error *error) {
    char *text = object ? json_dumps(object, JSON_INDENT(1) | JSON_REAL_PRECISION(15)) : NULL;
    json_decref(object);
    if (!text) return error_set(error, STATUS_MEMORY, "%s: out of memory", path);
    enum status status = file_write_atomic(path, text, strlen(text), error);
    free(text);
    return status;
}

json_t *kept_load(const char *path, const char *key) {
    json_t *object = json_load_file(path, 0, NULL);
    const char *kept = json_string_value(json_object_get(object, "key"));
    if (kept && (!key || !strcmp(kept, key))) return object;
    json_decref(object);
    return NULL;
}
