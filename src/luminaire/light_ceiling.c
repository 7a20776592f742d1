// The ceiling of a light field. Light that comes straight from an emitter is drawn by the cones about its anchor. All
// other light has been bent or scattered, and the tables cannot resolve a bulb's image in a crystal: where they show it
// nearly as bright as the bulb, they repeat one exit that training has shown them. On a lamp of 238 crystals 0.07 % of
// the light samples, with 1.5 % of the flux, had 43 % of the second moment (docs/experiments.md).
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"
#include "luminaire/light_field.h"
#include "luminaire/sampling_sums.h"

enum { BLOCK = 4096 };
static const double most_of_bent = 0.05; // of the light that passes all anchors
static const double most_left = 0.7; // of its second moment, where a ceiling is worth its flux

struct bent_line { // passes every anchor beyond the cones
    float radiance, flux; // means of the channels; the flux is 0 for all other lines
    size_t exit;
};

struct bent_job {
    const struct light_field *field;
    const struct sampling_density *density;
    const struct line_exit *exits;
    size_t count;
    struct bent_line *lines;
};

static void find_block(void *user, size_t block, int worker) {
    (void)worker;
    const struct bent_job *job = user;
    const size_t begin = block * BLOCK, n = job->count - begin < BLOCK ? job->count - begin : BLOCK;
    float point[BLOCK][3], w[BLOCK][3], radiance[BLOCK][3];
    for (size_t i = 0; i < n; i++) {
        memcpy(point[i], job->exits[begin + i].point, sizeof point[i]);
        memcpy(w[i], job->exits[begin + i].w, sizeof w[i]);
    }
    light_field_eval(job->field, n, (const float(*)[3])point, (const float(*)[3])w, radiance);
    for (size_t i = 0; i < n; i++) {
        const struct line_exit *exit = &job->exits[begin + i];
        const int anchor = sampling_anchor_of(job->density, vec3_from(point[i]), vec3_from(w[i]));
        job->lines[begin + i] =
            (struct bent_line){sampling_mean(radiance[i]), anchor < 0 ? sampling_mean(exit->flux) : 0, begin + i};
    }
}

static int brighter_first(const void *a, const void *b) {
    const struct bent_line *x = a, *y = b;
    if (x->radiance != y->radiance) return x->radiance < y->radiance ? 1 : -1;
    return x->exit < y->exit ? -1 : x->exit > y->exit;
}

// The radiance c above which the lines have `share` more flux than c of each would be; 0: it is not worth its flux, for
// the second moment of their light hardly falls.
static float find_ceiling(const struct bent_line *lines, size_t count, double share) {
    double above = 0, lines_above = 0, second_above = 0, second = 0; // flux, flux over radiance, flux times radiance
    float ceiling = 0;
    for (size_t i = 0; i < count; i++) second += (double)(lines[i].flux * lines[i].radiance);
    for (size_t i = 0; i < count && lines[i].radiance > 0 && !(ceiling > 0); i++) {
        if (lines_above > 0 && above - lines_above * (double)lines[i].radiance >= share)
            ceiling = (float)((above - share) / lines_above);
        else {
            above += (double)lines[i].flux;
            lines_above += (double)(lines[i].flux / lines[i].radiance);
            second_above += (double)(lines[i].flux * lines[i].radiance);
        }
    }
    const double left = second - second_above + lines_above * (double)ceiling * (double)ceiling;
    return left < most_left * second ? ceiling : 0;
}

// What of the exits' flux a ceiling leaves, by channel.
static void find_left(const struct line_exit *exits, size_t exit_count, const struct bent_line *lines, size_t count,
                      float ceiling, double left[3]) {
    double before[3] = {0}, lost[3] = {0};
    for (size_t i = 0; i < exit_count; i++)
        for (int c = 0; c < 3; c++) before[c] += (double)exits[i].flux[c];
    for (size_t i = 0; i < count && lines[i].radiance > ceiling; i++)
        for (int c = 0; c < 3; c++)
            lost[c] += (double)exits[lines[i].exit].flux[c] * (1 - (double)(ceiling / lines[i].radiance));
    for (int c = 0; c < 3; c++) left[c] = before[c] > 0 ? 1 - lost[c] / before[c] : 1;
}

enum status light_field_fit_ceiling(struct light_field *field, const struct sampling_density *density,
                                    const struct line_exit *exits, size_t exit_count, int threads, double left[3],
                                    struct error *error) {
    const struct encoding_options *options = &field->net.encoding.options;
    left[0] = left[1] = left[2] = 1;
    if (options->anchor_count == 0 || density->anchor_count == 0) return STATUS_OK;
    struct bent_line *lines = malloc((exit_count + 1) * sizeof *lines);
    if (!lines) return error_set(error, STATUS_MEMORY, "out of memory for the ceiling of a light field");
    struct bent_job job = {field, density, exits, exit_count, lines};
    parallel_for(threads, (exit_count + BLOCK - 1) / BLOCK, find_block, &job);
    double all = 0, bent = 0;
    size_t count = 0;
    for (size_t i = 0; i < exit_count; i++) {
        all += (double)sampling_mean(exits[i].flux);
        bent += (double)lines[i].flux;
        if (lines[i].flux > 0) lines[count++] = lines[i];
    }
    qsort(lines, count, sizeof *lines, brighter_first);
    const float ceiling = find_ceiling(lines, count, fmin(LIGHT_CEILING_SHARE * all, most_of_bent * bent));
    if (ceiling > 0) {
        find_left(exits, exit_count, lines, count, ceiling, left);
        field->ceiling_offset = density->cone_radius[CONE_COUNT - 1] / (options->anchor_radius * field->net.radius);
        field->ceiling = ceiling / field->radiance_unit;
    }
    free(lines);
    return STATUS_OK;
}
