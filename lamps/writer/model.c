#include "model.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

static int write_file(const char *folder, const struct model_file *description) {
    char path[4096];
    int length = snprintf(path, sizeof path, "%s/%s", folder, description->name);
    FILE *file = length > 0 && (size_t)length < sizeof path ? fopen(path, "wb") : NULL;
    if (!file) {
        fprintf(stderr, "%s: cannot write %s/%s: %s\n", model.program, folder, description->name, strerror(errno));
        return 1;
    }
    bool failed = false;
    if (description->text) {
        description->text(file);
    } else if (description->texture) {
        failed = !texture_write(file, description->texture);
    } else {
        struct mesh_writer mesh;
        mesh_writer_init(&mesh, file, description->name);
        description->mesh(&mesh);
        mesh_writer_fini(&mesh);
        failed = mesh.failed;
    }
    failed |= ferror(file) != 0;
    if (fclose(file) == 0 && !failed) return 0;
    fprintf(stderr, "%s: writing %s failed; is the disk full?\n", model.program, path);
    return 1;
}

int main(int argc, char **argv) {
    if (argc != 2) {
        fprintf(stderr, "usage: %s FOLDER\n", model.program);
        return 2;
    }
    if (mkdir(argv[1], 0777) != 0 && errno != EEXIST) {
        fprintf(stderr, "%s: cannot create the folder %s: %s\n", model.program, argv[1], strerror(errno));
        return 1;
    }
    for (const struct model_file *file = model.files; file->name; file++)
        if (write_file(argv[1], file)) return 1;
    return 0;
}
