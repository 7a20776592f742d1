// Whole files, and what a write that fails half-way leaves behind.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <dirent.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>
#include <cmocka.h>

#include "base/file.h"

static char folder[64];

static const char *in_folder(const char *name) {
    static char path[128];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    return path;
}

static int count_files(void) {
    int count = 0;
    DIR *dir = opendir(folder);
    assert_non_null(dir);
    for (struct dirent *entry = readdir(dir); entry; entry = readdir(dir)) count += entry->d_name[0] != '.';
    closedir(dir);
    return count;
}

static int make_folder(void **state) {
    (void)state;
    strcpy(folder, "/tmp/sconce_test_file_XXXXXX");
    return mkdtemp(folder) ? 0 : 1;
}

static int remove_folder(void **state) {
    (void)state;
    remove(in_folder("a"));
    return rmdir(folder);
}

static void test_folders(void **state) {
    (void)state;
    char deep[160], below[200];
    struct error error;
    snprintf(deep, sizeof deep, "%s/x/y", folder);
    snprintf(below, sizeof below, "%s/x/y/file/z", folder);
    assert_int_equal(folder_make(deep, NULL), STATUS_OK);
    assert_int_equal(folder_make(deep, NULL), STATUS_OK); // already there
    below[strlen(below) - 2] = 0;
    assert_int_equal(file_write_atomic(below, "", 0, NULL), STATUS_OK);
    below[strlen(below)] = '/';
    assert_int_equal(folder_make(below, &error), STATUS_IO);
    assert_non_null(strstr(error.text, "cannot be made"));
    below[strlen(below) - 2] = 0;
    remove(below);
    rmdir(deep);
    rmdir(in_folder("x"));
}

static void test_round_trip(void **state) {
    (void)state;
    uint8_t *bytes;
    size_t length;
    const size_t sizes[] = {0, 1, 65535, 65536, 300001};
    for (int i = 0; i < 5; ++i) {
        uint8_t *data = malloc(sizes[i] + 1);
        assert_non_null(data);
        for (size_t j = 0; j < sizes[i]; ++j) data[j] = (uint8_t)(j * 7 + 3);
        assert_int_equal(file_write_atomic(in_folder("a"), data, sizes[i], NULL), STATUS_OK);
        assert_int_equal(file_read(in_folder("a"), &bytes, &length, NULL), STATUS_OK);
        assert_int_equal(length, sizes[i]);
        assert_memory_equal(bytes, data, length);
        assert_int_equal(bytes[length], 0);
        free(bytes);
        free(data);
    }
    assert_int_equal(count_files(), 1);
    struct stat info;
    mode_t mask = umask(0);
    umask(mask);
    assert_int_equal(stat(in_folder("a"), &info), 0);
    assert_int_equal(info.st_mode & 0777, 0666 & ~mask);
    // A file without a size in its entry is still read to its end.
    assert_int_equal(file_read("/proc/self/maps", &bytes, &length, NULL), STATUS_OK);
    assert_true(length > 100 && strlen((char *)bytes) == length);
    free(bytes);
}

static void test_errors(void **state) {
    (void)state;
    struct error error;
    uint8_t *bytes;
    size_t length;
    assert_int_equal(file_read(in_folder("missing"), &bytes, &length, &error), STATUS_IO);
    assert_non_null(strstr(error.text, "missing"));
    assert_int_equal(file_read(folder, &bytes, &length, &error), STATUS_IO);
    assert_int_equal(file_write_atomic(in_folder("none/a"), "x", 1, &error), STATUS_IO);
    assert_int_equal(file_write_atomic(folder, "x", 1, &error), STATUS_IO); // the target is a folder
    char long_name[5000];
    memset(long_name, 'x', sizeof long_name);
    long_name[sizeof long_name - 1] = 0;
    assert_int_equal(file_write_atomic(long_name, "x", 1, &error), STATUS_INVALID);
}

// A file size limit fails a write in its middle, as a full disk does.
static void test_full_disk(void **state) {
    (void)state;
    static uint8_t large[1 << 20];
    assert_int_equal(file_write_atomic(in_folder("a"), "old", 3, NULL), STATUS_OK);
    struct rlimit limit, small;
    getrlimit(RLIMIT_FSIZE, &limit);
    small = limit;
    small.rlim_cur = 100000;
    signal(SIGXFSZ, SIG_IGN);
    setrlimit(RLIMIT_FSIZE, &small);
    struct error error;
    enum status status = file_write_atomic(in_folder("a"), large, sizeof large, &error);
    setrlimit(RLIMIT_FSIZE, &limit);
    assert_int_equal(status, STATUS_IO);
    uint8_t *bytes;
    size_t length;
    assert_int_equal(file_read(in_folder("a"), &bytes, &length, NULL), STATUS_OK);
    assert_int_equal(length, 3);
    assert_memory_equal(bytes, "old", 3);
    free(bytes);
    assert_int_equal(count_files(), 1);
}

static void test_resolve(void **state) {
    (void)state;
    char path[32];
    path_resolve(path, sizeof path, "scenes/room.xml", "mesh/a.obj");
    assert_string_equal(path, "scenes/mesh/a.obj");
    path_resolve(path, sizeof path, "room.xml", "a.obj");
    assert_string_equal(path, "a.obj");
    path_resolve(path, sizeof path, "/x/room.xml", "/abs/a.obj");
    assert_string_equal(path, "/abs/a.obj");
    path_resolve(path, 8, "scenes/room.xml", "a.obj");
    assert_string_equal(path, "scenes/");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_folders),   cmocka_unit_test(test_round_trip), cmocka_unit_test(test_errors),
        cmocka_unit_test(test_full_disk), cmocka_unit_test(test_resolve),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
