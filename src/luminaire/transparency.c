// The transparency T(line). With a hull the lines that miss it, that end on an opaque part or pass clear glass only are
// known exactly; the network is asked for those that meet something translucent. Without one it is asked for all lines,
// and silhouettes blur.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "luminaire/hull_tree.h"
#include "luminaire/light_field.h"
#include "net/kernel.h"

enum { LEAST_BITS = 10, MOST_HULL_BITS = 13 };
static const float straight_cos = 0.866f; // light turned by less than 30 degrees counts as having come through

static bool is_translucent(const struct hull *hull) {
    for (size_t i = 0; i < hull->part_count; i++)
        if (hull->parts[i].kind == HULL_TRANSLUCENT) return true;
    return false;
}

// Where a line is blocked is a matter of surfaces at unknown radii: three spheres, and entry x exit. The hull knows
// them; without anything translucent in it the network is never asked.
static void choose_encoding(struct encoding_options *encoding, const struct transparency_options *options) {
    const struct hull *hull = options->hull;
    encoding->use_hull = hull != NULL;
    if (!hull) {
        encoding->shells[0] = 0.75f;
        encoding->shells[1] = 0.5f;
        encoding->shells[2] = 0.25f;
        encoding->shell_count = 3;
    }
    encoding->use_grid4 = !hull || is_translucent(hull);
    const int most = !hull ? options->log2_entries : is_translucent(hull) ? MOST_HULL_BITS : LEAST_BITS;
    encoding->log2_entries = options->log2_entries < most ? options->log2_entries : most;
}

enum status transparency_create(struct transparency **t, const struct transparency_options *options,
                                struct error *error) {
    *t = NULL;
    struct transparency *made = calloc(1, sizeof *made);
    struct encoding_options *encoding = calloc(1, sizeof *encoding);
    enum status status = STATUS_OK;
    if (!made || !encoding)
        status = error_set(error, STATUS_MEMORY, "out of memory for a transparency");
    else {
        choose_encoding(encoding, options);
        struct trainer_rates rates = {.table = 1e-2f, .mlp = 3e-3f, .end = 1.0f / 100, .steps = options->steps};
        status = field_net_create(&made->net, options->proxy->center, options->proxy->radius, encoding, &rates,
                                  options->seed, error);
        if (!status && options->hull) status = hull_tree_create(&made->tree, options->hull, error);
    }
    free(encoding);
    if (status)
        transparency_destroy(made);
    else
        *t = made;
    return status;
}

enum status transparency_set_hull(struct transparency *t, const struct hull *hull, struct error *error) {
    return hull_tree_create(&t->tree, hull, error);
}

size_t transparency_bytes(const struct transparency *t) { return field_net_bytes(&t->net); }

void transparency_destroy(struct transparency *t) {
    if (!t) return;
    field_net_fini(&t->net);
    hull_tree_destroy(t->tree);
    free(t);
}

// The crossing of a line of direction w, its point in the unit ball. False: the line misses the bounding sphere.
static bool cross(const struct transparency *t, const float point[3], const float w[3],
                  struct hull_crossing *crossing) {
    const float *center = t->net.center, radius = t->net.radius;
    vec3 along = {w[0], w[1], w[2]}, p = {point[0] - center[0], point[1] - center[1], point[2] - center[2]};
    p = vec3_mad(along, -vec3_dot(p, along), p);
    float half2 = radius * radius - vec3_dot(p, p);
    if (!(half2 > 0)) return false;
    vec3 origin = vec3_mad(along, sqrtf(half2) + 1e-3f * radius, p);
    origin = vec3_add(origin, (vec3){center[0], center[1], center[2]});
    hull_tree_cross(t->tree, origin, vec3_neg(along), straight_cos, crossing);
    for (int a = 0; a < 3; a++) crossing->point[a] = (crossing->point[a] - center[a]) / radius;
    return true;
}

bool transparency_sees(const struct transparency *t, const float point[3], const float w[3]) {
    struct hull_crossing crossing;
    return !t->tree || (cross(t, point, w, &crossing) && crossing.answer != HULL_MISSED);
}

bool transparency_learns(const struct transparency *t, const float point[3], const float w[3]) {
    struct hull_crossing crossing;
    return !t->tree || (cross(t, point, w, &crossing) && crossing.answer == HULL_DIFFUSED);
}

// --- Training ---

struct job {
    const struct transparency *t;
    const struct line_sample *samples;
};

