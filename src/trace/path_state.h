// What the stages of the path tracer share. A block of paths (one tile of the film) goes through
//   generate, then until none is left: intersect, luminaire, view, hit, share, cache, light, shadow, arrive, scatter
// one stage for all paths at a time, so that the queries of baked luminaires come in batches. One worker owns one
// block.
#pragma once

#include "math/sampler.h"
#include "trace/caustic.h"
#include "trace/fork.h"
#include "trace/guide.h"
#include "trace/lamp_draws.h"
#include "trace/light_select.h"
#include "trace/lobe_shape.h"
#include "trace/luminaire_crossing.h"
#include "trace/path.h"
#include "trace/mirror_list.h"
#include "trace/radiance_cache.h"
#include "trace/residual.h"
#include "trace/shared_view.h"

enum { PATH_STAGES = 10, PATH_TILE = 32, PATH_BLOCK = PATH_TILE * PATH_TILE };
// Light samples of one path where the camera looks; of a block, with one each by way of a mirror.
enum { PATH_MOST_LIGHTS = 4, PATH_MOST_SHADOWS = (PATH_MOST_LIGHTS + 1) * PATH_BLOCK };

// Random dimensions of one path: the camera's, then a fixed share for every edge.
enum path_dimension {
    PATH_DIMENSION_FILM = 0,
    PATH_DIMENSION_LENS = 1,
    PATH_DIMENSION_EDGE = 2,
    PATH_DIMENSION_FORK = 0, // from here: within an edge
    PATH_DIMENSION_BSDF = 1, // two: a direction; the lobe and the choice between the BSDF and the guide
    PATH_DIMENSION_LIGHT = 3,
    PATH_DIMENSION_LIGHT_CHOICE = 4,
    PATH_DIMENSION_LIGHT_THIRD = 5,
    PATH_DIMENSION_ROULETTE = 6,
    PATH_DIMENSIONS_PER_EDGE = 7,
    PATH_DIMENSION_MIRROR = 1 << 16, // beyond all others: three, the choice and the light sample
    PATH_DIMENSION_SHEET = PATH_DIMENSION_MIRROR + 3
};

enum path_status { PATH_DONE, PATH_MISSES, PATH_PASSES, PATH_SCATTERS };

// Where a path gets light from, as the surface sees it that scattered it first: along one direction, the chain,
// unfolded where mirrors and narrow lobes bend it. See path_record.c.
enum record_state { RECORD_NONE, RECORD_LEAVES, RECORD_OPEN, RECORD_CLOSED };
struct path_record {
    enum record_state state;
    bool bent;
    vec3 origin, direction; // of the chain
    float distance; // to the end of the chain
    vec3 n; // there
    float before, beta; // luminance of the path's radiance and weight when the chain began
    float lamp, lamp_distance; // light met on the chain itself
};

struct path_mark { // of a vertex, when the path has ended the cache is told what arrived there
    struct cache_cells cells;
    rgb before, response; // the path's radiance; its weight for uniform light
};

enum share_state {
    SHARE_NONE, // the path has met no surface that shares
    SHARE_HERE, // it stands on one
    SHARE_LEAVES, // it has been scattered from there, and met mirrors at most since
    SHARE_ARRIVED // it has met another
};
struct path_share {
    enum share_state state;
    bool glossy;
    struct shared_view view; // where the path stands
    rgb before; // the path's radiance when it left, or when it arrived
    rgb broad; // share of what comes from where it went
    int count;
    struct shared_sample samples[SHARED_LAYERS]; // the last is of where the path stands or has left
};

struct path_lights { // light samples where the camera looks, of the paths of a tile
    int count; // of each
    uint32_t first; // how many those of a pixel in earlier passes have drawn
    float inverse_counts; // the sum of 1 / count over the tracer's passes
    float noise, rest; // relative variance of one light sample, and of all else in a path
};

