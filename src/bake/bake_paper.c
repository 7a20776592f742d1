// Preset paper: the published networks learn from camera lines, one network after the other. Lines come from the guide
// with their weights, which leaves the published loss as it is in the mean. Measured on a frosted bulb, 60 s on one
// busy core, as the squared error of log(1 + L) over a black image's: 256 lines a step, each used once, 0.47 after 832
// steps; used 8 times, their places are learned by heart: 0.84 after 896. 1024 a step do worse than 256 in the same
// time (0.59, 0.25, at 16 traces); the published 16 pictures would take a CPU a minute. What is reached is measured and
// said, not repaired: the light is not scaled to the traced flux.
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bake/bake_job.h"
#include "bake/paper_data.h"
#include "base/parallel.h"

enum {
    LINE_BATCH = 256,
    VIEW_BATCH = 64,
    CHUNK_LINES = CHUNK_STEPS * LINE_BATCH, // each is used once
    VIEWS_A_CHUNK = 32,
    VIEW_STEPS = 64, // a chunk
    MOST_VIEWS = 1 << 14, // kept; then the oldest make room
    HELD_OUT_LINES = 2048,
    HELD_OUT_TRACES = 256,
    MOST_EVALUATED = 1 << 18, // lines of the last stage's evaluation
};
static const struct paper_plan {
    size_t transparency_chunks, view_chunks, light_chunks; // of CHUNK_STEPS, VIEW_STEPS and CHUNK_STEPS steps
} plans[] = {[BAKE_DRAFT] = {8, 12, 36}, [BAKE_STANDARD] = {90, 150, 400}, [BAKE_HIGH] = {1000, 1000, 5000}};
static const double transparency_time_share = 0.12, view_time_share = 0.15; // of a bake with --seconds
static const double score_period_s = 4, finish_surveys = 2.5; // the evaluation's tracing takes so many surveys

struct paper_job {
    struct bake_job *bake;
    struct line_sample *lines; // of one chunk
    struct paper_view *views, *view_batch; // the last MOST_VIEWS; of one step
    struct line_sample *held_out;
    float (*radiance)[3]; // of held_out
    size_t chunks; // done, of the network being trained
    double score, last_score_s;
};

// One network's training: what a chunk does, how many are planned, when time is up.
struct paper_stage {
    const char *name;
    enum paper_net net;
    size_t most, chunks; // samples a step; planned
    double stop_s; // clock_wall_s, or infinity
    void (*chunk)(struct paper_job *job, double *loss);
};

static void train_on_lines(struct paper_job *job, enum paper_net net, double *loss) {
    for (size_t step = 0; step < CHUNK_STEPS; step++)
        paper_train_lines(job->bake->paper, net, job->lines + step * LINE_BATCH, LINE_BATCH, job->bake->lamp.threads,
                          loss);
}

static void transparency_chunk(struct paper_job *job, double *loss) {
    gather_transmittance(job->lines, &job->bake->lamp, STREAM_TRANSPARENCY, job->chunks * CHUNK_LINES, CHUNK_LINES,
                         PAPER_TRANSMITTANCE_TRACES, 0, NULL);
    train_on_lines(job, PAPER_TRANSPARENCY, loss);
}

static void light_chunk(struct paper_job *job, double *loss) {
    paper_gather_lines(job->lines, &job->bake->lamp, job->bake->guide, STREAM_TRAINING, job->chunks * CHUNK_LINES,
                       CHUNK_LINES, PAPER_LINE_TRACES);
    job->bake->light.traced += (size_t)CHUNK_LINES * PAPER_LINE_TRACES;
    train_on_lines(job, PAPER_EVAL, loss);
}

