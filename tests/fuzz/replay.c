// Runs a fuzzer's entry point over every file of a corpus folder: the fuzzers' regression test in an ordinary build.
#include <dirent.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t length);

int main(int argc, char **argv) {
    DIR *folder = argc == 2 ? opendir(argv[1]) : NULL;
    if (!folder) return fprintf(stderr, "usage: %s CORPUS_FOLDER\n", argv[0]), 2;
    int count = 0;
    for (struct dirent *entry; (entry = readdir(folder));) {
        char path[4096];
        snprintf(path, sizeof path, "%s/%s", argv[1], entry->d_name);
        if (entry->d_name[0] == '.') continue;
        FILE *file = fopen(path, "rb");
        if (!file) return perror(path), 1;
        static uint8_t buffer[1 << 20];
        size_t length = fread(buffer, 1, sizeof buffer, file);
        fclose(file);
        uint8_t *exact = malloc(length ? length : 1); // so that the sanitizer sees one byte past the end
        for (size_t i = 0; i < length; i++) exact[i] = buffer[i];
        LLVMFuzzerTestOneInput(exact, length);
        free(exact);
        count++;
    }
    closedir(folder);
    printf("%d inputs replayed\n", count);
    return count ? 0 : 1;
}
