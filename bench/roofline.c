// How near the queries of a baked luminaire come to what this machine can do:
//   bench_roofline LAMP.safetensors [--json]
// In one run: the peaks of one core (machine_peak.h), then every query in batches of 1 to 65536 on one core and on two
// at once. All times are CPU times of the thread, the best of several tries. Shares of a peak count what a query cannot
// do without: the network's and the interpolation's multiply-adds, the fetches from its tables, the numbers that go in
// and out. Lines are random lines through the proxy, shading points lie at 1.1 to 6 radii, in no order.
#include <jansson.h>
#include <math.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>

#include "base/parallel.h"
#include "luminaire/luminaire_private.h"
#include "machine_peak.h"
#include "math/sampler.h"
#include "math/warp.h"
#include "net/kernel.h"

enum { POOL = 1 << 16, BATCHES = 5, TRIES = 7 };
static const size_t batches[BATCHES] = {1, 16, 256, 4096, POOL};
static const double try_seconds = 0.03;

typedef float triple[3];

struct pool {
    triple point[POOL], w[POOL], s[POOL], u[POOL], direction[POOL];
};
struct answers { // of one thread
    triple triples[POOL];
    float pdf[POOL];
};

struct query {
    const char *name;
    void (*ask)(const struct luminaire *luminaire, const struct pool *pool, size_t first, size_t n,
                struct answers *answers);
    double flops, fetches, bytes, table_bytes; // of one; 0: not counted
};

static const triple *from(const triple *triples, size_t first) { return triples + first; }

static void ask_light(const struct luminaire *l, const struct pool *pool, size_t first, size_t n, struct answers *a) {
    luminaire_eval(l, n, from(pool->point, first), from(pool->w, first), a->triples);
}

static void ask_transparency(const struct luminaire *l, const struct pool *pool, size_t first, size_t n,
                             struct answers *a) {
    luminaire_transmittance(l, n, from(pool->point, first), from(pool->w, first), a->triples);
}

static void ask_sample(const struct luminaire *l, const struct pool *pool, size_t first, size_t n, struct answers *a) {
    luminaire_sample(l, n, from(pool->s, first), from(pool->u, first), a->triples, a->pdf);
}

static void ask_pdf(const struct luminaire *l, const struct pool *pool, size_t first, size_t n, struct answers *a) {
    luminaire_pdf(l, n, from(pool->s, first), from(pool->direction, first), a->pdf);
}

static void store(triple to, vec3 v) { to[0] = v.x, to[1] = v.y, to[2] = v.z; }

static void fill_pool(const struct luminaire *luminaire, struct pool *pool) {
    float center[3], radius;
    luminaire_bounds(luminaire, center, &radius);
    const vec3 middle = {center[0], center[1], center[2]};
    for (size_t i = 0; i < POOL; i++) {
        struct sampler sampler = sampler_make(1, 0, i);
        vec3 in = warp_uniform_sphere(sampler_2d(&sampler)), out = warp_uniform_sphere(sampler_2d(&sampler));
        store(pool->point[i], vec3_mad(in, 0.9f * radius * cbrtf(sampler_1d(&sampler)), middle));
        store(pool->w[i], out);
        store(pool->s[i], vec3_mad(in, radius * (1.1f + 5 * sampler_1d(&sampler)), middle));
        for (int a = 0; a < 3; a++) pool->u[i][a] = sampler_1d(&sampler);
    }
    struct answers *answers = malloc(sizeof *answers);
    if (!answers) exit(1);
    luminaire_sample(luminaire, POOL, from(pool->s, 0), from(pool->u, 0), pool->direction, answers->pdf);
    free(answers);
}

// --- Rates ---

struct work {
    const struct query *query;
    const struct luminaire *luminaire;
    const struct pool *pool;
    struct answers *answers;
    size_t batch, count;
    atomic_int *waiting; // threads that have not come yet
    double rate;
};

static void *work_run(void *user) {
    struct work *work = user;
    atomic_fetch_sub(work->waiting, 1);
    while (atomic_load(work->waiting) > 0) {
    }
    const double start = clock_thread_s();
    for (size_t done = 0; done < work->count; done += work->batch)
        work->query->ask(work->luminaire, work->pool, done % POOL, work->batch, work->answers);
    work->rate = (double)work->count / (clock_thread_s() - start);
    return NULL;
}

