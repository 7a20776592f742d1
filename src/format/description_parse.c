// Mitsuba XML to a tree of objects, by expat (which only this file knows). One pass over the elements: defaults and
// $names are replaced in attributes, includes are read where they stand, transforms are multiplied up; references are
// collected and resolved afterwards (description_resolve.c). Columns count bytes from 1.
#include "format/description_private.h"

#include <ctype.h>
#include <expat.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "base/file.h"
#include "base/param.h"

static const char *const object_tags[] = {"scene",      "shape", "bsdf",    "texture",   "emitter",
                                          "sensor",     "film",  "sampler", "rfilter",   "medium",
                                          "integrator", "phase", "volume",  "subsurface"};
static const char *const transform_tags[] = {"translate", "scale", "rotate", "lookat", "matrix"};
enum {
    OBJECT_TAG_COUNT = sizeof object_tags / sizeof *object_tags,
    TRANSFORM_TAG_COUNT = sizeof transform_tags / sizeof *transform_tags
};

static const char *const other_tags[] = {"default", "include", "ref", "alias", "path"};
enum { OTHER_TAG_COUNT = sizeof other_tags / sizeof *other_tags };

struct property_node {
    struct property_node *next;
    struct property property;
};
struct child_node {
    struct child_node *next;
    struct object_child child;
    struct reference *reference;
};

enum element_kind {
    ELEMENT_OBJECT,
    ELEMENT_SPECTRUM, // <spectrum type="..."> with its parameters inside: an object until it ends, then a property
    ELEMENT_INCLUDED_SCENE,
    ELEMENT_TRANSFORM,
    ELEMENT_LEAF
};
struct element { // an open element
    enum element_kind kind;
    struct object *object;
    struct property_node *properties, **properties_end;
    struct child_node *children, **children_end;
    struct property *property; // of transforms and spectra
};
struct source { // an open file
    const struct source *includer;
    const char *path;
    XML_Parser xml;
    int depth_at_start;
};
struct parse {
    struct arena *arena;
    const struct run *run;
    struct error *error;
    enum status status;
    struct object *root;
    struct source *source;
    struct named_value *values;
    struct reference *references;
    struct identifier *identifiers;
    struct element *elements; // the open ones, outermost first
    int depth;
};

static enum status parse_source(struct parse *parse, const char *path, const char *text, size_t length);

static struct place place_here(const struct parse *parse) {
    return (struct place){parse->source->path, (int)XML_GetCurrentLineNumber(parse->source->xml),
                          (int)XML_GetCurrentColumnNumber(parse->source->xml) + 1};
}

static void parse_stop(struct parse *parse, enum status status) {
    if (!status || parse->status) return;
    parse->status = status;
    XML_StopParser(parse->source->xml, XML_FALSE);
}

static enum status out_of_memory(const struct parse *parse) {
    return error_set(parse->error, STATUS_MEMORY, "%s: out of memory while reading the scene", parse->source->path);
}

// ---- The stack of open elements ----

static struct element *element_top(struct parse *parse) {
    return parse->depth ? &parse->elements[parse->depth - 1] : NULL;
}

static enum status element_push(struct parse *parse, enum element_kind kind, struct object *object) {
    if (parse->depth == DESCRIPTION_MAX_DEPTH)
        return error_at(parse->error, place_here(parse), "elements stand within each other more than %d deep",
                        (int)DESCRIPTION_MAX_DEPTH);
    struct element *element = &parse->elements[parse->depth++];
    *element = (struct element){.kind = kind, .object = object};
    element->properties_end = &element->properties;
    element->children_end = &element->children;
    return STATUS_OK;
}

// The object that a new child or property belongs to: an included <scene> adds to the scene that includes it.
static struct element *element_owner(struct parse *parse) {
    int i = parse->depth - 1;
    while (i > 0 && parse->elements[i].kind == ELEMENT_INCLUDED_SCENE) i--;
    return i >= 0 ? &parse->elements[i] : NULL;
}

