// Checkpoints of a bake; see checkpoint.h for why a crash cannot break them.
#include "bake/checkpoint.h"

#include <errno.h>
#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/file.h"

enum { PATH_SIZE = 4096 };
static const char *const network_names[2] = {"light_field", "transparency"};

static void state_path(char *path, const char *folder) { snprintf(path, PATH_SIZE, "%s/state.json", folder); }
static void network_path(char *path, const char *folder, int network, int slot) {
    snprintf(path, PATH_SIZE, "%s/%s.%d.safetensors", folder, network_names[network], slot);
}

static enum status refuse(const char *path, const char *why, struct error *error) {
    return error_set(error, STATUS_INVALID, "%s: %s; remove the folder, or bake without --resume", path, why);
}

enum status checkpoint_load(struct checkpoint *checkpoint, bool *found, const char *folder, const char *identity,
                            struct error *error) {
    char path[PATH_SIZE];
    state_path(path, folder);
    *found = false;
    if (access(path, F_OK) != 0) return STATUS_OK;
    uint8_t *bytes;
    size_t length;
    enum status status = file_read(path, &bytes, &length, error);
    if (status != STATUS_OK) return status;
    json_t *root = json_loadb((const char *)bytes, length, 0, NULL);
    free(bytes);
    const char *text;
    json_int_t slot, data, encoding, log2_entries, planned, transparency_chunks, light_chunks, traced;
    double seconds;
    int failed = json_unpack(root, "{s:s, s:I, s:I, s:I, s:I, s:I, s:I, s:I, s:I, s:F}", "identity", &text, "slot",
                             &slot, "data", &data, "encoding", &encoding, "log2_entries", &log2_entries, "planned",
                             &planned, "transparency_chunks", &transparency_chunks, "light_chunks", &light_chunks,
                             "traced", &traced, "seconds", &seconds);
    if (failed || (slot & 1) != slot || data < 0 || data > DATA_BOTH || encoding < 0 || encoding >= ENCODING_CHOICES ||
        log2_entries < 10 || log2_entries > 20 || planned < 1 || planned > (json_int_t)1 << 40 ||
        transparency_chunks < 0 || light_chunks < 0 || light_chunks > planned || traced < 0)
        status = refuse(path, "the checkpoint is damaged", error);
    else if (strcmp(text, identity) != 0)
        status = refuse(path, "the checkpoint belongs to another lamp, or to other options", error);
    else {
        *checkpoint = (struct checkpoint){
            .slot = (int)slot,
            .recipe = {.data = (enum data_source)data,
                       .encoding = (int)encoding,
                       .log2_entries = (int)log2_entries,
                       .chunks = (size_t)planned},
            .transparency_chunks = (size_t)transparency_chunks,
            .light_chunks = (size_t)light_chunks,
            .traced = (size_t)traced,
            .seconds = seconds,
        };
        snprintf(checkpoint->identity, sizeof checkpoint->identity, "%s", identity);
        *found = true;
    }
    json_decref(root);
    return status;
}

enum status checkpoint_load_networks(const struct checkpoint *checkpoint, const char *folder, struct light_field *field,
                                     struct transparency *transparency, struct error *error) {
    char path[PATH_SIZE];
    network_path(path, folder, 0, checkpoint->slot);
    enum status status = light_field_load_state(field, path, error);
    network_path(path, folder, 1, checkpoint->slot);
    return status == STATUS_OK && transparency ? transparency_load_state(transparency, path, error) : status;
}

enum status checkpoint_save(struct checkpoint *checkpoint, const char *folder, const struct light_field *field,
                            const struct transparency *transparency, struct error *error) {
    if (mkdir(folder, 0777) != 0 && errno != EEXIST)
        return error_set(error, STATUS_IO, "cannot create the folder %s: %s", folder, strerror(errno));
    char path[PATH_SIZE];
    int slot = 1 - checkpoint->slot;
    network_path(path, folder, 0, slot);
    enum status status = light_field_save_state(field, path, error);
    network_path(path, folder, 1, slot);
    if (status == STATUS_OK && transparency) status = transparency_save_state(transparency, path, error);
    if (status != STATUS_OK) return status;
    checkpoint->slot = slot;
    json_t *root =
        json_pack("{s:s, s:I, s:I, s:I, s:I, s:I, s:I, s:I, s:I, s:f}", "identity", checkpoint->identity, "slot",
                  (json_int_t)slot, "data", (json_int_t)checkpoint->recipe.data, "encoding",
                  (json_int_t)checkpoint->recipe.encoding, "log2_entries", (json_int_t)checkpoint->recipe.log2_entries,
                  "planned", (json_int_t)checkpoint->recipe.chunks, "transparency_chunks",
                  (json_int_t)checkpoint->transparency_chunks, "light_chunks", (json_int_t)checkpoint->light_chunks,
                  "traced", (json_int_t)checkpoint->traced, "seconds", checkpoint->seconds);
    char *text = root ? json_dumps(root, JSON_INDENT(2)) : NULL;
    json_decref(root);
    if (!text) return error_set(error, STATUS_MEMORY, "out of memory for the checkpoint");
    state_path(path, folder);
    status = file_write_atomic(path, text, strlen(text), error);
    free(text);
    return status;
}

void checkpoint_remove(const char *folder) {
    char path[PATH_SIZE];
    state_path(path, folder);
    unlink(path);
    for (int network = 0; network < 2; network++)
        for (int slot = 0; slot < 2; slot++) {
            network_path(path, folder, network, slot);
            unlink(path);
        }
    rmdir(folder);
}