struct path {
    struct ray ray;
    struct sampler sampler;
    rgb beta, radiance;
    enum path_status status;
    int depth; // scattering vertices so far
    uint32_t edge; // rays so far, with those that only went on through a surface
    uint32_t pixel; // in the film
    float eta; // product of the relative indices of refraction
    float expected; // luminance of the pixel as earlier passes found it; 0: not known
    const struct path_lights *lights; // of its tile
    float light_count; // of the light samples at `vertex`
    float pdf; // [1/sr] of the ray's direction at `vertex`; 0: camera or delta, which no light sample can give
    struct light_point vertex; // where the path scattered last, as light_select sees it
    bool look; // camera ray, or delta scattering only since
    int through; // luminaire whose hull the ray has passed and does not meet again, or -1
    bool may_be_caustic; // the first vertex is in the class of caustic.h
    bool from_sheet; // the last scattering that was no delta was a lamp's sheet
    bool passed; // went on through a surface since `vertex`
    bool has_from;
    bool dimmed; // by a lamp since `vertex`
    bool samples_mirrors; // `from` has light samples by way of mirrors
    float mirror_pdf; // [1/sr] of the direction at `from` that led to the mirror where the ray starts; 0: none
    vec3 mirrored; // the image of `from` then
    struct path_record record;
    float spread; // [length] the path's footprint at the surface, by scattering that was no delta
    float pdf_spread, unfolded; // [1/sr] of the last such direction, 0: none since; [length] from there
    bool cached; // the light at the vertex came from the cache, but for what a delta brings
    bool marked; // the last mark is the vertex's
    bool shows; // `shown` in place of `radiance`, which is told only
    rgb shown;
    int mark_count;
    struct path_mark marks[CACHE_TOLD];
    struct path_share share;
    struct fork fork; // at `surface`
    struct surface from; // where the ray starts; only with has_from
    struct surface surface; // where it ends, unless PATH_MISSES
};

struct shadow { // a light sample on its way to be tested
    uint32_t path, luminaire; // luminaire: of the sample, or UINT32_MAX
    struct ray ray;
    rgb contribution;
    vec3 viewpoint; // the lamp is asked on the line from here
    vec3 direction; // from the path's surface: the ray's, or towards the mirror where the ray begins
    bool sharp; // the surface scatters it like a mirror
};

struct path_worker {
    struct path *paths; // PATH_BLOCK
    uint32_t *active; // indices of the paths that go on
    size_t active_count;
    struct scene_hit *hits; // PATH_BLOCK, of the active paths in turn
    struct shadow *shadows; // PATH_MOST_SHADOWS
    size_t shadow_count;
    struct crossing_batch crossings;
    struct luminaire_request *requests; // PATH_MOST_SHADOWS, see path_light.c
    size_t request_count;
    struct lamp_draws draws; // PATH_MOST_SHADOWS
    struct line_walk *walks; // of the crossings; this and `responses` only with tracer->residual
    rgb *responses; // to the light samples among the crossings
    double stage_s[PATH_STAGES]; // spent in each of path_stages, for bench/transport.c
    size_t dropped;
};

struct path_tracer {
    const struct scene *scene;
    // Of every shape of the scene; parts of hulls are not in it, and the sheets of lamps are the one beyond, 0.
    struct lobe_shape *lobes;
    struct light_select *lights;
    struct caustic *caustic; // or NULL
    struct path_guide *guide;
    struct radiance_cache *cache; // or NULL
    struct shared_light *shared; // or NULL
    bool shares; // there will be such, as soon as the film is known
    struct mirror_list mirrors;
    struct residual *residual; // or NULL: baked lamps are as their models say
    enum path_strategy strategy;
    bool hidden; // scene_has_hidden_geometry
    int worker_count;
    struct path_worker *workers;
    size_t dropped;
    bool dropped_told;
    // of the running pass
    struct film *film;
    uint64_t seed, pass;
    int tiles_x, tile_count;
    const struct run *run;
    bool cancelled;
    float tellers; // share of the paths that tell the cache
    struct path_lights *tile_lights; // by path_light_count.c
    size_t passes; // that have been begun here; the film may have more
    float *expected, typical; // by path_roulette.c: for every pixel, and of the whole picture
};

struct path_tile { // pixels of the film
    int x0, y0, x1, y1;
};
static inline struct path_tile path_tile_of(const struct path_tracer *tracer, int tile) {
    const int x = tile % tracer->tiles_x * PATH_TILE, y = tile / tracer->tiles_x * PATH_TILE;
    return (struct path_tile){x, y, mini(x + PATH_TILE, tracer->film->width),
                              mini(y + PATH_TILE, tracer->film->height)};
}

// After 4, 8, 16, ... passes of a film what they found is looked at anew.
enum { PATH_PASSES_BEFORE = 4 };
static inline bool path_looks_back(const struct film *film) {
    return film->pass_count >= PATH_PASSES_BEFORE && (film->pass_count & (film->pass_count - 1)) == 0;
}

struct luminaire_request { // for a light sample
    uint32_t path, luminaire;
    const struct mirror *mirror; // in which the lamp is seen, or NULL
    float pmf; // times the path's light samples of this kind
    int number; // of them
};

