// PLY meshes (Turk 1994): ascii and both binary orders, any scalar types, polygons as fans, other elements skipped.
// Our own reader because Assimp 5.2 takes truncated PLY files for whole ones, crashes on some and allocates what the
// header claims. Here every element must be there, and memory follows the bytes read, not the header's counts.
// Checked against Mitsuba 3.9: texture coordinates (u v, s t) are not flipped; normals are computed where there are
// none.
#include "format/mesh.h"

#include <stdlib.h>
#include <string.h>

#include "base/file.h"

enum ply_type { PLY_NONE, PLY_I8, PLY_U8, PLY_I16, PLY_U16, PLY_I32, PLY_U32, PLY_F32, PLY_F64 };
static const struct ply_type_name {
    const char *name;
    enum ply_type type;
    size_t size;
} type_names[] = {
    {"char", PLY_I8, 1},   {"int8", PLY_I8, 1},     {"uchar", PLY_U8, 1},   {"uint8", PLY_U8, 1},
    {"short", PLY_I16, 2}, {"int16", PLY_I16, 2},   {"ushort", PLY_U16, 2}, {"uint16", PLY_U16, 2},
    {"int", PLY_I32, 4},   {"int32", PLY_I32, 4},   {"uint", PLY_U32, 4},   {"uint32", PLY_U32, 4},
    {"float", PLY_F32, 4}, {"float32", PLY_F32, 4}, {"double", PLY_F64, 8}, {"float64", PLY_F64, 8},
};

enum { PLY_ASCII, PLY_LITTLE, PLY_BIG };
enum { PROPERTIES_MAX = 64, ELEMENTS_MAX = 16, VALUES = 8 };

struct property { // of one element
    const struct ply_type_name *type, *count_type; // count_type: of a list, else NULL
    int slot; // vertex: where the value goes (see vertex_slots), -1 nowhere
    bool indices; // face: the list of vertices
};

struct element {
    char name[32];
    uint64_t count;
    struct property properties[PROPERTIES_MAX];
    int property_count;
};

struct ply {
    const char *path;
    const uint8_t *place, *end;
    int form; // PLY_ASCII ...
    struct element elements[ELEMENTS_MAX];
    int element_count;
};

static const char *const vertex_slots[VALUES][4] = {
    {"x"},
    {"y"},
    {"z"},
    {"nx"},
    {"ny"},
    {"nz"},
    {"u", "s", "texture_u", "texture_s"},
    {"v", "t", "texture_v", "texture_t"},
};

static int vertex_slot(const char *name) {
    for (int slot = 0; slot < VALUES; ++slot) {
        for (int i = 0; i < 4 && vertex_slots[slot][i]; ++i) {
            if (strcmp(name, vertex_slots[slot][i]) == 0) return slot;
        }
    }
    return -1;
}

static const struct ply_type_name *type_find(const char *name) {
    for (size_t i = 0; i < sizeof type_names / sizeof *type_names; ++i) {
        if (name && strcmp(name, type_names[i].name) == 0) return &type_names[i];
    }
    return NULL;
}

static enum status add_property(struct ply *ply, char **words, struct error *error) {
    struct element *element = ply->element_count ? &ply->elements[ply->element_count - 1] : NULL;
    bool list = words[1] && strcmp(words[1], "list") == 0;
    const char *name = list ? words[4] : words[2];
    struct property property = {.type = type_find(list ? words[3] : words[1]),
                                .count_type = list ? type_find(words[2]) : NULL};
    if (!element || !property.type || !name ||
        (list && (!property.count_type || property.count_type->type >= PLY_F32))) {
        return error_set(error, STATUS_INVALID, "%s: a property of the PLY header cannot be understood", ply->path);
    }
    if (element->property_count == PROPERTIES_MAX) {
        return error_set(error, STATUS_UNSUPPORTED, "%s: more than %d properties in an element", ply->path,
                         PROPERTIES_MAX);
    }
    property.slot = list || strcmp(element->name, "vertex") != 0 ? -1 : vertex_slot(name);
    property.indices = list && strcmp(element->name, "face") == 0 &&
                       (strcmp(name, "vertex_indices") == 0 || strcmp(name, "vertex_index") == 0);
    element->properties[element->property_count++] = property;
    return STATUS_OK;
}

