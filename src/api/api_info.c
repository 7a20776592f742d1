// sconce_info, sconce_help, sconce_version.
#include <jansson.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "api/api_run.h"
#include "image/image.h"
#include "luminaire/group_setting.h"
#include "luminaire/hull.h"
#include "luminaire/luminaire.h"
#include "scene/help.h"
#include "scene/scene.h"

const char *sconce_version(void) { return SCONCE_VERSION; }

static bool has_extension(const char *path, const char *extension) {
    const char *dot = strrchr(path, '.');
    return dot && !strcasecmp(dot, extension);
}

static json_t *triple(const float v[3]) { return json_pack("[fff]", (double)v[0], (double)v[1], (double)v[2]); }

static enum status info_luminaire(const char *path, json_t *json, struct error *error) {
    struct luminaire *luminaire;
    enum status status = luminaire_load(&luminaire, path, error);
    if (status) return status;
    float center[3], radius, flux[3], back[3], onward[3];
    luminaire_scattering(luminaire, back, onward);
    luminaire_bounds(luminaire, center, &radius);
    luminaire_flux(luminaire, flux);
    json_object_set_new(json, "kind", json_string("luminaire"));
    json_object_set_new(json, "bytes", json_integer((json_int_t)luminaire_bytes(luminaire)));
    json_object_set_new(json, "center", triple(center));
    json_object_set_new(json, "radius", json_real((double)radius));
    json_object_set_new(json, "flux", triple(flux));
    json_object_set_new(json, "lumens", json_real((double)luminous_flux(flux)));
    json_object_set_new(json, "scatters", json_pack("{s:o, s:o}", "back", triple(back), "onward", triple(onward)));
    json_t *groups = json_array();
    for (size_t g = 0; g < luminaire_group_count(luminaire); g++) {
        const char *name = luminaire_group(luminaire, g, flux);
        json_array_append_new(groups, json_pack("{s:s, s:o, s:f}", "name", name, "flux", triple(flux), "lumens",
                                                (double)luminous_flux(flux)));
    }
    if (json_array_size(groups)) json_object_set(json, "groups", groups);
    json_decref(groups);
    const struct hull *hull = luminaire_hull(luminaire);
    if (hull)
        json_object_set_new(json, "hull",
                            json_pack("{s:I, s:I, s:I}", "triangles", (json_int_t)hull->triangle_count, "vertices",
                                      (json_int_t)hull->vertex_count, "parts", (json_int_t)hull->part_count));
    json_t *metadata = json_object();
    for (size_t i = 0; luminaire_metadata_key(luminaire, i); i++) {
        const char *key = luminaire_metadata_key(luminaire, i), *value = luminaire_metadata(luminaire, key);
        json_t *parsed = json_loads(value, JSON_DECODE_ANY, NULL); // figures are stored as JSON, names as they are
        json_object_set_new(metadata, key, parsed ? parsed : json_string(value));
    }
    json_object_set_new(json, "metadata", metadata);
    luminaire_destroy(luminaire);
    return STATUS_OK;
}

static enum status info_image(const char *path, json_t *json, struct error *error) {
    struct image image;
    enum status status = image_load(&image, path, false, error);
    if (status) return status;
    json_object_set_new(json, "kind", json_string("image"));
    json_object_set_new(json, "width", json_integer(image.width));
    json_object_set_new(json, "height", json_integer(image.height));
    json_t *channels = json_array();
    size_t pixels = (size_t)image.width * (size_t)image.height;
    for (int c = 0; c < image.channels; c++) {
        double sum = 0;
        float low = image.pixels[c], high = low;
        size_t bad = 0;
        for (size_t i = 0; i < pixels; i++) {
            float v = image.pixels[i * (size_t)image.channels + (size_t)c];
            sum += (double)v;
            low = v < low ? v : low;
            high = v > high ? v : high;
            bad += !(v - v == 0);
        }
        static const char *const usual[] = {"R", "G", "B", "A"};
        json_array_append_new(channels, json_pack("{s:s, s:f, s:f, s:f, s:I}", "name",
                                                  image.channel_names   ? image.channel_names[c]
                                                  : image.channels == 1 ? "Y"
                                                                        : usual[c & 3],
                                                  "min", (double)low, "max", (double)high, "mean",
                                                  bad ? 0.0 : sum / (double)pixels, "not_finite", (json_int_t)bad));
    }
    json_object_set_new(json, "channels", channels);
    image_fini(&image);
    return STATUS_OK;
}

