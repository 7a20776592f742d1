// Camera, film, sampler, filter and integrator: into struct sensor and struct scene. Parameters of other renderers that
// change nothing here are accepted by name.
#include <math.h>
#include <string.h>

#include "scene/load_private.h"
#include "scene/plugins.h"

const struct param sensor_common_params[] = {
    {"to_world", PARAM_TRANSFORM, offsetof(struct sensor, to_world), "",
     .help = "places the camera; it looks along +z"},
    {"near_clip", PARAM_FLOAT, offsetof(struct sensor, near_clip), "0.01", 1e-9, 1e30, "length",
     .help = "nothing nearer is seen"},
    {"far_clip", PARAM_FLOAT, offsetof(struct sensor, far_clip), "10000", 1e-9, 1e30, "length",
     .help = "nothing farther is seen"},
    PARAM_END,
};
static const char *const sensor_ignored[] = {"shutter_open", "shutter_close", "focus_distance", "medium", NULL};

const struct param film_params[] = {
    {"width", PARAM_INT, offsetof(struct sensor, width), "768", 1, 65536, "pixels", .help = "of the full image"},
    {"height", PARAM_INT, offsetof(struct sensor, height), "576", 1, 65536, "pixels", .help = "of the full image"},
    {"crop_offset_x", PARAM_INT, offsetof(struct sensor, crop_x), "0", 0, 65535, "pixels",
     .help = "left of the part to render"},
    {"crop_offset_y", PARAM_INT, offsetof(struct sensor, crop_y), "0", 0, 65535, "pixels",
     .help = "top of the part to render"},
    {"crop_width", PARAM_INT, offsetof(struct sensor, crop_width), "", 1, 65536, "pixels",
     .help = "of the part; default: to the edge"},
    {"crop_height", PARAM_INT, offsetof(struct sensor, crop_height), "", 1, 65536, "pixels",
     .help = "of the part; default: to the edge"},
    PARAM_END,
};
static const char *const film_ignored[] = {"file_format",
                                           "pixel_format",
                                           "component_format",
                                           "banner",
                                           "high_quality_edges",
                                           "attach_log",
                                           "gamma",
                                           "exposure",
                                           "tonemap_method",
                                           "key",
                                           "burn",
                                           "sample_border",
                                           "compensate",
                                           "srf",
                                           "digits",
                                           "variable",
                                           NULL};

const struct param sampler_params[] = {
    {"sample_count", PARAM_INT, offsetof(struct sensor, sample_count), "4", 1, 2147483647, "samples per pixel",
     .help = "unless the command line says another"},
    PARAM_END,
};
static const char *const sampler_ignored[] = {"seed", "dimension", "scramble", "jitter", "wavefront_size", NULL};

enum filter { FILTER_BOX, FILTER_TENT, FILTER_GAUSSIAN }; // as in the film's table
const struct param rfilter_params[] = {
    {"stddev", PARAM_FLOAT, offsetof(struct sensor, filter_stddev), "0.5", 0.05, 8, "pixels",
     .help = "of the gaussian"},
    {"radius", PARAM_FLOAT, offsetof(struct sensor, filter_radius), "", 0.05, 16, "pixels", .help = "of the tent"},
    PARAM_END,
};
static const char *const rfilter_ignored[] = {"b", "c", "lobes", NULL};

const struct param integrator_params[] = {
    {"max_depth", PARAM_INT, offsetof(struct scene, max_depth), "-1", -1, 1e9, "edges",
     .help = "longest path; -1 is unlimited"},
    {"rr_depth", PARAM_INT, offsetof(struct scene, rr_depth), "5", 1, 1e9, "edges",
     .help = "Russian roulette from here on"},
    {"hide_emitters", PARAM_BOOL, offsetof(struct scene, hide_emitters), "false",
     .help = "lights are not seen directly"},
    PARAM_END,
};
static const char *const integrator_ignored[] = {
    "strict_normals", "sample_direct",   "light_image",  "samples_per_pass", "block_size",    "granularity", "timeout",
    "sample_count",   "emitter_samples", "bsdf_samples", "shading_samples",  "show_weighted", "bruteforce",  NULL};

