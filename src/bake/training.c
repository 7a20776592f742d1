// Composition of the batches. With n the size of a batch, an estimator of the loss (build.h) is a mean over it: lines
// drawn with density p get n / (their number * p), an exit of flux y gets n / (particles emitted for the batch) * y.
// DATA_BOTH lets the camera lines carry the whole mass and half the target, and the exits the other half of the target.
#include "bake/training.h"

#include <stdlib.h>
#include <string.h>

const char *const data_source_names[3] = {"camera", "particles", "both"};
const struct encoding_choice encoding_choices[ENCODING_CHOICES] = {
    {"grid4", true, false}, {"shells", false, true}, {"grid4+shells", true, true}};

static const double least_exit_rate = 0.05; // of darker lamps a step has fewer exits than lines
enum { HULL_LINES = 1 << 14 };
enum { MOST_PER_STEP = LIGHT_BATCH + 10 * LIGHT_BATCH + CHUNK_STEPS }; // were every particle of a step to come out
static const float anchor_reach = 0.1f; // [proxy radius]

static enum status create_field(struct light_training *training, struct error *error) {
    const struct survey *survey = training->survey;
    const struct proxy *proxy = &training->lamp->proxy;
    const struct encoding_choice *encoding = &encoding_choices[training->recipe.encoding];
    float anchors[SURVEY_CLUSTERS][3], largest = 0;
    for (size_t i = 0; i < survey->cluster_count; i++) {
        memcpy(anchors[i], &survey->clusters[i].center, sizeof anchors[i]);
        largest = fmaxf(largest, survey->clusters[i].radius);
    }
    double flux = (survey->flux[0] + survey->flux[1] + survey->flux[2]) / 3;
    training->radiance_unit = (float)(flux / (double)LINE_MEASURE(proxy->radius));
    struct light_field_options options = {
        .proxy = *proxy,
        .anchors = (const float(*)[3])anchors,
        .anchor_count = survey->cluster_count,
        .anchor_radius = fmaxf(anchor_reach * proxy->radius, 1.5f * largest),
        .shell_radii = survey->shell_radii,
        .shell_count = encoding->shells ? survey->shell_count : 0,
        .use_grid4 = encoding->grid4 || survey->shell_count == 0,
        .radiance_unit = training->radiance_unit,
        .log2_entries = training->recipe.log2_entries,
        .loss = training->recipe.loss,
        .steps = training->recipe.chunks * CHUNK_STEPS,
        .seed = training->lamp->seed,
    };
    return light_field_create(&training->field, &options, error);
}

enum status light_training_create(struct light_training *training, const struct lamp *lamp, const struct survey *survey,
                                  const struct line_guide *guide, const struct light_recipe *recipe,
                                  enum gather_stream stream, struct error *error) {
    *training =
        (struct light_training){.lamp = lamp, .survey = survey, .guide = guide, .recipe = *recipe, .stream = stream};
    training->samples = malloc((size_t)CHUNK_STEPS * LIGHT_BATCH * sizeof *training->samples);
    training->batch = malloc(MOST_PER_STEP * sizeof *training->batch);
    enum status status = training->samples && training->batch
                             ? create_field(training, error)
                             : error_set(error, STATUS_MEMORY, "out of memory for the training samples");
    if (status != STATUS_OK) light_training_destroy(training);
    return status;
}

void light_training_destroy(struct light_training *training) {
    light_field_destroy(training->field);
    free(training->samples);
    free(training->batch);
    *training = (struct light_training){0};
}

// Lines first, exits after them, normalised as build.h wants it.
static size_t compose_batch(struct light_training *training, const struct line_sample *lines, size_t line_count,
                            const struct line_exit *exits, size_t exit_count, double emitted, float exit_share) {
    const double measure = (double)LINE_MEASURE(training->lamp->proxy.radius);
    const float mass_scale = (float)(1 / ((double)line_count * measure));
    const float target_scale = (1 - exit_share) * mass_scale / training->radiance_unit;
    const float exit_scale = exit_share * (float)(1 / (emitted * measure * (double)training->radiance_unit));
    for (size_t i = 0; i < line_count; i++) {
        struct line_sample *to = &training->batch[i];
        *to = lines[i];
        to->mass *= mass_scale;
        for (int c = 0; c < 3; c++) to->target[c] *= target_scale;
    }
    for (size_t i = 0; i < exit_count; i++) {
        struct line_sample *to = &training->batch[line_count + i];
        memcpy(to->point, exits[i].point, sizeof to->point);
        memcpy(to->w, exits[i].w, sizeof to->w);
        to->mass = 0;
        for (int c = 0; c < 3; c++) to->target[c] = exits[i].flux[c] * exit_scale;
    }
    return line_count + exit_count;
}