struct path_stage {
    const char *name;
    void (*run)(const struct path_tracer *tracer, struct path_worker *worker);
};
extern const struct path_stage path_stages[]; // in their order; ends with name == NULL

void path_generate(const struct path_tracer *tracer, struct path_worker *worker, int tile);
void path_intersect(const struct path_tracer *tracer, struct path_worker *worker);
void path_luminaire(const struct path_tracer *tracer, struct path_worker *worker);
void path_view(const struct path_tracer *tracer, struct path_worker *worker);
void path_hit(const struct path_tracer *tracer, struct path_worker *worker);
void path_share(const struct path_tracer *tracer, struct path_worker *worker);
void path_cache(const struct path_tracer *tracer, struct path_worker *worker);
void path_light(const struct path_tracer *tracer, struct path_worker *worker);
// In their place with tracer->residual; of the light samples, those of one lamp whose directions are drawn.
void path_luminaire_residual(const struct path_tracer *tracer, struct path_worker *worker);
void path_light_residual(const struct path_tracer *tracer, struct path_worker *worker, uint32_t luminaire,
                         const struct luminaire_request *requests, size_t count);
void path_shadow(const struct path_tracer *tracer, struct path_worker *worker);
void path_arrive(const struct path_tracer *tracer, struct path_worker *worker);
void path_scatter(const struct path_tracer *tracer, struct path_worker *worker);

// Light samples where the camera looks, see path_light_count.c.
void path_light_learn(struct path_tracer *tracer); // before a pass
static inline int path_light_count(const struct path *path) { return path->look ? path->lights->count : 1; }

// Russian roulette by what earlier passes found.
void path_expect(struct path_tracer *tracer); // before a pass
// After a bounce; incoming: the radiance that is expected from there, 0: not known.
float path_survival(const struct path_tracer *tracer, const struct path *path, float incoming);

// The mean of the film's luminance in which single bright pixels (a lamp that is looked at) take little; and around a
// pixel, at least a small part of it, with single bright pixels bounded.
float path_typical_luminance(const struct film *film);
float path_expected_luminance(const struct film *film, int x, int y, float typical);

// Lamps in plane mirrors, see mirror_list.h.
bool path_samples_mirrors(const struct path_tracer *tracer, const struct path *path); // where it stands
struct luminaire_request path_mirror_request(const struct path_tracer *tracer, const struct path *path, uint32_t index);
// The light sample for a request, from the direction that was drawn at the mirror image of where the path stands.
void path_mirror_sample(const struct path_tracer *tracer, struct path_worker *worker,
                        const struct luminaire_request *request, vec3 direction, float pdf_light);
void path_mirror_scatter(const struct path_tracer *tracer, struct path *path, const struct bsdf_sample *sample);
float path_mirror_weight(const struct path_tracer *tracer, const struct path *path, const struct crossing *crossing);

// The cache of radiance, see path_cache.c.
void path_cache_learn(struct path_tracer *tracer); // before a pass
// False: the path has ended with what the cache knew.
bool path_cache_scatter(const struct path_tracer *tracer, struct path *path, const struct bsdf_sample *sample);
rgb path_cache_end(const struct path_tracer *tracer, const struct path *path); // what the picture gets

// Light that pixels share, see path_share.c.
// A light sample's contribution, by way of this direction.
void path_share_light(const struct path_tracer *tracer, struct path *path, rgb contribution, vec3 direction);
void path_share_scatter(const struct path_tracer *tracer, struct path *path, const struct bsdf_sample *sample);
void path_share_end(const struct path_tracer *tracer, struct path *path, rgb radiance); // what the film gets

// Guided scattering, see path_guide.c.
struct path_guide;
enum status path_guide_create(struct path_guide **guide, struct error *error);
void path_guide_destroy(struct path_guide *guide); // NULL is allowed
void path_guide_learn(struct path_tracer *tracer); // before a pass
// A direction from the BSDF or the guide; the weight is whole, the fork's included; pdf: of the BSDF alone. *incoming:
// the radiance that the guide expects from there, 0: not known.
bool path_scatter_sample(const struct path_tracer *tracer, const struct path *path, struct bsdf_sample *sample,
                         float *incoming);
// Lobes that are narrower than any broad one scatter like a mirror.
static inline bool path_pdf_is_sharp(float pdf_bsdf) { return pdf_bsdf > 0.6f; }