static enum status read_table(const struct loader *loader, struct object *object, void *target,
                              const struct param *params, const char *const *ignored, bool accept_unknown) {
    struct commit_context context = load_context(loader, object);
    params_ignore(object, ignored);
    enum status status = params_read(target, params, NULL, object, &context, NULL, loader->error);
    return status || accept_unknown ? status : params_check_settings(object, &params, 1, loader->run, loader->error);
}

static struct object *child_of(struct object *object, const char *tag) {
    for (size_t i = 0; object && i < object->child_count; i++)
        if (!strcmp(object->children[i].object->tag, tag)) return object->children[i].object;
    return NULL;
}

// The child of that tag, or an empty one, so that the tables give their defaults.
static struct object *child_or_default(const struct loader *loader, struct object *parent, const char *tag,
                                       const char *type) {
    struct object *child = child_of(parent, tag);
    if (child) return child;
    child = load_alloc(loader, sizeof *child);
    if (child) *child = (struct object){.tag = tag, .type = type, .id = "", .place = parent->place};
    return child;
}

// The whole film in the size that the caller asked for; the crop is scaled with it.
static void resize_film(struct sensor *sensor, int width, int height) {
    double sx = (double)width / sensor->width, sy = (double)height / sensor->height;
    int x1 = (int)((sensor->crop_x + sensor->crop_width) * sx + 0.5);
    int y1 = (int)((sensor->crop_y + sensor->crop_height) * sy + 0.5);
    sensor->crop_x = (int)(sensor->crop_x * sx);
    sensor->crop_y = (int)(sensor->crop_y * sy);
    sensor->crop_width = x1 > sensor->crop_x ? x1 - sensor->crop_x : 1;
    sensor->crop_height = y1 > sensor->crop_y ? y1 - sensor->crop_y : 1;
    sensor->width = width;
    sensor->height = height;
}

static enum status read_film(const struct loader *loader, struct object *film, struct sensor *sensor) {
    static const char *const tags[] = {"rfilter", NULL};
    enum status status = load_check_children(loader, film, tags);
    if (!status) status = read_table(loader, film, sensor, film_params, film_ignored, false);
    if (status) return status;
    if (!sensor->crop_width) sensor->crop_width = sensor->width - sensor->crop_x;
    if (!sensor->crop_height) sensor->crop_height = sensor->height - sensor->crop_y;
    if (sensor->crop_width <= 0 || sensor->crop_height <= 0 || sensor->crop_width > sensor->width - sensor->crop_x ||
        sensor->crop_height > sensor->height - sensor->crop_y)
        return error_at(loader->error, film->place, "the crop does not lie within the image of %d x %d", sensor->width,
                        sensor->height);
    if (loader->options->width > 0 && loader->options->height > 0)
        resize_film(sensor, loader->options->width, loader->options->height);
    return STATUS_OK;
}

static enum status read_filter(const struct loader *loader, struct object *rfilter, struct sensor *sensor) {
    struct plugin_view view;
    size_t index;
    enum status status = read_table(loader, rfilter, sensor, rfilter_params, rfilter_ignored, false);
    if (status) return status;
    if (!plugin_find("rfilter", rfilter->type, &view, &index)) {
        run_note(loader->run, "%s:%d:%d: rfilter '%s' is not known; a gaussian is used", rfilter->place.file,
                 rfilter->place.line, rfilter->place.column, rfilter->type);
        view.name = "gaussian";
    }
    if (!strcmp(view.name, "box")) {
        sensor->filter = FILTER_BOX;
        sensor->filter_radius = 0.5f;
    } else if (!strcmp(view.name, "tent")) {
        sensor->filter = FILTER_TENT;
        if (sensor->filter_radius == 0) sensor->filter_radius = 1;
    } else {
        sensor->filter = FILTER_GAUSSIAN;
        sensor->filter_radius = 4 * sensor->filter_stddev;
    }
    return STATUS_OK;
}

