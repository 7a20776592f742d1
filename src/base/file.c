// Whole files in and out. Every output of the project goes through file_write_atomic: the bytes are written to a new
// file in the target's folder, flushed to the disk and renamed, so that a full disk or a crash leaves the old file (or
// none) and never half a new one.
#include "base/file.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static enum status read_all(int fd, const char *path, uint8_t **bytes, size_t *length, struct error *error) {
    struct stat info;
    if (fstat(fd, &info) != 0) return error_set(error, STATUS_IO, "%s: cannot be read: %s", path, strerror(errno));
    size_t capacity = info.st_size > 0 ? (size_t)info.st_size + 1 : 65536, used = 0;
    uint8_t *buffer = malloc(capacity);
    for (;;) {
        if (!buffer) return error_set(error, STATUS_MEMORY, "%s: out of memory after %zu bytes", path, used);
        // The last byte of the buffer is kept for the terminating zero.
        ssize_t got = read(fd, buffer + used, capacity - 1 - used);
        if (got < 0 && errno == EINTR) continue;
        if (got < 0) {
            enum status status = error_set(error, STATUS_IO, "%s: cannot be read: %s", path, strerror(errno));
            free(buffer);
            return status;
        }
        used += (size_t)got;
        if (got == 0 && used < capacity - 1) break;
        if (used < capacity - 1) continue;
        uint8_t probe; // full: at the end of the file already?
        ssize_t more = read(fd, &probe, 1);
        if (more == 0) break;
        if (more < 0) continue;
        uint8_t *larger = capacity < SIZE_MAX / 2 ? realloc(buffer, capacity * 2) : NULL;
        if (!larger) free(buffer);
        buffer = larger;
        capacity *= 2;
        if (buffer) buffer[used++] = probe;
    }
    buffer[used] = 0;
    *bytes = buffer;
    *length = used;
    return STATUS_OK;
}

enum status file_read(const char *path, uint8_t **bytes, size_t *length, struct error *error) {
    *bytes = NULL;
    *length = 0;
    int fd = open(path, O_RDONLY | O_CLOEXEC);
    if (fd < 0) return error_set(error, STATUS_IO, "%s: cannot be opened: %s", path, strerror(errno));
    enum status status = read_all(fd, path, bytes, length, error);
    close(fd);
    return status;
}

static bool write_all(int fd, const uint8_t *bytes, size_t length) {
    while (length > 0) {
        ssize_t put = write(fd, bytes, length < 1 << 30 ? length : 1 << 30);
        if (put < 0 && errno == EINTR) continue;
        if (put <= 0) return false;
        bytes += put;
        length -= (size_t)put;
    }
    return true;
}

enum status file_write_atomic(const char *path, const void *bytes, size_t length, struct error *error) {
    char beside[PATH_MAX];
    int fd = -1;
    for (int attempt = 0; attempt < 1000 && fd < 0; ++attempt) {
        int size = snprintf(beside, sizeof beside, "%s.part-%ld-%d", path, (long)getpid(), attempt);
        if (size < 0 || (size_t)size >= sizeof beside)
            return error_set(error, STATUS_INVALID, "%s: the path is too long", path);
        fd = open(beside, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
        if (fd < 0 && errno != EEXIST) break;
    }
    if (fd < 0) return error_set(error, STATUS_IO, "%s: cannot be written: %s", path, strerror(errno));
    bool written = write_all(fd, bytes, length) && fsync(fd) == 0;
    int reason = errno;
    if (close(fd) != 0 && written) {
        written = false;
        reason = errno;
    }
    if (written && rename(beside, path) != 0) {
        written = false;
        reason = errno;
    }
    if (written) return STATUS_OK;
    unlink(beside);
    return error_set(error, STATUS_IO, "%s: cannot be written: %s; nothing was left behind", path, strerror(reason));
}

enum status folder_make(const char *path, struct error *error) {
    char part[PATH_MAX];
    if ((size_t)snprintf(part, sizeof part, "%s", path) >= sizeof part)
        return error_set(error, STATUS_INVALID, "%s: the path is too long", path);
    for (char *slash = strchr(part + 1, '/');; slash = strchr(slash + 1, '/')) {
        if (slash) *slash = 0;
        if (mkdir(part, 0777) != 0 && errno != EEXIST)
            return error_set(error, STATUS_IO, "the folder %s cannot be made: %s", part, strerror(errno));
        if (!slash) return STATUS_OK;
        *slash = '/';
    }
}

void path_resolve(char *result, size_t size, const char *base_file, const char *name) {
    const char *slash = strrchr(base_file, '/');
    int folder = slash && name[0] != '/' ? (int)(slash - base_file + 1) : 0;
    snprintf(result, size, "%.*s%s", folder, base_file, name);
    if (folder && access(result, F_OK) != 0 && access(name, F_OK) == 0) snprintf(result, size, "%s", name);
}
