// A file from a format, for tests.
#pragma once

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

static void write_file(const char *path, const char *format, ...) __attribute__((format(printf, 2, 3)));
static void write_file(const char *path, const char *format, ...) {
    FILE *file = fopen(path, "w");
    if (!file) abort();
    va_list arguments;
    va_start(arguments, format);
    vfprintf(file, format, arguments);
    va_end(arguments);
    fclose(file);
}