// New pictures, then steps on random ones of all so far.
static void view_chunk(struct paper_job *job, double *loss) {
    struct bake_job *bake = job->bake;
    const size_t first = job->chunks * VIEWS_A_CHUNK;
    paper_gather_views(job->views + first % MOST_VIEWS, &bake->lamp, bake->paper, STREAM_TRAINING, first,
                       VIEWS_A_CHUNK);
    const size_t have = first + VIEWS_A_CHUNK < MOST_VIEWS ? first + VIEWS_A_CHUNK : MOST_VIEWS;
    uint64_t sample = job->chunks * VIEW_STEPS * VIEW_BATCH;
    for (size_t step = 0; step < VIEW_STEPS; step++) {
        for (size_t i = 0; i < VIEW_BATCH; i++) {
            struct sampler sampler = sampler_make(bake->lamp.seed, (uint64_t)STREAM_TRAINING << 56 | 6, sample++);
            size_t index = (size_t)((double)sampler_1d(&sampler) * (double)have);
            job->view_batch[i] = job->views[index < have ? index : have - 1];
        }
        paper_train_views(bake->paper, job->view_batch, VIEW_BATCH, bake->lamp.threads, loss);
    }
}

static void score_block(void *user, size_t block, int worker) {
    (void)worker;
    enum { SIZE = HELD_OUT_LINES / 16 };
    const struct paper_job *job = user;
    float point[SIZE][3], w[SIZE][3];
    for (size_t i = 0; i < SIZE; i++) {
        memcpy(point[i], job->held_out[block * SIZE + i].point, sizeof point[i]);
        memcpy(w[i], job->held_out[block * SIZE + i].w, sizeof w[i]);
    }
    paper_eval(job->bake->paper, SIZE, (const float(*)[3])point, (const float(*)[3])w, job->radiance + block * SIZE);
}

// The squared error of log(1 + L) on lines that were not trained, of the black image's.
static double held_out_error(struct paper_job *job) {
    double error = 0, black = 0;
    parallel_for(job->bake->lamp.threads, 16, score_block, job);
    for (size_t i = 0; i < HELD_OUT_LINES; i++) {
        const struct line_sample *line = &job->held_out[i];
        if (!(line->mass > 0)) continue;
        for (int c = 0; c < 3; c++) {
            float y = log1pf(line->target[c] / line->mass), difference = log1pf(job->radiance[i][c]) - y;
            error += (double)(line->mass * difference * difference);
            black += (double)(line->mass * y * y);
        }
    }
    return black > 0 ? error / black : 0;
}

static enum status train(struct paper_job *job, const struct paper_stage *stage, struct error *error) {
    struct bake_job *bake = job->bake;
    enum status status = paper_train_begin(bake->paper, stage->net, stage->most, bake->lamp.seed, error);
    if (status != STATUS_OK) return status;
    const double start = clock_wall_s();
    for (job->chunks = 0; job->chunks < stage->chunks; job->chunks++) {
        double now = clock_wall_s(), loss = 0;
        if (now >= stage->stop_s && job->chunks > 0) break;
        if (run_cancelled(bake->run)) {
            status = error_set(error, STATUS_CANCELLED, "cancelled; the preset 'paper' writes no checkpoints");
            break;
        }
        stage->chunk(job, &loss);
        char detail[96];
        if (stage->net == PAPER_EVAL) {
            if (now - job->last_score_s >= score_period_s) {
                job->last_score_s = now;
                job->score = held_out_error(job);
            }
            snprintf(detail, sizeof detail, "loss %.5f, held-out %.4f (black image 1)", loss, job->score);
        } else
            snprintf(detail, sizeof detail, "loss %.5f", loss);
        double fraction = isfinite(stage->stop_s) ? (now - start) / fmax(stage->stop_s - start, 1e-3)
                                                  : (double)(job->chunks + 1) / (double)stage->chunks;
        run_progress(bake->run, stage->name, fraction < 1 ? fraction : 1, clock_wall_s() - start, detail);
    }
    paper_train_end(bake->paper, stage->net);
    return status;
}

