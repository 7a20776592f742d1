// How a row is measured. Two renderings of ours (64 samples each at scale 1) and two of the geometry tell
// bias from noise; one of the geometry with 1024 samples sets the error; a last one of ours grows until it is as good.
#include "evidence/table1_row.h"

#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "evidence/long_render.h"
#include "evidence/scene_files.h"
#include "evidence/table1_error.h"
#include "image/metric.h"
#include "luminaire/luminaire.h"

const struct table1_entry table1_entries[TABLE1_ROWS] = {
    {"statler", "Statler", "elevator room", "statler_lamp", "elevator_room", 533, 7.03},
    {"star", "Moravian star", "loft apartment", "star_lamp", "loft_apartment", 533, 12.14},
    {"blossom", "Cherry blossom", "diffuse box", "blossom_lamp", "diffuse_box", 400, 21.70},
    {"feather", "White feather", "bedroom", "feather_lamp", "bedroom", 533, 35.98},
    {"vintage", "Vintage crystal", "living room", "vintage_lamp", "living_room", 533, 15.18},
};

enum { HEIGHT = 400, BDPT_SAMPLES = 1024, HALF_SAMPLES = 256, FIXED_SAMPLES = 128, MAX_STEPS = 10 };
static const double APL_BYTES = 384e6; // Zhu et al. 2021, Table 1
static const double OUR_WORK = 0.35; // of a sample of ours; one of bdpt: 1
static const double CLOSE = 0.93; // to the fewest samples: no fewer are tried

struct row_job {
    struct table1_kit *kit;
    const struct table1_entry *entry;
    struct table1_row *row;
    int width, height, bdpt_samples, reference_samples, half_samples, fixed_samples;
    struct long_render_result ours[2], bdpt, reference[2], equal;
    double our_noise, our_cpu_s; // of one sample a pixel
    struct image mask, reference_mean;
    struct error_parts parts;
};

static int scaled(const struct table1_kit *kit, double count, int least) {
    double value = floor(kit->scale * count + 0.5);
    return value > least ? (int)value : least;
}

static struct row_job row_job(struct table1_kit *kit, const struct table1_entry *entry, struct table1_row *row) {
    return (struct row_job){.kit = kit,
                            .entry = entry,
                            .row = row,
                            .width = scaled(kit, entry->width, 16),
                            .height = scaled(kit, HEIGHT, 16),
                            .bdpt_samples = scaled(kit, BDPT_SAMPLES, 2),
                            .reference_samples = scaled(kit, kit->reference * BDPT_SAMPLES, 2),
                            .half_samples = scaled(kit, HALF_SAMPLES, 2),
                            .fixed_samples = scaled(kit, FIXED_SAMPLES, 1)};
}

double table1_work(const struct table1_kit *kit, const struct table1_entry *entry) {
    struct row_job job = row_job((struct table1_kit *)(uintptr_t)kit, entry, NULL);
    return (double)job.width * job.height *
           (job.bdpt_samples + 2 * job.reference_samples + OUR_WORK * (2 * job.half_samples + 2 * job.fixed_samples));
}

void table1_path(char *path, const struct table1_kit *kit, const struct table1_entry *entry, const char *what) {
    snprintf(path, PATH_MAX, "%s/%s/%s", kit->folder, entry->name, what);
}

void table1_equal_name(char name[TABLE1_NAME], double samples) {
    snprintf(name, TABLE1_NAME, "ours_%.0f_spp", samples);
}

// --- Renderings, and the progress of all of them as one. ---
struct step {
    struct table1_kit *kit;
    double work, first; // first: the fraction that an earlier call had done; < 0: not told yet
};

static void step_progress(void *user, const struct progress *p) {
    struct step *step = user;
    struct table1_kit *kit = step->kit;
    if (step->first < 0) {
        step->first = p->fraction;
        kit->unmeasured += step->work * p->fraction;
    }
    const double done = kit->done + step->work * p->fraction, elapsed = clock_wall_s() - kit->start_s;
    const double measured = done - kit->unmeasured;
    const double eta = measured > 1e-3 * kit->total ? elapsed * (kit->total - done) / measured : -1;
    if (kit->run->progress)
        kit->run->progress(kit->run->user,
                           &(struct progress){p->stage, fmin(done / kit->total, 0.999), elapsed, eta, p->detail});
}

static bool step_cancelled(void *user) { return run_cancelled(((struct step *)user)->kit->run); }

struct rendering {
    const char *name; // of the file
    bool ours; // the baked lamp, by path; or the geometry, by bdpt
    uint64_t seed;
    int samples;
    const char *mask; // path, or NULL
};