static enum status add_element(struct ply *ply, char **words, struct error *error) {
    char *rest = NULL;
    unsigned long long count = words[1] && words[2] ? strtoull(words[2], &rest, 10) : 0;
    if (!rest || *rest || words[2][0] == '-' || strlen(words[1]) >= sizeof ply->elements->name) {
        return error_set(error, STATUS_INVALID, "%s: an element of the PLY header cannot be understood", ply->path);
    }
    if (ply->element_count == ELEMENTS_MAX)
        return error_set(error, STATUS_UNSUPPORTED, "%s: more than %d elements", ply->path, ELEMENTS_MAX);
    struct element *element = &ply->elements[ply->element_count++];
    strcpy(element->name, words[1]);
    element->count = count;
    return STATUS_OK;
}

// One line of the header, cut into at most 5 words in `text`; false at the end of the file or where it is too long.
static bool header_line(struct ply *ply, char text[256], char *words[6]) {
    const uint8_t *newline = memchr(ply->place, '\n', (size_t)(ply->end - ply->place));
    size_t length = newline ? (size_t)(newline - ply->place) : 0;
    if (!newline || length >= 256) return false;
    memcpy(text, ply->place, length);
    text[length] = 0;
    ply->place = newline + 1;
    char *rest = text;
    for (int i = 0; i < 6; ++i) words[i] = i < 5 ? strtok_r(i ? NULL : text, " \t\r", &rest) : NULL;
    return true;
}

static enum status parse_header(struct ply *ply, struct error *error) {
    static const char *const forms[] = {"ascii", "binary_little_endian", "binary_big_endian"};
    char text[256], *words[6];
    bool magic = header_line(ply, text, words) && words[0] && strcmp(words[0], "ply") == 0, formed = false;
    while (magic && header_line(ply, text, words)) {
        enum status status = STATUS_OK;
        if (!words[0]) continue;
        if (strcmp(words[0], "end_header") == 0 && formed) return STATUS_OK;
        if (strcmp(words[0], "element") == 0) status = add_element(ply, words, error);
        if (strcmp(words[0], "property") == 0) status = add_property(ply, words, error);
        for (int i = 0; i < 3 && strcmp(words[0], "format") == 0 && words[1]; ++i) {
            if (strcmp(words[1], forms[i]) != 0) continue;
            ply->form = i;
            formed = true;
        }
        if (status != STATUS_OK) return status;
    }
    return error_set(error, STATUS_INVALID, "%s: %s", ply->path,
                     magic ? "the PLY header is damaged or truncated" : "not a PLY file");
}

static bool read_ascii(struct ply *ply, double *value) {
    while (ply->place < ply->end && strchr(" \t\r\n", *ply->place) && *ply->place) ++ply->place;
    char *rest;
    *value = strtod((const char *)ply->place, &rest); // file_read ends the bytes with a zero
    if (rest == (const char *)ply->place || (const uint8_t *)rest > ply->end) return false;
    ply->place = (const uint8_t *)rest;
    return true;
}