// What the queries of the evaluation will take.
static double evaluation_s(struct paper_job *job) {
    const struct evaluation_effort *effort = &job->bake->plan.evaluation;
    const double start = clock_wall_s();
    held_out_error(job);
    const double queries = (double)effort->lines + (double)effort->light_points * 3 * 4096;
    return (clock_wall_s() - start) / HELD_OUT_LINES * queries;
}

static enum status train_all(struct paper_job *job, struct error *error) {
    struct bake_job *bake = job->bake;
    const bool timed = bake->options->seconds > 0;
    const struct paper_plan *plan = &plans[bake->options->quality];
    const double reserve = finish_surveys * bake->survey_s + evaluation_s(job);
    const double now = clock_wall_s(), infinite = (double)INFINITY;
    const double stop = bake->deadline_s - fmin(reserve, 0.5 * bake->options->seconds);
    const double left = timed ? fmax(stop - now, 0) : 0;
    struct paper_stage stages[] = {
        {"transparency", PAPER_TRANSPARENCY, LINE_BATCH, plan->transparency_chunks,
         now + transparency_time_share * left, transparency_chunk},
        {"sampling", PAPER_SAMPLING, VIEW_BATCH, plan->view_chunks,
         now + (transparency_time_share + view_time_share) * left, view_chunk},
        {"training", PAPER_EVAL, LINE_BATCH, plan->light_chunks, stop, light_chunk},
    };
    enum status status = STATUS_OK;
    for (size_t i = 0; i < sizeof stages / sizeof *stages && status == STATUS_OK; i++) {
        if (timed)
            stages[i].chunks = SIZE_MAX;
        else
            stages[i].stop_s = infinite;
        status = train(job, &stages[i], error);
    }
    if (status != STATUS_OK) return status;
    bake->checkpoint.light_chunks = job->chunks;
    job->score = held_out_error(job);
    run_note(bake->run,
             "preset paper: after %.2f million lines of %d traces and %zu steps the squared error of log(1 + L) on "
             "held-out lines is %.3f of a black image's (published: 27 to 39 hours on a GPU)",
             1e-6 * (double)(job->chunks * CHUNK_LINES), PAPER_LINE_TRACES, job->chunks * CHUNK_STEPS, job->score);
    return STATUS_OK;
}

enum status bake_train_paper(struct bake_job *job, struct error *error) {
    if (!bake_camera_sees_all(&job->scene))
        return error_set(error, STATUS_UNSUPPORTED,
                         "%s: the preset 'paper' learns from camera lines, which never meet a point light; give the "
                         "lamp's emitters a size, or use the preset 'compact'",
                         job->scene.path);
    struct evaluation_effort *effort = &job->plan.evaluation;
    if (effort->lines > MOST_EVALUATED) effort->lines = MOST_EVALUATED;
    if (effort->light_points > 16) effort->light_points = 16;
    struct paper_job paper = {.bake = job, .score = NAN, .last_score_s = -(double)INFINITY};
    paper.lines = malloc(CHUNK_LINES * sizeof *paper.lines);
    paper.views = malloc(MOST_VIEWS * sizeof *paper.views);
    paper.view_batch = malloc(VIEW_BATCH * sizeof *paper.view_batch);
    paper.held_out = malloc(HELD_OUT_LINES * sizeof *paper.held_out);
    paper.radiance = malloc(HELD_OUT_LINES * sizeof *paper.radiance);
    enum status status = paper.lines && paper.views && paper.view_batch && paper.held_out && paper.radiance
                             ? paper_create(&job->paper, &job->lamp.proxy, error)
                             : error_set(error, STATUS_MEMORY, "out of memory for the training samples");
    if (status == STATUS_OK) {
        paper_gather_lines(paper.held_out, &job->lamp, job->guide, STREAM_HELD_OUT, 0, HELD_OUT_LINES, HELD_OUT_TRACES);
        status = train_all(&paper, error);
    }
    free(paper.lines);
    free(paper.views);
    free(paper.view_batch);
    free(paper.held_out);
    free(paper.radiance);
    return status;
}