static enum status child_add(struct parse *parse, const char *name, struct object *object, const char *reference_id) {
    struct element *owner = element_owner(parse);
    struct child_node *node = arena_alloc(parse->arena, 1, sizeof *node);
    if (!node) return out_of_memory(parse);
    node->child = (struct object_child){name ? name : "", object, place_here(parse)};
    if (reference_id) {
        struct reference *reference = arena_alloc(parse->arena, 1, sizeof *reference);
        if (!reference) return out_of_memory(parse);
        *reference = (struct reference){parse->references, reference_id, place_here(parse), NULL};
        parse->references = node->reference = reference;
    }
    *owner->children_end = node;
    owner->children_end = &node->next;
    owner->object->child_count++;
    return STATUS_OK;
}

static enum status identifier_add(struct parse *parse, const char *id, const char *alias_of, struct object *object) {
    struct identifier *identifier = arena_alloc(parse->arena, 1, sizeof *identifier);
    if (!identifier) return out_of_memory(parse);
    *identifier = (struct identifier){parse->identifiers, id, alias_of, place_here(parse), object};
    parse->identifiers = identifier;
    return STATUS_OK;
}

static enum status value_add(struct parse *parse, const char *name, const char *text) {
    struct named_value *value = arena_alloc(parse->arena, 1, sizeof *value);
    if (!value) return out_of_memory(parse);
    *value = (struct named_value){parse->values, name, text, NULL};
    parse->values = value;
    return STATUS_OK;
}

static enum status element_attributes(struct parse *parse, const char *tag, const char *const *raw,
                                      const char *const *known, size_t known_count, const char **attributes) {
    return attributes_take(parse->arena, parse->values, tag, place_here(parse), raw, known, known_count, attributes,
                           parse->error);
}

static enum status object_finish(struct parse *parse, struct element *element) {
    struct object *object = element->object;
    object->properties = arena_alloc(parse->arena, object->property_count, sizeof *object->properties);
    object->children = arena_alloc(parse->arena, object->child_count, sizeof *object->children);
    if (!object->properties || !object->children) return out_of_memory(parse);
    size_t n = 0;
    for (const struct property_node *node = element->properties; node; node = node->next)
        object->properties[n++] = node->property;
    n = 0;
    for (const struct child_node *node = element->children; node; node = node->next) {
        object->children[n] = node->child;
        if (node->reference) node->reference->child = &object->children[n];
        n++;
    }
    return STATUS_OK;
}

// ---- Elements ----

static enum status object_begin(struct parse *parse, const char *tag, const char *const *raw) {
    static const char *const known[] = {"type", "id", "name", "version"};
    bool is_scene = !strcmp(tag, "scene");
    const char *a[ATTRIBUTES_CAPACITY];
    enum status status = element_attributes(parse, tag, raw, known, is_scene ? 4 : 3, a);
    if (status) return status;
    if (is_scene && parse->depth != parse->source->depth_at_start)
        return error_at(parse->error, place_here(parse), "<scene> may only be the outermost element");
    if (is_scene && parse->source->includer) return element_push(parse, ELEMENT_INCLUDED_SCENE, NULL);
    const char *type = attribute_value(a, "type"), *id = attribute_value(a, "id");
    if (element_top(parse) && element_top(parse)->kind == ELEMENT_SPECTRUM)
        return error_at(parse->error, place_here(parse), "<%s> has no meaning inside a <spectrum>", tag);
    if (!is_scene && (!type || !*type))
        return error_at(parse->error, place_here(parse), "<%s> needs the attribute type", tag);
    struct object *object = arena_alloc(parse->arena, 1, sizeof *object);
    if (!object) return out_of_memory(parse);
    *object = (struct object){.tag = tag, .type = type ? type : "", .id = id ? id : "", .place = place_here(parse)};
    if (*object->id) status = identifier_add(parse, id, NULL, object);
    if (!status && is_scene)
        parse->root = object;
    else if (!status)
        status = child_add(parse, attribute_value(a, "name"), object, NULL);
    return status ? status : element_push(parse, ELEMENT_OBJECT, object);
}