enum status load_sensor(struct loader *loader, struct object *object) {
    static const char *const tags[] = {"film", "sampler", "texture", "medium", NULL};
    struct plugin_view view;
    size_t index;
    if (!plugin_find("sensor", object->type, &view, &index)) return load_unknown_type(loader, object);
    const struct sensor_type *type = sensor_table[index];
    struct sensor *sensor = load_alloc(loader, type->size);
    if (!sensor) return STATUS_MEMORY;
    struct object *film = child_or_default(loader, object, "film", "hdrfilm");
    struct object *sampler = child_or_default(loader, object, "sampler", "independent");
    struct object *rfilter = film ? child_or_default(loader, film, "rfilter", "gaussian") : NULL;
    if (!film || !sampler || !rfilter) return STATUS_MEMORY;
    sensor->type = type;
    struct commit_context context = load_context(loader, object);
    const struct param *const tables[] = {type->params, sensor_common_params};
    enum status status = load_check_children(loader, object, tags);
    if (!status) status = read_film(loader, film, sensor);
    if (!status) status = read_table(loader, sampler, sensor, sampler_params, sampler_ignored, false);
    if (!status) status = read_filter(loader, rfilter, sensor);
    if (!status) status = params_read(sensor, type->params, NULL, object, &context, &loader->maker, loader->error);
    if (!status)
        status = params_read(sensor, sensor_common_params, type->params, object, &context, NULL, loader->error);
    params_ignore(object, sensor_ignored);
    if (!status) status = params_check_settings(object, tables, 2, loader->run, loader->error);
    if (!status && sensor->near_clip >= sensor->far_clip)
        status = error_at(loader->error, object->place, "near_clip %g is not less than far_clip %g",
                          (double)sensor->near_clip, (double)sensor->far_clip);
    if (!status && type->commit) status = type->commit(sensor, &context, loader->error);
    loader->scene->sensor = sensor;
    return status;
}

// Names of other renderers' integrators that do what one of ours does.
static const struct {
    const char *name;
    enum integrator_kind kind;
    bool wraps;
} integrator_names[] = {
    {"path", INTEGRATOR_PATH, false},         {"direct", INTEGRATOR_PATH, false},
    {"volpath", INTEGRATOR_PATH, false},      {"volpath_simple", INTEGRATOR_PATH, false},
    {"volpathmis", INTEGRATOR_PATH, false},   {"prb", INTEGRATOR_PATH, false},
    {"prbvolpath", INTEGRATOR_PATH, false},   {"bdpt", INTEGRATOR_BDPT, false},
    {"particle", INTEGRATOR_PARTICLE, false}, {"ptracer", INTEGRATOR_PARTICLE, false},
    {"aov", INTEGRATOR_PATH, true},           {"moment", INTEGRATOR_PATH, true},
    {"adaptive", INTEGRATOR_PATH, true},      {"irrcache", INTEGRATOR_PATH, true},
    {"stokes", INTEGRATOR_PATH, true},
};

enum status load_integrator(struct loader *loader, struct object *object) {
    for (size_t i = 0; i < sizeof integrator_names / sizeof *integrator_names; i++) {
        if (!param_name_equal(object->type, integrator_names[i].name)) continue;
        struct object *nested = integrator_names[i].wraps ? child_of(object, "integrator") : NULL;
        if (nested) return load_integrator(loader, nested);
        loader->scene->integrator = integrator_names[i].kind;
        enum status status =
            read_table(loader, object, loader->scene, integrator_params, integrator_ignored, integrator_names[i].wraps);
        if (param_name_equal(object->type, "direct")) loader->scene->max_depth = 2; // one bounce
        return status;
    }
    const struct place place = object->place;
    run_warn(loader->run, "%s:%d:%d: integrator '%s' is not known; 'path' is used (or choose with --integrator)",
             place.file, place.line, place.column, object->type);
    loader->scene->integrator = INTEGRATOR_PATH;
    return read_table(loader, object, loader->scene, integrator_params, integrator_ignored, true);
}

enum status load_default_integrator(struct loader *loader) {
    struct object path = {.tag = "integrator", .type = "path", .id = "", .place = {loader->scene->path, 0, 0}};
    return load_integrator(loader, &path);
}
