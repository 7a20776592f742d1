// The build tree has the rooms and the baked lamps in the sources and what the generators wrote beside the library; an
// installation has them all under share/sconce. CMake says how these folders lie relative to the library's.
#include "evidence/evidence_data.h"

#include <dlfcn.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

__attribute__((format(printf, 2, 3))) static void path_print(char path[PATH_MAX], const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    int length = vsnprintf(path, PATH_MAX, format, arguments);
    va_end(arguments);
    if (length >= PATH_MAX) path[0] = 0; // no such file exists
}

static bool folders_exist(const struct evidence_data *data) {
    return !access(data->rooms, R_OK) && !access(data->things, R_OK) && !access(data->lamps, R_OK);
}

static bool share_folder(struct evidence_data *data, const char *folder) {
    path_print(data->rooms, "%s/scenes", folder);
    path_print(data->things, "%s/scenes", folder);
    path_print(data->lamps, "%s/lamps", folder);
    path_print(data->baked, "%s/lamps/baked", folder);
    return folders_exist(data);
}

static bool build_tree(struct evidence_data *data, const char *library_folder) {
    char relative[PATH_MAX], sources[PATH_MAX];
    path_print(relative, "%s/" BUILD_TO_SOURCE, library_folder);
    if (!realpath(relative, sources)) return false;
    path_print(data->rooms, "%s/scenes", sources);
    path_print(data->things, "%s/scenes", library_folder);
    path_print(data->lamps, "%s/lamps", library_folder);
    path_print(data->baked, "%s/lamps/baked", sources);
    return folders_exist(data);
}

enum status evidence_data_find(struct evidence_data *data, const char *folder, struct error *error) {
    if (folder)
        return share_folder(data, folder) ? STATUS_OK
                                          : error_set(error, STATUS_IO,
                                                      "%s: has no folders scenes and lamps; name one that has, such "
                                                      "as share/sconce of an installation",
                                                      folder);
    Dl_info info;
    char library[PATH_MAX] = "", relative[PATH_MAX], shared[PATH_MAX];
    if (dladdr((const void *)(uintptr_t)evidence_data_find, &info) && info.dli_fname &&
        realpath(info.dli_fname, library))
        *strrchr(library, '/') = 0;
    if (build_tree(data, library)) return STATUS_OK;
    path_print(relative, "%s/" LIBRARY_TO_SHARE, library);
    if (realpath(relative, shared) && share_folder(data, shared)) return STATUS_OK;
    return error_set(error, STATUS_IO,
                     "%s: the project's rooms and lamps are not there; name the folder that holds scenes and lamps, "
                     "such as share/sconce of an installation",
                     relative);
}

void evidence_room(char *path, const struct evidence_data *data, const char *room) {
    path_print(path, "%s/%s.xml", data->rooms, room);
}
void evidence_thing(char *path, const struct evidence_data *data, const char *thing) {
    path_print(path, "%s/%s", data->things, thing);
}
void evidence_lamp(char *path, const struct evidence_data *data, const char *lamp) {
    path_print(path, "%s/%s/%s.xml", data->lamps, lamp, lamp);
}
void evidence_baked(char *path, const struct evidence_data *data, const char *lamp) {
    path_print(path, "%s/%s.safetensors", data->baked, lamp);
}

enum status evidence_baked_check(char *path, const struct evidence_data *data, const char *lamp, struct error *error) {
    evidence_baked(path, data, lamp);
    if (!access(path, R_OK)) return STATUS_OK;
    return error_set(error, STATUS_IO, "%s is missing; lamps/bake_all.sh %s of the sources bakes it", path, lamp);
}