static bool read_value(struct ply *ply, const struct ply_type_name *type, double *value) {
    if (ply->form == PLY_ASCII) return read_ascii(ply, value);
    if (type->size > (size_t)(ply->end - ply->place)) return false;
    uint64_t bits = 0;
    for (size_t i = 0; i < type->size; ++i)
        bits = bits << 8 | ply->place[ply->form == PLY_BIG ? i : type->size - 1 - i];
    ply->place += type->size;
    uint32_t low = (uint32_t)bits;
    float single;
    switch (type->type) {
    case PLY_I8:
        *value = (int8_t)bits;
        break;
    case PLY_I16:
        *value = (int16_t)bits;
        break;
    case PLY_I32:
        *value = (int32_t)bits;
        break;
    case PLY_F32:
        memcpy(&single, &low, sizeof single), *value = (double)single;
        break;
    case PLY_F64:
        memcpy(value, &bits, sizeof *value);
        break;
    default:
        *value = (double)bits;
        break;
    }
    return true;
}

static enum status truncated(const struct ply *ply, const struct element *element, uint64_t index,
                             struct error *error) {
    return error_set(error, STATUS_INVALID, "%s: ends at %s %llu of %llu; the file is truncated or damaged", ply->path,
                     element->name, (unsigned long long)index, (unsigned long long)element->count);
}

// A value per property at least is still to come: an early end of the claim that a short file holds much.
static bool count_possible(const struct ply *ply, const struct element *element) {
    return element->property_count == 0 || element->count <= (uint64_t)(ply->end - ply->place);
}

static bool skip_list(struct ply *ply, const struct property *property) {
    double count, ignored;
    if (!read_value(ply, property->count_type, &count) || count < 0) return false;
    for (double i = 0; i < count; ++i) {
        if (!read_value(ply, property->type, &ignored)) return false;
    }
    return true;
}

static enum status read_vertices(struct ply *ply, const struct element *element, struct mesh *mesh, struct arena *arena,
                                 struct error *error) {
    bool has[VALUES] = {false};
    for (int i = 0; i < element->property_count; ++i) {
        if (element->properties[i].slot >= 0) has[element->properties[i].slot] = true;
    }
    if (!has[0] || !has[1] || !has[2])
        return error_set(error, STATUS_INVALID, "%s: the vertices have no x, y and z", ply->path);
    if (mesh->positions) return error_set(error, STATUS_INVALID, "%s: has two lists of vertices", ply->path);
    if (!count_possible(ply, element)) return truncated(ply, element, 0, error);
    bool normals = has[3] && has[4] && has[5], uvs = has[6] && has[7];
    mesh->vertex_count = element->count;
    mesh->positions = arena_alloc(arena, element->count, sizeof *mesh->positions);
    mesh->normals = normals ? arena_alloc(arena, element->count, sizeof *mesh->normals) : NULL;
    mesh->uvs = uvs ? arena_alloc(arena, element->count, sizeof *mesh->uvs) : NULL;
    if (!mesh->positions || (normals && !mesh->normals) || (uvs && !mesh->uvs))
        return error_set(error, STATUS_MEMORY, "%s: out of memory", ply->path);
    for (uint64_t v = 0; v < element->count; ++v) {
        float values[VALUES] = {0};
        for (int i = 0; i < element->property_count; ++i) {
            const struct property *property = &element->properties[i];
            double value = 0;
            bool read = property->count_type ? skip_list(ply, property) : read_value(ply, property->type, &value);
            if (!read) return truncated(ply, element, v, error);
            if (property->slot >= 0) values[property->slot] = (float)value;
        }
        mesh->positions[v] = (vec3){values[0], values[1], values[2]};
        if (normals) mesh->normals[v] = (vec3){values[3], values[4], values[5]};
        if (uvs) mesh->uvs[v] = (vec2){values[6], values[7]};
    }
    return STATUS_OK;
}

struct indices {
    uint32_t *values;
    size_t count, capacity;
};

static bool indices_add(struct indices *list, uint32_t a, uint32_t b, uint32_t c) {
    if (list->count + 3 > list->capacity) {
        size_t capacity = list->capacity ? 2 * list->capacity : 3 << 12;
        uint32_t *larger = capacity <= SIZE_MAX / 8 ? realloc(list->values, capacity * sizeof *larger) : NULL;
        if (!larger) return false;
        list->values = larger;
        list->capacity = capacity;
    }
    list->values[list->count++] = a, list->values[list->count++] = b, list->values[list->count++] = c;
    return true;
}