// Queries a second of all threads together.
static double measure(struct work work, int threads, struct answers *answers) {
    struct work all[2] = {work, work};
    pthread_t thread;
    atomic_int waiting = threads;
    for (int t = 0; t < threads; t++) {
        all[t].answers = answers + t;
        all[t].waiting = &waiting;
    }
    const bool two = threads > 1;
    if (two && pthread_create(&thread, NULL, work_run, &all[1])) exit(1);
    work_run(&all[0]);
    if (two) pthread_join(thread, NULL);
    return all[0].rate + (two ? all[1].rate : 0);
}

struct rates {
    double one, two; // queries a second; two: 0 where there is one core only
};

static struct rates measure_best(struct work work, struct answers *answers) {
    struct rates best = {0, 0};
    work.count = (4096 + work.batch - 1) / work.batch * work.batch;
    double trial = measure(work, 1, answers);
    work.count = ((size_t)(trial * try_seconds) / work.batch + 1) * work.batch;
    for (int k = 0; k < TRIES; k++) {
        best.one = fmax(best.one, measure(work, 1, answers));
        if (parallel_cores() > 1) best.two = fmax(best.two, measure(work, 2, answers));
    }
    return best;
}

// --- What queries need ---

static void count_light(const struct luminaire *luminaire, struct query *query) {
    if (!luminaire->emissions[0].light) return;
    const struct field_net *net = &luminaire->emissions[0].light->net;
    const struct grid_layout *layout = &net->encoding.layout;
    const int inputs = net->shape.inputs, width = net->shape.width, outputs = net->shape.outputs;
    query->fetches = layout->corner_count - layout->lookup_count; // two corners each
    query->flops = 2.0 * width * (inputs + width + outputs) + 4.0 * layout->corner_count;
    query->table_bytes = 2.0 * layout->entry_count;
}

// Counted by hand in luminaire/sampling_kernel_body.h.
static void count_density(const struct luminaire *luminaire, bool samples, struct query *query) {
    if (!luminaire->emissions[0].density) return;
    const double anchors = luminaire->emissions[0].density->anchor_count;
    query->flops = 110 + (samples ? 130 : 0) + anchors * (25 + 50);
    query->fetches = 7 + (samples ? 4 : 0) + anchors;
    query->table_bytes =
        (double)sampling_cell_count(luminaire->emissions[0].density) * (MAP_SIDE + 1) * (MAP_SIDE + 1) * 2;
}

// --- Reports ---

struct peaks {
    double flops, stream, fetch_memory;
};

static json_t *report_row(const struct query *query, size_t batch, struct rates rates, const struct peaks *peaks,
                          double fetch) {
    struct {
        const char *name;
        double share;
    } bounds[] = {{"arithmetic", rates.one * query->flops / peaks->flops},
                  {"fetches", fetch > 0 ? rates.one * query->fetches / fetch : 0},
                  {"streaming", rates.one * query->bytes / peaks->stream}};
    const char *binding = "not counted";
    double most = 0;
    for (int k = 0; k < 3 && query->flops > 0; k++)
        if (bounds[k].share > most) most = bounds[k].share, binding = bounds[k].name;
    json_t *row =
        json_pack("{s:s, s:I, s:f, s:f, s:s, s:f, s:f, s:f}", "query", query->name, "batch", (json_int_t)batch, "rate",
                  rates.one, "latency_s", (double)batch / rates.one, "bound", binding, bounds[0].name, bounds[0].share,
                  bounds[1].name, bounds[1].share, bounds[2].name, bounds[2].share);
    if (rates.two > 0) json_object_set_new(row, "two_cores", json_real(rates.two / (2 * rates.one)));
    return row;
}

static void print_row(const json_t *row) {
    const json_t *two = json_object_get(row, "two_cores");
    const bool counted = strcmp(json_string_value(json_object_get(row, "bound")), "not counted") != 0;
    printf("%-13s %6lld %9.3f M/s %10.3f us ", json_string_value(json_object_get(row, "query")),
           (long long)json_integer_value(json_object_get(row, "batch")),
           1e-6 * json_real_value(json_object_get(row, "rate")),
           1e6 * json_real_value(json_object_get(row, "latency_s")));
    if (two)
        printf("%5.0f %%   ", 100 * json_real_value(two));
    else
        printf("    -     ");
    static const char *const names[] = {"arithmetic", "fetches", "streaming"};
    for (int k = 0; k < 3; k++)
        if (counted)
            printf("%4.0f %%", 100 * json_real_value(json_object_get(row, names[k])));
        else
            printf("     -");
    printf("   %s\n", json_string_value(json_object_get(row, "bound")));
}

