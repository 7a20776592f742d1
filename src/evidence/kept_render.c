// The key that says from what a kept rendering was made is the request and the bytes of the room and the lamp. A
// cancelled rendering is thrown away: it would be read as a finished one.
#include "evidence/kept_render.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "evidence/kept.h"
#include "evidence/scene_files.h"
#include "render/render.h"
#include "trace/integrator.h"

struct places { // where it is kept
    char image[PATH_MAX], outside[PATH_MAX], numbers[PATH_MAX], unfinished[PATH_MAX];
};

static void places_make(struct places *places, const struct figure_kit *kit, const char *name) {
    snprintf(places->image, PATH_MAX, "%s/kept/%s.exr", kit->folder, name);
    snprintf(places->outside, PATH_MAX, "%s/kept/%s_outside.exr", kit->folder, name);
    snprintf(places->numbers, PATH_MAX, "%s/kept/%s.json", kit->folder, name);
    snprintf(places->unfinished, PATH_MAX, "%s/kept/%s.unfinished.exr", kit->folder, name);
}

struct definition_list {
    struct definition entries[6];
    size_t count;
    char furniture[PATH_MAX], textures[PATH_MAX];
};

static void define(struct definition_list *list, const char *name, const char *value) {
    if (value) list->entries[list->count++] = (struct definition){name, value};
}

static void define_all(struct definition_list *list, const struct figure_kit *kit, const struct render_request *r) {
    list->count = 0;
    evidence_thing(list->furniture, &kit->data, "furniture");
    evidence_thing(list->textures, &kit->data, "textures");
    define(list, "lamp", r->lamp);
    define(list, "furniture", r->furnished ? list->furniture : NULL);
    define(list, "textures", r->furnished ? list->textures : NULL);
    define(list, "appearance", r->appearance);
    define(list, "keep", r->keep);
    define(list, "size", r->size);
}

static enum status key_make(char *key, size_t size, const struct figure_kit *kit, const struct render_request *r,
                            const struct definition_list *definitions, struct error *error) {
    struct scene_files files;
    enum status status = scene_files_measure(&files, r->room, definitions->entries, definitions->count, error);
    snprintf(key, size, "%s %s keep %s size %s mask %d, %g CPU s, %dx%d, %g %g %g, seed %llu, files %016llx",
             r->integrator, r->appearance ? r->appearance : "", r->keep ? r->keep : "", r->size ? r->size : "",
             (int)r->mask, r->cpu_seconds, r->width, r->height, (double)r->crop.x, (double)r->crop.y,
             (double)r->crop.side, (unsigned long long)kit->run.seed, (unsigned long long)files.hash);
    return status;
}

static enum status scene_prepare(struct scene *scene, const struct figure_kit *kit, const struct render_request *r,
                                 const struct definition_list *definitions, struct error *error) {
    struct scene_options options = {.share_light = true,
                                    .definitions = definitions->entries,
                                    .definition_count = definitions->count,
                                    .width = r->width,
                                    .height = r->height,
                                    .threads = kit->run.threads};
    enum status status = scene_load(scene, r->room, &options, &kit->run, error);
    if (status) return status;
    integrator_find(&scene->integrator, r->integrator);
    for (size_t i = 0; i < scene->luminaire_count; i++) scene->luminaires[i].mask = r->mask;
    if (r->crop.side > 0) {
        scene->sensor->crop_x = (int)(r->crop.x * (float)r->width);
        scene->sensor->crop_y = (int)(r->crop.y * (float)r->height);
        scene->sensor->crop_width = scene->sensor->crop_height = (int)(r->crop.side * (float)r->height);
    }
    return STATUS_OK;
}

static enum status render_now(struct figure_kit *kit, const struct render_request *r, const struct places *places,
                              const struct definition_list *definitions, const char *key, struct error *error) {
    struct scene scene = {0};
    struct render_result result;
    enum status status = scene_prepare(&scene, kit, r, definitions, error);
    if (status) return status;
    struct render_options options = {
        .output = places->unfinished, .cpu_seconds = r->cpu_seconds, .mask = r->lamp_seen ? places->outside : NULL};
    status = render_scene(&scene, &options, &kit->run, &result, error);
    scene_fini(&scene);
    if (status) {
        unlink(places->unfinished);
        return status;
    }
    if (rename(places->unfinished, places->image))
        return error_set(error, STATUS_IO, "%s cannot be renamed to %s", places->unfinished, places->image);
    return kept_save(places->numbers,
                     json_pack("{s:s, s:f, s:i}", "key", key, "cpu_s", result.cpu_s, "samples", result.samples), error);
}

enum status kept_render(struct figure_kit *kit, const struct render_request *r, struct kept_render *render,
                        struct error *error) {
    struct places places;
    struct definition_list definitions;
    char key[500];
    define_all(&definitions, kit, r);
    places_make(&places, kit, r->name);
    figure_step(kit, r->name);
    *render = (struct kept_render){0};
    enum status status = key_make(key, sizeof key, kit, r, &definitions, error);
    if (status) return status;
    json_t *numbers = kept_load(places.numbers, key);
    if (!numbers) {
        unlink(places.numbers); // the image is about to be another
        status = render_now(kit, r, &places, &definitions, key, error);
        numbers = status ? NULL : kept_load(places.numbers, key);
    }
    if (!status) status = image_load(&render->image, places.image, false, error);
    if (!status && r->lamp_seen) status = image_load(&render->outside, places.outside, true, error);
    render->cpu_s = json_number_value(json_object_get(numbers, "cpu_s"));
    render->samples = (int)json_integer_value(json_object_get(numbers, "samples"));
    json_decref(numbers);
    if (status) kept_render_fini(render);
    return status;
}

void kept_render_fini(struct kept_render *render) {
    image_fini(&render->image);
    image_fini(&render->outside);
}
