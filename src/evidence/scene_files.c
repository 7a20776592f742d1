// Follows the filenames of a scene's description, without making anything of them.
#include "evidence/scene_files.h"

#include <limits.h>
#include <string.h>
#include <sys/stat.h>

#include "base/file.h"
#include "base/hash.h"
#include "evidence/kept.h"

enum { MAX_DEPTH = 8 }; // of lamps within lamps

struct file_walk {
    struct scene_files *files;
    const struct definition *definitions;
    size_t definition_count;
    int depth;
};

static enum status add_scene(struct file_walk *walk, const char *path, struct error *error);

static enum status add_file(struct file_walk *walk, const char *path, struct error *error) {
    struct stat info;
    enum status status = kept_hash_file(&walk->files->hash, path, error);
    if (status) return status;
    if (!stat(path, &info)) walk->files->bytes += (size_t)info.st_size;
    const char *dot = strrchr(path, '.');
    return dot && !strcmp(dot, ".xml") ? add_scene(walk, path, error) : STATUS_OK;
}

static enum status add_object(struct file_walk *walk, const struct object *object, struct error *error) {
    enum status status = STATUS_OK;
    const struct property *name = object_property(object, "filename");
    if (name && name->string) {
        char path[PATH_MAX];
        path_resolve(path, sizeof path, object->place.file, name->string);
        status = add_file(walk, path, error);
    }
    for (size_t i = 0; !status && i < object->child_count; i++)
        status = add_object(walk, object->children[i].object, error);
    return status;
}

static enum status add_scene(struct file_walk *walk, const char *path, struct error *error) {
    if (++walk->depth > MAX_DEPTH) return error_set(error, STATUS_INVALID, "%s: lamps stand within each other", path);
    struct description description;
    enum status status = description_load(&description, path, walk->definitions, walk->definition_count, NULL, error);
    if (!status) {
        status = add_object(walk, description.root, error);
        description_fini(&description);
    }
    walk->depth--;
    return status;
}

enum status scene_files_measure(struct scene_files *files, const char *path, const struct definition *definitions,
                                size_t definition_count, struct error *error) {
    *files = (struct scene_files){.hash = HASH_START};
    struct file_walk walk = {files, definitions, definition_count, 0};
    return add_file(&walk, path, error);
}