static enum status render(struct row_job *job, const struct rendering *r, double work,
                          struct long_render_result *result, struct error *error) {
    struct table1_kit *kit = job->kit;
    char stem[PATH_MAX], room[PATH_MAX], lamp[PATH_MAX], furniture[PATH_MAX], textures[PATH_MAX], stage[80];
    table1_path(stem, kit, job->entry, r->name);
    evidence_room(room, &kit->data, job->entry->room);
    (r->ours ? evidence_baked : evidence_lamp)(lamp, &kit->data, job->entry->lamp);
    evidence_thing(furniture, &kit->data, "furniture");
    evidence_thing(textures, &kit->data, "textures");
    snprintf(stage, sizeof stage, "%s %s", job->entry->name, r->name);
    const struct definition definitions[] = {
        {"lamp", lamp}, {"furniture", furniture}, {"textures", textures}, {"appearance", "surface"}};
    const struct long_render request = {.stem = stem,
                                        .mask = r->mask,
                                        .stage = stage,
                                        .scene = room,
                                        .integrator = r->ours ? "path" : "bdpt",
                                        .definitions = definitions,
                                        .definition_count = 4,
                                        .width = job->width,
                                        .height = job->height,
                                        .seed = 100 * kit->run->seed + r->seed,
                                        .samples = r->samples};
    struct step step = {kit, work, -1};
    const struct run run = {
        .threads = kit->run->threads, .progress = step_progress, .cancelled = step_cancelled, .user = &step};
    enum status status = long_render(&request, &run, result, error);
    kit->done += work;
    if (step.first < 0) kit->unmeasured += work;
    return status;
}

// --- Errors. ---
static enum status measure_picture(const struct row_job *job, const struct image *image, bool whole, double *relmse,
                                   double *flip, struct error *error) {
    struct metrics metrics;
    enum status status = metrics_compute(&metrics, image, &job->reference_mean, whole ? NULL : &job->mask,
                                         image_auto_exposure(&job->reference_mean), error);
    if (status) return status;
    double noise = job->parts.reference_noise;
    if (whole) {
        const struct image *references[2] = {&job->reference[0].image, &job->reference[1].image};
        noise = error_split(references, references, NULL).reference_noise;
    }
    *relmse = metrics.rel_mse - noise;
    if (flip) *flip = metrics.flip;
    return STATUS_OK;
}

// --- The parts of the measurement, in order. ---
static enum status render_halves(struct row_job *job, struct error *error) {
    static const char *const ours[2] = {"ours_1", "ours_2"}, *const references[2] = {"reference_1", "reference_2"};
    char mask[PATH_MAX];
    table1_path(mask, job->kit, job->entry, "mask.exr");
    const double pixels = (double)job->width * job->height;
    const double half_work = OUR_WORK * pixels * job->half_samples, bdpt_work = pixels * job->bdpt_samples;
    const double reference_work = pixels * job->reference_samples;
    enum status status = STATUS_OK;
    for (unsigned i = 0; !status && i < 2; i++)
        status = render(job, &(struct rendering){ours[i], true, 1 + i, job->half_samples, i ? NULL : mask}, half_work,
                        &job->ours[i], error);
    if (!status)
        status =
            render(job, &(struct rendering){"bdpt", false, 11, job->bdpt_samples, NULL}, bdpt_work, &job->bdpt, error);
    for (unsigned i = 0; !status && i < 2; i++)
        status = render(job, &(struct rendering){references[i], false, 21 + i, job->reference_samples, NULL},
                        reference_work, &job->reference[i], error);
    if (!status) status = image_load(&job->mask, mask, true, error);
    if (!status) status = image_mean(&job->reference_mean, &job->reference[0].image, &job->reference[1].image, error);
    return status;
}

// One firefly of bdpt can hold nearly all of its error, and any picture would then equal it. So its worst thousandth of
// the pixels counts for neither: the comparison is the harder for ours, whose own fireflies count.
static enum status drop_fireflies(struct row_job *job, struct error *error) {
    struct table1_row *row = job->row;
    const struct image *references[2] = {&job->reference[0].image, &job->reference[1].image};
    job->parts = error_split(references, references, &job->mask);
    enum status status = measure_picture(job, &job->bdpt.image, false, &row->bdpt_relmse_fireflies, NULL, error);
    row->bdpt_worst_share = error_share_of_worst(&job->bdpt.image, &job->reference_mean, &job->mask, true);
    return status;
}

static enum status measure_bdpt(struct row_job *job, struct error *error) {
    struct table1_row *row = job->row;
    enum status status = drop_fireflies(job, error);
    if (status) return status;
    const struct image *pictures[2] = {&job->ours[0].image, &job->ours[1].image};
    const struct image *references[2] = {&job->reference[0].image, &job->reference[1].image};
    job->parts = error_split(pictures, references, &job->mask);
    row->reference_spp = 2 * job->reference_samples;
    row->reference_cpu_s = job->reference[0].cpu_s + job->reference[1].cpu_s;
    row->reference_noise = job->parts.reference_noise;
    row->bdpt_spp = job->bdpt_samples;
    row->bdpt_cpu_s = job->bdpt.cpu_s;
    status = measure_picture(job, &job->bdpt.image, false, &row->bdpt_relmse, &row->bdpt_flip, error);
    return status ? status : measure_picture(job, &job->bdpt.image, true, &row->bdpt_relmse_whole, NULL, error);
}