static enum status info_scene(const char *path, const struct scene_options *options, const struct run *run,
                              json_t *json, struct error *error) {
    struct scene scene = {0};
    enum status status = scene_load(&scene, path, options, run, error);
    if (status) return status;
    size_t triangles = 0;
    json_t *shapes = json_array();
    for (size_t i = 0; i < scene.shape_count; i++) {
        const struct shape *shape = scene.shapes[i];
        triangles += shape->mesh.triangle_count;
        json_array_append_new(
            shapes, json_pack("{s:s, s:s, s:s, s:I, s:b}", "type", shape->type->name, "id", shape->id ? shape->id : "",
                              "bsdf", shape->bsdf && shape->bsdf->type ? shape->bsdf->type->name : "", "triangles",
                              (json_int_t)shape->mesh.triangle_count, "emits", shape->emitter != NULL));
    }
    json_t *emitters = json_array();
    for (size_t i = 0; i < scene.emitter_count; i++) {
        const rgb power = scene.emitters[i]->power;
        json_array_append_new(emitters, json_pack("{s:s, s:s, s:[fff]}", "type", scene.emitters[i]->type->name, "id",
                                                  scene.emitters[i]->id, "power", (double)power.r, (double)power.g,
                                                  (double)power.b));
    }
    json_object_set_new(json, "kind", json_string("scene"));
    json_object_set_new(json, "triangles", json_integer((json_int_t)triangles));
    json_object_set_new(json, "shapes", shapes);
    json_object_set_new(json, "emitters", emitters);
    json_object_set_new(json, "luminaires", json_integer((json_int_t)scene.luminaire_count));
    json_object_set_new(json, "bounds",
                        json_pack("{s:[fff], s:f}", "center", (double)scene.bounds.center.x,
                                  (double)scene.bounds.center.y, (double)scene.bounds.center.z, "radius",
                                  (double)scene.bounds.radius));
    if (scene.sensor)
        json_object_set_new(json, "sensor",
                            json_pack("{s:s, s:i, s:i, s:i}", "type", scene.sensor->type->name, "width",
                                      scene.sensor->width, "height", scene.sensor->height, "samples",
                                      scene.sensor->sample_count));
    scene_fini(&scene);
    return STATUS_OK;
}

enum sconce_status sconce_info(const char *path, const struct sconce_definition *definitions, size_t definition_count,
                               const struct sconce_run *run, char **text, struct sconce_error *error) {
    struct api_run api;
    struct error inner = {0};
    api_run_init(&api, run);
    *text = NULL;
    json_t *json = json_pack("{s:s}", "file", path);
    enum status status;
    if (has_extension(path, ".safetensors"))
        status = info_luminaire(path, json, &inner);
    else if (has_extension(path, ".xml")) {
        struct scene_options options = {.definitions = (const struct definition *)definitions,
                                        .definition_count = definition_count,
                                        .threads = api.run.threads};
        status = info_scene(path, &options, &api.run, json, &inner);
    } else
        status = info_image(path, json, &inner);
    if (!status && !(*text = json_dumps(json, JSON_INDENT(2) | JSON_REAL_PRECISION(7))))
        status = error_set(&inner, STATUS_MEMORY, "%s: out of memory", path);
    json_decref(json);
    return api_status(status, &inner, error);
}

enum sconce_status sconce_help(const char *kind, const char *type, char **text, struct sconce_error *error) {
    struct error inner = {0};
    struct arena arena = {0};
    *text = NULL;
    const char *help = help_text(&arena, kind, type);
    if (help) *text = strdup(help);
    enum status status = STATUS_OK;
    if (!*text)
        status = error_set(&inner, STATUS_MEMORY, "out of memory");
    else if (!help_knows(kind, type)) {
        status = error_set(&inner, STATUS_INVALID, "%s", *text);
        free(*text);
        *text = NULL;
    }
    arena_fini(&arena);
    return api_status(status, &inner, error);
}