// What the guide learns from.
enum record_part { RECORD_SURFACE, RECORD_LAMP, RECORD_BEYOND, RECORD_PARTS };
bool path_guide_listens(const struct path_tracer *tracer, const struct path *path);
struct path_report { // of one path
    struct guide_record parts[RECORD_PARTS]; // radiance < 0: none
    float whole; // luminance; < 0: nothing is reported
};
struct path_report *path_guide_report(const struct path_tracer *tracer, const struct path *path); // of the path's pixel
void path_record_scatter(const struct path_tracer *tracer, struct path *path, const struct bsdf_sample *sample);
void path_record_hit(struct path *path); // a surface, after its own emission was met
void path_record_lamp(struct path *path, rgb contribution, float distance); // from the last surface
void path_record_end(const struct path_tracer *tracer, const struct path *path);

// beta * f |cos| for light from `direction`, and the density with which scattering gives it.
rgb path_response(const struct path *path, vec3 direction, float *pdf_bsdf);

// Light by a ray that scattering gave, which the particles of caustic.h bring.
static inline bool path_is_caustic(const struct path_tracer *tracer, const struct path *path) {
    return tracer->caustic && path->may_be_caustic && path->pdf == 0;
}

// Scattered by a lamp without geometry.
static inline bool path_is_at_sheet(const struct path_tracer *tracer, const struct path *path) {
    const int i = path->surface.shape->luminaire;
    return i >= 0 && path->surface.shape == tracer->scene->luminaires[i].sheet;
}

static inline struct lobe_shape path_lobes_at(const struct path_tracer *tracer, const struct surface *surface) {
    return surface->shape->hull ? (struct lobe_shape){0} : tracer->lobes[surface->shape->index];
}

static inline struct sampler path_sampler(const struct path *path, enum path_dimension dimension) {
    struct sampler sampler = path->sampler;
    sampler.dimension = PATH_DIMENSION_EDGE + path->edge * PATH_DIMENSIONS_PER_EDGE + (uint32_t)dimension;
    return sampler;
}

// Of one of the path's light samples where it stands: all that a pixel has there are points of one sequence.
static inline struct sampler path_light_sampler(const struct path *path, enum path_dimension dimension, int number) {
    struct sampler sampler = path_sampler(path, dimension);
    if (path->look) sampler.index = sampler_reverse_bits(path->lights->first + (uint32_t)number);
    return sampler;
}

static inline void path_add(struct path_worker *worker, struct path *path, rgb contribution) {
    if (rgb_is_finite(contribution))
        path->radiance = rgb_add(path->radiance, contribution);
    else
        worker->dropped++;
}

static inline bool path_may_scatter(const struct path_tracer *tracer, const struct path *path) {
    return tracer->scene->max_depth < 0 || path->depth + 1 < tracer->scene->max_depth;
}

// The power heuristic with exponent 2 (Veach and Guibas 1995).
static inline float power_heuristic(float pdf, float other) {
    if (!(other > 0)) return 1;
    float ratio = other / pdf;
    return 1 / (1 + ratio * ratio);
}

// Weight of light that a ray met by chance, where a light sample would have come with `pdf_light` (0: never).
static inline float path_hit_weight(const struct path_tracer *tracer, const struct path *path, float pdf_light) {
    if (path->pdf == 0 || tracer->strategy == PATH_BSDF_ONLY || !(pdf_light > 0)) return 1;
    return tracer->strategy == PATH_LIGHTS_ONLY ? 0 : power_heuristic(path->pdf, path->light_count * pdf_light);
}

// The same for a crossing that has been answered.
static inline float path_crossing_weight(const struct path_tracer *tracer, const struct path *path,
                                         const struct crossing *crossing) {
    if (path->mirror_pdf > 0) return path_mirror_weight(tracer, path, crossing);
    float pdf_light = 0;
    if (crossing->wants_pdf)
        pdf_light = crossing->pdf_sa * light_select_pmf_luminaire(tracer->lights, &path->vertex, crossing->luminaire);
    return path_hit_weight(tracer, path, pdf_light);
}

// Weight of a light sample that scattering would have found with `pdf_bsdf`; deltas can be found in no other way.
static inline float path_light_weight(const struct path_tracer *tracer, float pdf_light, float pdf_bsdf, bool delta) {
    if (delta || tracer->strategy == PATH_LIGHTS_ONLY) return 1;
    return tracer->strategy == PATH_BSDF_ONLY ? 0 : power_heuristic(pdf_light, pdf_bsdf);
}