static enum status property_begin(struct parse *parse, const struct property_tag *tag, const char *const *raw) {
    const char *known[8] = {"name", "id"}, *a[ATTRIBUTES_CAPACITY];
    size_t known_count = 2;
    for (; known_count < 7 && tag->attributes[known_count - 2]; known_count++)
        known[known_count] = tag->attributes[known_count - 2];
    enum status status = element_attributes(parse, tag->tag, raw, known, known_count, a);
    if (status) return status;
    struct element *owner = element_owner(parse);
    struct place place = place_here(parse);
    const char *name = attribute_value(a, "name");
    if (!owner || (owner->kind != ELEMENT_OBJECT && owner->kind != ELEMENT_SPECTRUM))
        return error_at(parse->error, place, "<%s> must stand inside an object", tag->tag);
    if (!name || !*name) return error_at(parse->error, place, "<%s> needs the attribute name", tag->tag);
    for (const struct property_node *p = owner->properties; p; p = p->next)
        if (param_name_equal(p->property.name, name))
            return error_at(parse->error, place, "'%s' is given already at line %d", name, p->property.place.line);
    struct property_node *node = arena_alloc(parse->arena, 1, sizeof *node);
    if (!node) return out_of_memory(parse);
    node->property = (struct property){.name = name, .place = place};
    const char *type = attribute_value(a, "type");
    if (!type) status = property_set(parse->arena, tag, a, &node->property, parse->error);
    if (status) return status;
    *owner->properties_end = node;
    owner->properties_end = &node->next;
    owner->object->property_count++;
    struct object *spectrum = type ? arena_alloc(parse->arena, 1, sizeof *spectrum) : NULL;
    if (type && !spectrum) return out_of_memory(parse);
    if (spectrum) *spectrum = (struct object){.tag = tag->tag, .type = type, .id = "", .place = place};
    status = element_push(parse,
                          spectrum                          ? ELEMENT_SPECTRUM
                          : tag->type == PROPERTY_TRANSFORM ? ELEMENT_TRANSFORM
                                                            : ELEMENT_LEAF,
                          spectrum);
    if (!status) element_top(parse)->property = &node->property;
    return status;
}

static enum status include_file(struct parse *parse, const char *filename) {
    char path[PATH_MAX], real[PATH_MAX];
    path_resolve(path, sizeof path, parse->source->path, filename);
    struct stat info;
    if (stat(path, &info) != 0 || !S_ISREG(info.st_mode) || !realpath(path, real)) {
        struct place place = place_here(parse);
        return error_set(parse->error, STATUS_IO, "%s:%d:%d: the included file '%s' cannot be read", place.file,
                         place.line, place.column, path);
    }
    for (const struct source *s = parse->source; s; s = s->includer) {
        char open_real[PATH_MAX];
        if (realpath(s->path, open_real) && !strcmp(open_real, real))
            return error_at(parse->error, place_here(parse), "'%s' includes itself", path);
    }
    uint8_t *bytes;
    size_t length;
    enum status status = file_read(path, &bytes, &length, parse->error);
    if (status) return status;
    status = parse_source(parse, path, (const char *)bytes, length);
    free(bytes);
    return status;
}

static enum status other_begin(struct parse *parse, const char *tag, const char *const *raw) {
    static const char *const known[] = {"name", "value", "filename", "id", "as"};
    const char *a[ATTRIBUTES_CAPACITY];
    struct place place = place_here(parse);
    enum status status = element_attributes(parse, tag, raw, known, 5, a);
    if (status) return status;
    struct element *owner = element_owner(parse);
    if (!owner || owner->kind != ELEMENT_OBJECT)
        return error_at(parse->error, place, "<%s> must stand inside <scene>", tag);
    const char *name = attribute_value(a, "name"), *value = attribute_value(a, "value"), *id = attribute_value(a, "id");
    const char *filename = attribute_value(a, "filename"), *as = attribute_value(a, "as");
    if (!strcmp(tag, "default")) {
        if (!name || !*name || !value)
            return error_at(parse->error, place, "<default> needs the attributes name and value");
        if (!named_value_find(parse->values, name, strlen(name))) status = value_add(parse, name, value);
    } else if (!strcmp(tag, "ref")) {
        if (!id || !*id) return error_at(parse->error, place, "<ref> needs the attribute id");
        status = child_add(parse, name, NULL, id);
    } else if (!strcmp(tag, "alias")) {
        if (!id || !*id || !as || !*as) return error_at(parse->error, place, "<alias> needs the attributes id and as");
        status = identifier_add(parse, as, id, NULL);
    } else if (!strcmp(tag, "include")) {
        if (!filename || owner->object != parse->root)
            return error_at(parse->error, place,
                            "<include> needs the attribute filename and stands directly in <scene>");
        status = include_file(parse, filename);
    } else {
        run_note(parse->run, "%s:%d:%d: <path> is ignored: file names are relative to the file that holds them",
                 place.file, place.line, place.column);
    }
    return status ? status : element_push(parse, ELEMENT_LEAF, NULL);
}