// One polygon as a fan; fewer than three corners are dropped. An index outside uint32_t becomes UINT32_MAX, which
// mesh_finish rejects.
static enum status read_polygon(struct ply *ply, const struct element *element, const struct property *property,
                                uint64_t face, struct indices *list, struct error *error) {
    double count, value;
    if (!read_value(ply, property->count_type, &count) || count < 0) return truncated(ply, element, face, error);
    uint32_t first = 0, previous = 0;
    for (double k = 0; k < count; ++k) {
        if (!read_value(ply, property->type, &value)) return truncated(ply, element, face, error);
        uint32_t index = value >= 0 && value < UINT32_MAX ? (uint32_t)value : UINT32_MAX;
        if (k == 0) first = index;
        if (k >= 2 && !indices_add(list, first, previous, index))
            return error_set(error, STATUS_MEMORY, "%s: out of memory", ply->path);
        previous = index;
    }
    return STATUS_OK;
}

static enum status read_faces(struct ply *ply, const struct element *element, struct indices *list,
                              struct error *error) {
    if (!count_possible(ply, element)) return truncated(ply, element, 0, error);
    if (element->property_count == 0) return STATUS_OK;
    for (uint64_t f = 0; f < element->count; ++f) {
        for (int i = 0; i < element->property_count; ++i) {
            const struct property *property = &element->properties[i];
            double ignored;
            enum status status = STATUS_OK;
            if (property->indices) {
                status = read_polygon(ply, element, property, f, list, error);
            } else if (!(property->count_type ? skip_list(ply, property) : read_value(ply, property->type, &ignored))) {
                status = truncated(ply, element, f, error);
            }
            if (status != STATUS_OK) return status;
        }
    }
    return STATUS_OK;
}

static enum status read_elements(struct ply *ply, struct mesh *mesh, struct arena *arena, struct indices *list,
                                 struct error *error) {
    enum status status = STATUS_OK;
    for (int e = 0; e < ply->element_count && status == STATUS_OK; ++e) {
        const struct element *element = &ply->elements[e];
        bool vertices =
            strcmp(element->name, "vertex") == 0; // other elements are walked through as faces without indices
        status = vertices ? read_vertices(ply, element, mesh, arena, error) : read_faces(ply, element, list, error);
    }
    if (status != STATUS_OK) return status;
    mesh->triangle_count = list->count / 3;
    mesh->indices = arena_alloc(arena, list->count, sizeof *mesh->indices);
    if (!mesh->indices) return error_set(error, STATUS_MEMORY, "%s: out of memory", ply->path);
    if (list->count) memcpy(mesh->indices, list->values, list->count * sizeof *mesh->indices);
    return mesh_finish(mesh, arena, ply->path, error);
}

enum status mesh_parse_ply(struct mesh *mesh, struct arena *arena, const char *name, const uint8_t *bytes,
                           size_t length, struct error *error) {
    *mesh = (struct mesh){0};
    struct indices list = {0};
    struct ply *ply = calloc(1, sizeof *ply);
    if (!ply) return error_set(error, STATUS_MEMORY, "%s: out of memory", name);
    ply->path = name;
    ply->place = bytes;
    ply->end = bytes + length;
    enum status status = parse_header(ply, error);
    if (status == STATUS_OK) status = read_elements(ply, mesh, arena, &list, error);
    free(list.values);
    free(ply);
    return status;
}

enum status mesh_load_ply(struct mesh *mesh, struct arena *arena, const char *path, struct error *error) {
    uint8_t *bytes;
    size_t length;
    enum status status = file_read(path, &bytes, &length, error);
    if (status == STATUS_OK) status = mesh_parse_ply(mesh, arena, path, bytes, length, error);
    free(bytes);
    return status;
}