// Of chunk `chunk`. The survey's exits serve the first chunks: they are traced already.
static enum status chunk_exits(struct light_training *training, size_t chunk, struct exit_list *exits, bool *lent,
                               struct error *error) {
    const struct exit_list *survey = &training->survey->exits;
    double exit_rate = fmax(least_exit_rate, (double)training->survey->exit_rate);
    size_t particles = (size_t)((double)(LIGHT_BATCH / 2 * CHUNK_STEPS) / exit_rate);
    *lent = training->stream == STREAM_TRAINING && (chunk + 1) * particles <= survey->emitted;
    if (*lent) {
        double per_particle = (double)survey->count / (double)survey->emitted;
        size_t first = (size_t)(per_particle * (double)(chunk * particles));
        size_t last = (size_t)(per_particle * (double)((chunk + 1) * particles));
        *exits = (struct exit_list){.exits = survey->exits + first, .count = last - first, .emitted = particles};
        return STATUS_OK;
    }
    training->traced += particles;
    return gather_exits(exits, training->lamp, training->stream, chunk * particles, particles, false, NULL, error);
}

enum status light_training_chunk(struct light_training *training, size_t chunk, struct error *error) {
    const enum data_source data = training->recipe.data;
    const size_t line_count = data == DATA_CAMERA ? LIGHT_BATCH : LIGHT_BATCH / 2;
    const size_t all_lines = line_count * CHUNK_STEPS;
    const float exit_share = data == DATA_CAMERA ? 0 : data == DATA_PARTICLES ? 1 : 0.5f;
    struct exit_list exits = {0};
    bool lent = true;
    if (data != DATA_CAMERA) {
        enum status status = chunk_exits(training, chunk, &exits, &lent, error);
        if (status != STATUS_OK) return status;
    }
    gather_lines(training->samples, training->lamp, training->guide, training->stream, chunk * all_lines, all_lines,
                 data != DATA_PARTICLES);
    if (data != DATA_PARTICLES) training->traced += all_lines;
    training->loss = 0;
    for (size_t step = 0; step < CHUNK_STEPS; step++) {
        size_t first = exits.count * step / CHUNK_STEPS, last = exits.count * (step + 1) / CHUNK_STEPS;
        size_t n = compose_batch(training, training->samples + step * line_count, line_count, exits.exits + first,
                                 last - first, (double)exits.emitted / CHUNK_STEPS, exit_share);
        double loss;
        light_field_train(training->field, training->batch, n, training->lamp->threads, &loss);
        training->loss += loss / CHUNK_STEPS;
    }
    if (!lent) exit_list_fini(&exits);
    return STATUS_OK;
}

enum status transparency_fits_hull(const struct transparency *transparency, const struct lamp *lamp, bool *fits,
                                   struct error *error) {
    struct line_sample *lines = malloc(HULL_LINES * sizeof *lines);
    if (!lines) return error_set(error, STATUS_MEMORY, "out of memory for the hull's check");
    gather_transmittance(lines, lamp, STREAM_TRANSPARENCY, 0, HULL_LINES, 1, 1, NULL);
    double wrong = 0, sum = 0, count = 0;
    for (size_t i = 0; i < HULL_LINES; i++) {
        if (transparency_learns(transparency, lines[i].point, lines[i].w)) continue;
        float t[3];
        transparency_eval(transparency, 1, &lines[i].point, &lines[i].w, &t);
        wrong += fabs((double)(t[1] - lines[i].target[1]));
        sum += (double)lines[i].target[1];
        count++;
    }
    free(lines);
    *fits = wrong <= 0.5 * 2 * sum * (1 - sum / fmax(count, 1));
    return STATUS_OK;
}

size_t transparency_training_chunk(struct transparency *transparency, const struct lamp *lamp, size_t chunk,
                                   struct line_sample *samples, double *loss) {
    const size_t n = (size_t)CHUNK_STEPS * TRANSPARENCY_BATCH;
    gather_transmittance(samples, lamp, STREAM_TRANSPARENCY, chunk * n, n, 1, 0, transparency);
    size_t count = 0;
    for (size_t i = 0; i < n; i++)
        if (samples[i].mass > 0) samples[count++] = samples[i];
    *loss = 0;
    for (size_t step = 0; step < CHUNK_STEPS; step++) {
        const size_t first = count * step / CHUNK_STEPS, last = count * (step + 1) / CHUNK_STEPS;
        if (first == last) continue;
        double step_loss;
        transparency_train(transparency, samples + first, last - first, lamp->threads, &step_loss);
        *loss += step_loss / CHUNK_STEPS;
    }
    return count;
}