static const char *tag_find(const char *tag, const char *const *tags, size_t n) {
    for (size_t i = 0; i < n; i++)
        if (param_name_equal(tags[i], tag)) return tags[i];
    return NULL;
}

static enum status unknown_tag(struct parse *parse, const char *tag) {
    const char *all[OBJECT_TAG_COUNT + OTHER_TAG_COUNT + TRANSFORM_TAG_COUNT + 16];
    size_t n = 0;
    for (size_t i = 0; i < OBJECT_TAG_COUNT; i++) all[n++] = object_tags[i];
    for (size_t i = 0; property_tags[i].tag; i++) all[n++] = property_tags[i].tag;
    for (size_t i = 0; i < OTHER_TAG_COUNT; i++) all[n++] = other_tags[i];
    for (size_t i = 0; i < TRANSFORM_TAG_COUNT; i++) all[n++] = transform_tags[i];
    const char *near = nearest_name(tag, all, n);
    if (near)
        return error_at(parse->error, place_here(parse), "unknown element <%.60s>; did you mean <%s>?", tag, near);
    return error_at(parse->error, place_here(parse), "unknown element <%.60s>", tag);
}

static enum status element_begin(struct parse *parse, const char *tag, const char *const *raw) {
    struct element *top = element_top(parse);
    const char *found;
    if (strcmp(tag, "scene") && parse->depth == parse->source->depth_at_start)
        return error_at(parse->error, place_here(parse), "the outermost element must be <scene>, not <%.60s>", tag);
    if (top && top->kind == ELEMENT_LEAF)
        return error_at(parse->error, place_here(parse), "<%.60s> stands inside an element that can hold nothing", tag);
    if ((found = tag_find(tag, transform_tags, TRANSFORM_TAG_COUNT))) {
        static const char *const known[] = {"value", "x", "y", "z", "angle", "origin", "target", "up"};
        const char *a[ATTRIBUTES_CAPACITY];
        if (!top || top->kind != ELEMENT_TRANSFORM)
            return error_at(parse->error, place_here(parse), "<%.60s> must stand inside a <transform>", tag);
        enum status status = element_attributes(parse, found, raw, known, sizeof known / sizeof *known, a);
        if (!status)
            status = transform_apply_element(found, a, place_here(parse), &top->property->transform, parse->error);
        return status ? status : element_push(parse, ELEMENT_LEAF, NULL);
    }
    if (top && top->kind == ELEMENT_TRANSFORM)
        return error_at(parse->error, place_here(parse), "<%.60s> is no operation of a <transform>", tag);
    if (!strcmp(tag, "camera")) tag = "sensor"; // as written before Mitsuba 0.4
    if ((found = tag_find(tag, object_tags, OBJECT_TAG_COUNT))) return object_begin(parse, found, raw);
    for (size_t i = 0; property_tags[i].tag; i++)
        if (!strcmp(tag, property_tags[i].tag)) return property_begin(parse, &property_tags[i], raw);
    if ((found = tag_find(tag, other_tags, OTHER_TAG_COUNT))) return other_begin(parse, found, raw);
    return unknown_tag(parse, tag);
}

