// Shared by the tests of BSDFs and textures: makes a plugin from the text of a scene file, through the tables and the
// parameter reader, without the rest of the scene loader.
#pragma once

#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "scene/bsdf.h"
#include "scene/params.h"

struct xml_plugins { // zeroed: empty
    struct description description;
    struct arena arena;
};

static inline void xml_fail(const struct error *error) {
    fprintf(stderr, "%s\n", error->text);
    abort();
}

static inline enum status xml_make_texture(void *user, struct object *object, const struct texture **texture,
                                           struct error *error) {
    struct xml_plugins *plugins = user;
    struct texture_maker maker = {xml_make_texture, plugins};
    struct commit_context context = {.arena = &plugins->arena, .object = object};
    for (size_t i = 0; texture_table[i]; ++i) {
        const struct texture_type *type = texture_table[i];
        if (strcmp(type->name, object->type)) continue;
        struct texture *t = arena_alloc(&plugins->arena, 1, type->size);
        t->type = type;
        *texture = t;
        enum status status = params_read(t, type->params, NULL, object, &context, &maker, error);
        return status || !type->commit ? status : type->commit(t, &context, error);
    }
    return error_at(error, object->place, "no texture %s", object->type);
}

static inline enum status xml_make_bsdf(struct xml_plugins *plugins, struct object *object, const struct bsdf **bsdf,
                                        struct error *error) {
    struct texture_maker maker = {xml_make_texture, plugins};
    struct commit_context context = {.arena = &plugins->arena, .object = object};
    for (size_t i = 0; bsdf_table[i]; ++i) {
        const struct bsdf_type *type = bsdf_table[i];
        if (strcmp(type->name, object->type)) continue;
        struct bsdf *b = arena_alloc(&plugins->arena, 1, type->size);
        *b = (struct bsdf){.type = type, .flags = type->flags};
        *bsdf = b;
        enum status status = params_read(b, type->params, NULL, object, &context, &maker, error);
        const struct bsdf **children = (const struct bsdf **)(void *)((char *)b + type->children_offset);
        for (size_t c = 0; c < object->child_count && !status; ++c) {
            if (strcmp(object->children[c].object->tag, "bsdf")) continue;
            status = xml_make_bsdf(plugins, object->children[c].object, children++, error);
        }
        return status || !type->commit ? status : type->commit(b, &context, error);
    }
    return error_at(error, object->place, "no bsdf %s", object->type);
}

// The first plugin of a text such as <bsdf type="diffuse"/>; NULL with an error where it is wrong.
static inline const struct bsdf *xml_bsdf(struct xml_plugins *plugins, const char *text, struct error *error) {
    size_t size = strlen(text) + 64;
    char *scene = malloc(size);
    snprintf(scene, size, "<scene version=\"3.0.0\">%s</scene>", text);
    const struct bsdf *bsdf = NULL;
    enum status status = description_parse(&plugins->description, SOURCE_DIR "/tests/memory.xml", scene, strlen(scene),
                                           NULL, 0, NULL, error);
    free(scene);
    if (status == STATUS_OK) {
        status = xml_make_bsdf(plugins, plugins->description.root->children[0].object, &bsdf, error);
        if (status != STATUS_OK) description_fini(&plugins->description);
    }
    if (status != STATUS_OK) arena_fini(&plugins->arena);
    return status == STATUS_OK ? bsdf : NULL;
}

static inline void xml_fini(struct xml_plugins *plugins) {
    description_fini(&plugins->description);
    arena_fini(&plugins->arena);
}