int main(int argc, char **argv) {
    if (argc < 2 || argc > 3 || (argc == 3 && strcmp(argv[2], "--json") != 0))
        return fprintf(stderr, "usage: %s LAMP.safetensors [--json]\n", argv[0]), 2;
    struct luminaire *luminaire;
    struct error error;
    if (luminaire_load(&luminaire, argv[1], &error)) return fprintf(stderr, "%s\n", error.text), 1;
    enum { MEMORY = 1 << 28 };
    struct pool *pool = aligned_alloc(64, sizeof *pool);
    struct answers *answers = aligned_alloc(64, 2 * sizeof *answers);
    int8_t *memory = aligned_alloc(64, MEMORY);
    if (!pool || !answers || !memory) return fprintf(stderr, "out of memory\n"), 1;
    memset(memory, 1, MEMORY);
    fill_pool(luminaire, pool);
    const bool wide = kernel_best() != &kernel_avx2;
    const struct peaks peaks = {peak_flops(wide), peak_stream(memory, MEMORY),
                                peak_fetch(memory, MEMORY, wide, 100000)};
    json_t *root = json_pack("{s:s, s:s, s:i, s:f, s:f, s:f}", "luminaire", argv[1], "kernel", kernel_best()->name,
                             "cores", parallel_cores(), "peak_flops", peaks.flops, "peak_stream_bytes", peaks.stream,
                             "peak_fetches_memory", peaks.fetch_memory);
    json_t *rows = json_array();
    json_object_set_new(root, "rows", rows);
    struct query queries[] = {{.name = "light field", .ask = ask_light, .bytes = 9 * sizeof(float)},
                              {.name = "transparency", .ask = ask_transparency, .bytes = 9 * sizeof(float)},
                              {.name = "sample", .ask = ask_sample, .bytes = 10 * sizeof(float)},
                              {.name = "pdf", .ask = ask_pdf, .bytes = 7 * sizeof(float)}};
    count_light(luminaire, &queries[0]);
    count_density(luminaire, true, &queries[2]);
    count_density(luminaire, false, &queries[3]);
    const bool json = argc == 3;
    if (!json)
        printf("%s, one core: %.1f GFLOP/s; reads %.1f GB/s in order, %.0f M/s at random from %d MB\n",
               kernel_best()->name, 1e-9 * peaks.flops, 1e-9 * peaks.stream, 1e-6 * peaks.fetch_memory, MEMORY >> 20);
    for (size_t q = 0; q < sizeof queries / sizeof *queries; q++) {
        const struct query *query = &queries[q];
        const size_t table_bytes = query->table_bytes < MEMORY ? (size_t)query->table_bytes : MEMORY;
        const double fetch = table_bytes > 0 ? peak_fetch(memory, table_bytes, wide, 1000000) : 0;
        if (!json && q == 0)
            printf("query          batch       rate       latency  2 cores  arithm. fetch stream bound\n");
        for (int b = 0; b < BATCHES; b++) {
            struct work work = {.query = query, .luminaire = luminaire, .pool = pool, .batch = batches[b]};
            json_t *row = report_row(query, batches[b], measure_best(work, answers), &peaks, fetch);
            json_object_set_new(row, "peak_fetches", json_real(fetch));
            json_array_append_new(rows, row);
            if (!json) print_row(row);
        }
        if (!json && fetch > 0)
            printf("  peak of fetches from %.0f kB of tables: %.0f M/s\n", 1e-3 * query->table_bytes, 1e-6 * fetch);
    }
    if (json) json_dumpf(root, stdout, JSON_COMPACT | JSON_REAL_PRECISION(6));
    if (json) putchar('\n');
    json_decref(root);
    free(pool);
    free(answers);
    free(memory);
    luminaire_destroy(luminaire);
    return 0;
}