static void measure_means(struct row_job *job) {
    double ours[3] = {0}, reference[3] = {0};
    for (size_t i = 0; i < (size_t)job->width * (size_t)job->height; i++) {
        if (!(job->mask.pixels[i * (size_t)job->mask.channels] > 0.5f)) continue;
        for (size_t c = 0; c < 3; c++) {
            for (int half = 0; half < 2; half++)
                ours[c] += 0.5 * (double)job->ours[half].image.pixels[i * (size_t)job->ours[half].image.channels + c];
            reference[c] += (double)job->reference_mean.pixels[3 * i + c];
        }
    }
    for (int c = 0; c < 3; c++) job->row->mean_error[c] = ours[c] / reference[c] - 1;
}

static void measure_bias(struct row_job *job) {
    struct table1_row *row = job->row;
    row->bias_spp = 2 * job->half_samples;
    row->bias_cpu_s = job->ours[0].cpu_s + job->ours[1].cpu_s;
    job->our_noise = job->parts.noise * row->bias_spp;
    job->our_cpu_s = row->bias_cpu_s / row->bias_spp;
    row->bias = job->parts.bias;
    row->bias_error = job->parts.bias_error;
    row->bias_share = fmax(row->bias, 0) / row->bdpt_relmse;
    row->noise_ratio = row->bdpt_relmse * row->bdpt_spp / job->our_noise;
    row->sample_cost_ratio = row->bdpt_cpu_s / row->bdpt_spp / job->our_cpu_s;
    row->unbiased_speedup = row->noise_ratio * row->sample_cost_ratio;
}

static enum status measure_fixed(struct row_job *job, struct error *error) {
    struct table1_row *row = job->row;
    struct long_render_result fixed = {0};
    enum status status = render(job, &(struct rendering){"ours_as_paper", true, 4, job->fixed_samples, NULL},
                                OUR_WORK * job->width * job->height * job->fixed_samples, &fixed, error);
    if (!status) status = measure_picture(job, &fixed.image, false, &row->fixed_relmse, &row->fixed_flip, error);
    if (!status) row->ours_worst_share = error_share_of_worst(&fixed.image, &job->reference_mean, &job->mask, false);
    row->fixed_spp = job->fixed_samples;
    row->fixed_cpu_s = fixed.cpu_s;
    row->fixed_speedup = row->bdpt_cpu_s / row->fixed_cpu_s;
    image_fini(&fixed.image);
    return status;
}

static enum status render_equal(struct row_job *job, int samples, struct error *error) {
    char name[TABLE1_NAME];
    image_fini(&job->equal.image);
    table1_equal_name(name, samples);
    enum status status = render(job, &(struct rendering){name, true, 3, samples, NULL}, 0, &job->equal, error);
    if (status) return status;
    struct table1_row *row = job->row;
    row->ours_spp = samples;
    row->ours_cpu_s = job->equal.cpu_s;
    return measure_picture(job, &job->equal.image, false, &row->ours_relmse, &row->ours_flip, error);
}

// The fewest samples that are as good as bdpt: starts a little below what the measured noise asks for and goes between
// too few and more than enough, each in one go, for its CPU seconds count. Gives up where more CPU seconds than bdpt's
// would be needed.
static enum status reach_bdpt(struct row_job *job, bool *reached, struct error *error) {
    const struct table1_row *row = job->row;
    const double bias = fmax(row->bias, 0), target = row->bdpt_relmse, most = row->bdpt_cpu_s / job->our_cpu_s;
    double samples = fmax(floor(0.9 * error_samples(job->our_noise, bias, target)), 1), too_few = 0, enough = INFINITY;
    enum status status = STATUS_OK;
    for (int step = 0; step < MAX_STEPS && samples <= most && samples > too_few && samples < enough; step++) {
        status = render_equal(job, (int)samples, error);
        if (status) return status;
        *(row->ours_relmse <= target ? &enough : &too_few) = samples;
        const double noise = fmax(row->ours_relmse - bias, 0) * samples;
        const double wanted = fmax(ceil(error_samples(noise, bias, target)), 1);
        if (samples == enough && wanted > CLOSE * samples) break;
        samples = fmin(wanted, 2 * samples);
        if (samples <= too_few || samples >= enough) samples = floor(0.5 * (too_few + fmin(enough, 4 * too_few)));
    }
    *reached = enough < INFINITY;
    return *reached && (int)row->ours_spp != (int)enough ? render_equal(job, (int)enough, error) : STATUS_OK;
}