static void on_start(void *user, const XML_Char *tag, const XML_Char **attributes) {
    struct parse *parse = user;
    if (!parse->status) parse_stop(parse, element_begin(parse, tag, (const char *const *)attributes));
}

static void on_end(void *user, const XML_Char *tag) {
    struct parse *parse = user;
    (void)tag;
    if (parse->status || !parse->depth) return;
    struct element *element = element_top(parse);
    bool is_spectrum = element->kind == ELEMENT_SPECTRUM;
    if (element->kind == ELEMENT_OBJECT || is_spectrum) parse_stop(parse, object_finish(parse, element));
    if (is_spectrum && !parse->status)
        parse_stop(parse, property_set_spectrum(parse->arena, element->object, element->property, parse->error));
    parse->depth--;
}

static void on_text(void *user, const XML_Char *text, int length) {
    struct parse *parse = user;
    for (int i = 0; i < length && !parse->status; i++)
        if (!isspace((unsigned char)text[i]))
            parse_stop(parse,
                       error_at(parse->error, place_here(parse), "text '%.*s' outside of elements and attributes",
                                length - i < 40 ? length - i : 40, text + i));
}

static enum status parse_source(struct parse *parse, const char *path, const char *text, size_t length) {
    if (length > INT_MAX) return error_set(parse->error, STATUS_INVALID, "%s: is too large", path);
    struct source source = {parse->source, arena_strdup(parse->arena, path), XML_ParserCreate(NULL), parse->depth};
    if (!source.xml || !source.path) {
        if (source.xml) XML_ParserFree(source.xml);
        return error_set(parse->error, STATUS_MEMORY, "%s: out of memory while reading the scene", path);
    }
    parse->source = &source;
    XML_SetUserData(source.xml, parse);
    XML_SetElementHandler(source.xml, on_start, on_end);
    XML_SetCharacterDataHandler(source.xml, on_text);
    if (XML_Parse(source.xml, text, (int)length, 1) != XML_STATUS_OK && !parse->status) {
        enum XML_Error code = XML_GetErrorCode(source.xml);
        parse->status = error_at(parse->error, place_here(parse), "malformed XML: %s", XML_ErrorString(code));
        if (code == XML_ERROR_NO_MEMORY) parse->status = out_of_memory(parse);
    }
    XML_ParserFree(source.xml);
    parse->source = (struct source *)(uintptr_t)source.includer;
    return parse->status;
}

enum status description_parse(struct description *description, const char *path, const char *text, size_t length,
                              const struct definition *definitions, size_t definition_count, const struct run *run,
                              struct error *error) {
    *description = (struct description){0};
    struct element elements[DESCRIPTION_MAX_DEPTH];
    struct parse parse = {.arena = &description->arena, .run = run, .error = error, .elements = elements};
    bool *used = arena_alloc(parse.arena, definition_count + 1, sizeof *used);
    description->definition_used = used;
    for (size_t i = 0; i < definition_count; i++) {
        struct named_value *value = arena_alloc(parse.arena, 1, sizeof *value);
        char *name = arena_strdup(parse.arena, definitions[i].name),
             *copy = arena_strdup(parse.arena, definitions[i].value);
        if (!used || !value || !name || !copy) {
            description_fini(description);
            return error_set(error, STATUS_MEMORY, "out of memory for the definitions");
        }
        *value = (struct named_value){parse.values, name, copy, &used[i]};
        parse.values = value; // the last of two definitions of a name counts
    }
    enum status status = parse_source(&parse, path, text, length);
    if (!status) status = references_resolve(parse.root, parse.references, parse.identifiers, error);
    if (status) {
        description_fini(description);
        return status;
    }
    description->root = parse.root;
    return STATUS_OK;
}

enum status description_load(struct description *description, const char *path, const struct definition *definitions,
                             size_t definition_count, const struct run *run, struct error *error) {
    uint8_t *bytes;
    size_t length;
    enum status status = file_read(path, &bytes, &length, error);
    if (status) return status;
    status =
        description_parse(description, path, (const char *)bytes, length, definitions, definition_count, run, error);
    free(bytes);
    return status;
}
