// A scene from text, for tests: written to a temporary file and loaded as the program does.
#pragma once

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "scene/scene.h"

static inline enum status scene_from_document(struct scene *scene, const char *xml, struct error *error) {
    char path[] = "/tmp/sconce_test_XXXXXX.xml";
    int file = mkstemps(path, 4);
    if (file < 0) abort();
    FILE *stream = fdopen(file, "w");
    fputs(xml, stream);
    fclose(stream);
    struct run run = {.threads = 1, .seed = 1};
    enum status status = scene_load(scene, path, NULL, &run, error);
    unlink(path);
    return status;
}

// `text`: what is inside <scene>.
static inline enum status scene_from_text(struct scene *scene, const char *text, struct error *error) {
    static const char format[] = "<scene version=\"3.0.0\">%s</scene>";
    size_t size = sizeof format + strlen(text);
    char *xml = malloc(size);
    if (!xml) abort();
    snprintf(xml, size, format, text);
    enum status status = scene_from_document(scene, xml, error);
    free(xml);
    return status;
}