static enum status measure_ours(struct row_job *job, struct error *error) {
    struct table1_row *row = job->row;
    bool reached;
    enum status status = reach_bdpt(job, &reached, error);
    if (!status && !reached) {
        // A bias that may be none is no reason to stop before bdpt's CPU seconds are used up.
        const double bias = row->bias > 2 * row->bias_error ? row->bias : 0, most = row->bdpt_cpu_s / job->our_cpu_s;
        const double even = floor(error_samples(job->our_noise, 0, bias));
        status = render_equal(job, (int)fmax(fmin(even, most), 1), error);
    }
    job->kit->done += OUR_WORK * job->width * job->height * job->fixed_samples; // a guess of what was needed
    if (!status) status = measure_picture(job, &job->equal.image, true, &row->ours_relmse_whole, NULL, error);
    const double share = reached ? 1 : row->bdpt_relmse / row->ours_relmse;
    row->common_bdpt_spp = row->bdpt_spp * share;
    row->common_bdpt_cpu_s = row->bdpt_cpu_s * share;
    row->common_speedup = row->common_bdpt_cpu_s / row->ours_cpu_s;
    row->speedup = reached ? row->common_speedup : (double)NAN;
    return status;
}

static enum status measure_files(struct row_job *job, struct error *error) {
    struct table1_row *row = job->row;
    char path[PATH_MAX];
    struct scene_files files;
    struct luminaire *luminaire;
    evidence_lamp(path, &job->kit->data, job->entry->lamp);
    enum status status = scene_files_measure(&files, path, NULL, 0, error);
    if (status) return status;
    row->geometry_bytes = (double)files.bytes;
    row->apl_bytes = APL_BYTES;
    evidence_baked(path, &job->kit->data, job->entry->lamp);
    status = luminaire_load(&luminaire, path, error);
    if (status) return status;
    row->file_bytes = (double)luminaire_bytes(luminaire);
    const char *evaluation = luminaire_metadata(luminaire, "bake.evaluation");
    json_t *measured = evaluation ? json_loads(evaluation, 0, NULL) : NULL;
    for (size_t c = 0; c < 3; c++) {
        const json_t *value = json_array_get(json_object_get(measured, "flux_error"), c);
        row->flux_error[c] = json_is_number(value) ? json_number_value(value) : (double)NAN;
    }
    json_decref(measured);
    luminaire_destroy(luminaire);
    return STATUS_OK;
}

enum status table1_measure(struct table1_kit *kit, const struct table1_entry *entry, struct table1_row *row,
                           struct error *error) {
    *row = (struct table1_row){
        .entry = entry, .target = round(10 * entry->paper_speedup), .paper_speedup = entry->paper_speedup};
    struct row_job job = row_job(kit, entry, row);
    row->width = job.width;
    row->height = job.height;
    enum status status = measure_files(&job, error);
    if (!status) status = render_halves(&job, error);
    if (!status) status = measure_bdpt(&job, error);
    if (!status) {
        measure_bias(&job);
        measure_means(&job);
    }
    if (!status) status = measure_fixed(&job, error);
    if (!status) status = measure_ours(&job, error);
    for (int i = 0; i < 2; i++) {
        image_fini(&job.ours[i].image);
        image_fini(&job.reference[i].image);
    }
    image_fini(&job.bdpt.image);
    image_fini(&job.equal.image);
    image_fini(&job.mask);
    image_fini(&job.reference_mean);
    return status;
}

void table1_limits(const struct table1_row *row, char *text, size_t size) {
    char reached[160], needs[160] = "";
    if (isnan(row->speedup))
        snprintf(reached, sizeof reached,
                 "bdpt's error was not reached in fewer CPU seconds; at relMSE %.4g %.3g times", row->ours_relmse,
                 row->common_speedup);
    else
        snprintf(reached, sizeof reached, "%.3g times of %g asked", row->speedup, row->target);
    if (row->unbiased_speedup < row->target)
        snprintf(needs, sizeof needs, "; CPU seconds x noise would have to be %.2g times less",
                 row->target / row->unbiased_speedup);
    snprintf(
        text, size,
        "%s. Bias is %.0f +- %.0f %% of bdpt's error; without it %.3g times (a sample has %.3g times less noise and "
        "costs %.3g times less)%s. A thousandth of the pixels has %.0f %% of our error and %.0f %% of bdpt's.",
        reached, 100 * row->bias / row->bdpt_relmse, 100 * row->bias_error / row->bdpt_relmse, row->unbiased_speedup,
        row->noise_ratio, row->sample_cost_ratio, needs, 100 * row->ours_worst_share, 100 * row->bdpt_worst_share);
}