static void job_encode(const void *user, size_t first, int count, struct grid_input *input) {
    const struct job *job = user;
    const struct field_net *net = &job->t->net;
    struct line_block lines;
    struct hull_crossing crossings[NET_LANES] = {{0}};
    float point[NET_LANES][3], w[NET_LANES][3];
    for (int l = 0; l < count; l++) {
        const struct line_sample *sample = &job->samples[first + (size_t)l];
        memcpy(point[l], sample->point, sizeof point[l]);
        memcpy(w[l], sample->w, sizeof w[l]);
        if (job->t->tree) cross(job->t, point[l], w[l], &crossings[l]);
    }
    line_block_load(&lines, net->center, net->radius, count, (const float(*)[3])point, (const float(*)[3])w);
    lines.crossings = crossings;
    encoding_encode(&net->encoding, &lines, input);
}

// In place; a NaN becomes 0.
static void sigmoid(float *z, size_t count) {
    for (size_t i = 0; i < count; i++) z[i] = z[i] > -40 ? (z[i] < 40 ? -z[i] : -40) : 40;
    kernel_best()->exponential(z, count);
    for (size_t i = 0; i < count; i++) z[i] = 1 / (1 + z[i]);
}

static double transparency_loss(const void *user, size_t first, int count, const float *z, float *d_z) {
    const struct job *job = user;
    _Alignas(64) float value[FIELD_OUTPUTS * NET_LANES];
    memcpy(value, z, sizeof value);
    sigmoid(value, FIELD_OUTPUTS * NET_LANES);
    double loss = 0;
    for (int c = 0; c < FIELD_OUTPUTS; c++)
        for (int l = 0; l < NET_LANES; l++) {
            int i = c * NET_LANES + l;
            d_z[i] = 0;
            if (l >= count) continue;
            const struct line_sample *sample = &job->samples[first + (size_t)l];
            float t = value[i], difference = t - sample->target[c];
            d_z[i] = sample->mass * difference * t * (1 - t);
            loss += (double)(sample->mass * difference * difference);
        }
    return loss;
}

void transparency_train(struct transparency *t, const struct line_sample *samples, size_t n, int threads,
                        double *loss) {
    struct job job = {t, samples};
    double sum = trainer_step(t->net.trainer, &(struct trainer_batch){n, &job, job_encode, transparency_loss}, threads);
    if (loss) *loss = sum / (double)n;
}

void transparency_plan(struct transparency *t, size_t steps) { t->net.trainer->rates.steps = steps; }

// --- Evaluating ---

struct asked { // lines that wait for the network
    int count;
    size_t line[NET_LANES];
    float point[NET_LANES][3], w[NET_LANES][3];
    struct hull_crossing crossings[NET_LANES];
};

static void answer(const struct transparency *t, struct asked *asked, float (*transmittance)[3]) {
    if (asked->count == 0) return;
    _Alignas(64) float z[FIELD_OUTPUTS * NET_LANES];
    float hit[NET_LANES];
    for (int l = asked->count; l < NET_LANES; l++) asked->crossings[l] = asked->crossings[0];
    field_net_eval(&t->net, asked->count, (const float(*)[3])asked->point, (const float(*)[3])asked->w,
                   asked->crossings, z, hit, NULL);
    sigmoid(z, FIELD_OUTPUTS * NET_LANES);
    for (int l = 0; l < asked->count; l++)
        for (int c = 0; c < 3; c++) transmittance[asked->line[l]][c] = hit[l] > 0 ? z[c * NET_LANES + l] : 1;
    asked->count = 0;
}

void transparency_eval(const struct transparency *t, size_t n, const float (*point)[3], const float (*w)[3],
                       float (*transmittance)[3]) {
    struct asked asked = {.count = 0};
    for (size_t i = 0; i < n; i++) {
        struct hull_crossing crossing = {.answer = HULL_DIFFUSED};
        if (t->tree && !cross(t, point[i], w[i], &crossing))
            crossing = (struct hull_crossing){.answer = HULL_MISSED, .transmittance = {1, 1, 1}};
        if (crossing.answer != HULL_DIFFUSED) {
            memcpy(transmittance[i], crossing.transmittance, sizeof crossing.transmittance);
            continue;
        }
        const int l = asked.count++;
        asked.line[l] = i;
        asked.crossings[l] = crossing;
        memcpy(asked.point[l], point[i], sizeof asked.point[l]);
        memcpy(asked.w[l], w[i], sizeof asked.w[l]);
        if (asked.count == NET_LANES) answer(t, &asked, transmittance);
    }
    answer(t, &asked, transmittance);
}
