// References to objects, after all files are read, so that an id may stand before or after its uses and in an included
// file. What remains is a directed graph without cycles, at most DESCRIPTION_MAX_DEPTH deep.
#include "format/description_private.h"

#include <stdlib.h>
#include <string.h>

struct resolver {
    const struct identifier **sorted; // by id
    size_t count;
    struct error *error;
};

static int compare_identifiers(const void *a, const void *b) {
    const struct identifier *const *x = a, *const *y = b;
    int order = strcmp((*x)->id, (*y)->id);
    if (order) return order;
    if ((*x)->place.line != (*y)->place.line) return (*x)->place.line < (*y)->place.line ? -1 : 1;
    return ((*x)->place.column > (*y)->place.column) - ((*x)->place.column < (*y)->place.column);
}

static const struct identifier *identifier_find(const struct resolver *resolver, const char *id) {
    size_t low = 0, high = resolver->count;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        int order = strcmp(resolver->sorted[middle]->id, id);
        if (!order) return resolver->sorted[middle];
        if (order < 0)
            low = middle + 1;
        else
            high = middle;
    }
    return NULL;
}

static enum status unknown_id(const struct resolver *resolver, const char *id, struct place place) {
    const char **names = malloc((resolver->count + 1) * sizeof *names);
    const char *near = NULL;
    if (names) {
        for (size_t i = 0; i < resolver->count; i++) names[i] = resolver->sorted[i]->id;
        near = nearest_name(id, names, resolver->count);
    }
    free(names);
    if (near) return error_at(resolver->error, place, "nothing has the id '%s'; did you mean '%s'?", id, near);
    return error_at(resolver->error, place, "nothing has the id '%s'; give it to the object that is meant", id);
}

static enum status reference_target(const struct resolver *resolver, const char *id, struct place place,
                                    struct object **object) {
    for (int depth = 0; depth < DESCRIPTION_MAX_DEPTH; depth++) {
        const struct identifier *found = identifier_find(resolver, id);
        if (!found) return unknown_id(resolver, id, place);
        if (!found->alias_of) {
            *object = found->object;
            return STATUS_OK;
        }
        id = found->alias_of;
    }
    return error_at(resolver->error, place, "the alias '%s' leads back to itself, or through too many others", id);
}

// `instance` holds the marks of the depth-first search and is cleared again: open (on the path), or the height + 1.
static char open_mark;
static const char height_marks[DESCRIPTION_MAX_DEPTH + 2];

static enum status object_height(const struct resolver *resolver, struct object *object, int depth, int *height) {
    object->instance = &open_mark;
    *height = 0;
    for (size_t i = 0; i < object->child_count; i++) {
        struct object_child *child = &object->children[i];
        int child_height = 0;
        if (child->object->instance == &open_mark)
            return error_at(resolver->error, child->place, "this reference to '%s' stands inside that object itself",
                            child->object->id);
        enum status status = STATUS_OK;
        if (child->object->instance)
            child_height = (int)((const char *)child->object->instance - height_marks);
        else if (depth < DESCRIPTION_MAX_DEPTH)
            status = object_height(resolver, child->object, depth + 1, &child_height);
        if (status) return status;
        if (child_height + 1 > *height) *height = child_height + 1;
        if (depth >= DESCRIPTION_MAX_DEPTH || *height > DESCRIPTION_MAX_DEPTH)
            return error_at(resolver->error, child->place, "objects stand within each other more than %d deep",
                            (int)DESCRIPTION_MAX_DEPTH);
    }
    object->instance = (void *)(uintptr_t)&height_marks[*height];
    return STATUS_OK;
}

static void object_clear(struct object *object) {
    object->instance = NULL;
    for (size_t i = 0; i < object->child_count; i++)
        if (object->children[i].object->instance) object_clear(object->children[i].object);
}

enum status references_resolve(struct object *root, struct reference *references, struct identifier *identifiers,
                               struct error *error) {
    struct resolver resolver = {.error = error};
    for (const struct identifier *i = identifiers; i; i = i->next) resolver.count++;
    resolver.sorted = malloc((resolver.count + 1) * sizeof *resolver.sorted);
    if (!resolver.sorted) return error_set(error, STATUS_MEMORY, "out of memory for %zu ids", resolver.count);
    size_t n = 0;
    for (const struct identifier *i = identifiers; i; i = i->next) resolver.sorted[n++] = i;
    qsort(resolver.sorted, n, sizeof *resolver.sorted, compare_identifiers);
    enum status status = STATUS_OK;
    for (size_t i = 1; i < n && !status; i++)
        if (!strcmp(resolver.sorted[i]->id, resolver.sorted[i - 1]->id))
            status = error_at(error, resolver.sorted[i]->place, "the id '%s' is taken at %s:%d:%d",
                              resolver.sorted[i]->id, resolver.sorted[i - 1]->place.file,
                              resolver.sorted[i - 1]->place.line, resolver.sorted[i - 1]->place.column);
    for (struct reference *r = references; r && !status; r = r->next)
        status = reference_target(&resolver, r->id, r->place, &r->child->object);
    int height;
    if (!status) status = object_height(&resolver, root, 0, &height);
    if (!status) object_clear(root);
    free(resolver.sorted);
    return status;
}
