// Groups of emitters: the light is the sum of theirs, light samples are a mixture of their densities.
#include <stdlib.h>
#include <string.h>

#include "luminaire/group_setting.h"
#include "luminaire/luminaire_private.h"

enum { BLOCK = 256 };

void luminaire_derive(struct luminaire *luminaire) {
    float sum = 0;
    memset(luminaire->flux, 0, sizeof luminaire->flux);
    for (int g = 0; g < luminaire->emission_count; g++) {
        luminaire->share[g] = 0;
        for (int c = 0; c < 3; c++) { // all channels count alike, so that no colour goes unsampled
            float flux = luminaire->factor[g][c] * luminaire->emissions[g].flux[c];
            luminaire->flux[c] += flux;
            luminaire->share[g] += flux;
        }
        sum += luminaire->share[g];
    }
    for (int g = 0; g < luminaire->emission_count; g++)
        luminaire->share[g] = sum > 0 ? luminaire->share[g] / sum : g == 0 ? 1.0f : 0.0f;
}

size_t luminaire_group_count(const struct luminaire *luminaire) {
    return luminaire->grouped ? (size_t)luminaire->emission_count : 0;
}

const char *luminaire_group(const struct luminaire *luminaire, size_t index, float flux[3]) {
    const struct emission *emission = &luminaire->emissions[index];
    if (flux) memcpy(flux, emission->flux, sizeof emission->flux);
    return emission->name;
}

enum status luminaire_dim(struct luminaire **dimmed, const struct luminaire *original, const float (*factors)[3],
                          struct error *error) {
    struct luminaire *l = *dimmed = malloc(sizeof *l);
    if (!l) return error_set(error, STATUS_MEMORY, "out of memory for a luminaire");
    memcpy(l, original, sizeof *l);
    l->borrowed = true;
    for (int g = 0; g < l->emission_count; g++)
        for (int c = 0; c < 3; c++) l->factor[g][c] *= factors[g][c];
    luminaire_derive(l);
    return STATUS_OK;
}

enum status luminaire_add_group(struct luminaire *luminaire, struct light_field *field,
                                struct sampling_density *density, struct view_field *view, const float flux[3],
                                struct error *error) {
    enum status status = STATUS_OK;
    if (luminaire->emission_count == LUMINAIRE_MAX_GROUPS)
        status = error_set(error, STATUS_INVALID, "a luminaire has at most %d groups", LUMINAIRE_MAX_GROUPS);
    if (!status) status = field_net_finish(&field->net, error);
    if (!status && view) status = view_field_finish(view, error);
    if (status) {
        light_field_destroy(field);
        sampling_density_destroy(density);
        view_field_destroy(view);
        return status;
    }
    int g = luminaire->emission_count++;
    luminaire->emissions[g] =
        (struct emission){.light = field, .density = density, .view = view, .flux = {flux[0], flux[1], flux[2]}};
    for (int c = 0; c < 3; c++) luminaire->factor[g][c] = 1;
    luminaire_derive(luminaire);
    luminaire->bytes = luminaire_measure(luminaire);
    return STATUS_OK;
}

enum status luminaire_name_groups(struct luminaire *luminaire, const char *const *names, struct error *error) {
    for (int g = 0; g < luminaire->emission_count; g++) {
        enum status status = group_name_check(names[g], error);
        if (status) return status;
        for (int other = 0; other < g; other++)
            if (!strcmp(names[g], names[other]))
                return error_set(error, STATUS_INVALID, "two groups have the name '%s'", names[g]);
        memcpy(luminaire->emissions[g].name, names[g], strlen(names[g]) + 1);
    }
    luminaire->grouped = true;
    return STATUS_OK;
}

enum status luminaire_group_factors(const struct luminaire *luminaire, const char *text, float length,
                                    float factors[LUMINAIRE_MAX_GROUPS][3], struct error *error) {
    struct group_light lights[LUMINAIRE_MAX_GROUPS] = {{.name = NULL}};
    const size_t count = (size_t)luminaire->emission_count;
    for (size_t g = 0; g < count; g++) {
        const struct emission *emission = &luminaire->emissions[g];
        lights[g].name = luminaire->grouped ? emission->name : NULL;
        for (int c = 0; c < 3; c++) {
            lights[g].flux[c] = emission->flux[c] * luminaire->factor[g][c] * length * length;
            lights[g].factor[c] = 1;
        }
    }
    enum status status = group_settings_apply(text, lights, count, error);
    for (size_t g = 0; g < count; g++) memcpy(factors[g], lights[g].factor, sizeof lights[g].factor);
    return status;
}

static void scale_light(const struct luminaire *luminaire, int group, size_t n, float (*radiance)[3]) {
    const float *factor = luminaire->factor[group];
    if (factor[0] == 1 && factor[1] == 1 && factor[2] == 1) return;
    for (size_t i = 0; i < n; i++)
        for (int c = 0; c < 3; c++) radiance[i][c] *= factor[c];
}

static bool is_dark(const struct luminaire *luminaire, int group) {
    const float *factor = luminaire->factor[group];
    return !(factor[0] > 0 || factor[1] > 0 || factor[2] > 0);
}

typedef void group_query(const struct luminaire *luminaire, int group, size_t n, const void *lines,
                         float (*radiance)[3]);

// The sum over the groups of what `query` answers, block by block.
static void sum_groups(const struct luminaire *luminaire, group_query *query, size_t n, const void *lines,
                       float (*radiance)[3]) {
    float one[BLOCK][3];
    bool first = true;
    for (int g = 0; g < luminaire->emission_count; g++) {
        if (is_dark(luminaire, g)) continue;
        query(luminaire, g, n, lines, first ? radiance : one);
        scale_light(luminaire, g, n, first ? radiance : one);
        for (size_t i = 0; !first && i < n; i++)
            for (int c = 0; c < 3; c++) radiance[i][c] += one[i][c];
        first = false;
    }
    if (first) memset(radiance, 0, n * sizeof *radiance);
}

struct light_lines {
    const float (*point)[3], (*w)[3];
};

static void query_light(const struct luminaire *luminaire, int group, size_t n, const void *lines,
                        float (*radiance)[3]) {
    const struct light_lines *light = lines;
    if (luminaire->paper)
        paper_eval(luminaire->paper, n, light->point, light->w, radiance);
    else
        light_field_eval(luminaire->emissions[group].light, n, light->point, light->w, radiance);
}

void luminaire_eval_met(const struct luminaire *luminaire, size_t n, const float (*point)[3], const float (*w)[3],
                        float (*radiance)[3]) {
    const size_t block = luminaire->emission_count > 1 ? BLOCK : n;
    for (size_t first = 0; first < n; first += block) {
        const struct light_lines lines = {point + first, w + first};
        sum_groups(luminaire, query_light, n - first < block ? n - first : block, &lines, radiance + first);
    }
}

static void query_view(const struct luminaire *luminaire, int group, size_t n, const void *lines,
                       float (*radiance)[3]) {
    view_field_eval(luminaire->emissions[group].view, n, lines, radiance);
}

void luminaire_view(const struct luminaire *luminaire, size_t n, const struct view_point *points,
                    float (*radiance)[3]) {
    const size_t block = luminaire->emission_count > 1 ? BLOCK : n;
    for (size_t first = 0; first < n; first += block)
        sum_groups(luminaire, query_view, n - first < block ? n - first : block, points + first, radiance + first);
}

static int only_group(const struct luminaire *luminaire) { // that is sampled, or -1
    for (int g = 0; g < luminaire->emission_count; g++)
        if (luminaire->share[g] == 1) return g;
    return -1;
}

// The first number chooses the group and is then stretched to [0,1) again.
static int choose_group(const struct luminaire *luminaire, float *u) {
    int last = 0;
    float at = *u;
    for (int g = 0; g < luminaire->emission_count; g++) {
        if (!(luminaire->share[g] > 0)) continue;
        last = g;
        if (at < luminaire->share[g]) break;
        at -= luminaire->share[g];
    }
    at /= luminaire->share[last];
    *u = at < 0x1.fffffep-1f ? at : 0x1.fffffep-1f;
    return last;
}

static void sample_block(const struct luminaire *luminaire, size_t n, const float (*s)[3], const float (*u)[3],
                         float (*direction)[3], float *pdf_sa) {
    float points[BLOCK][3], numbers[BLOCK][3], found[BLOCK][3], own[BLOCK], stretched[BLOCK];
    int group[BLOCK];
    size_t slot[BLOCK];
    for (size_t i = 0; i < n; i++) {
        stretched[i] = u[i][0];
        group[i] = choose_group(luminaire, &stretched[i]);
    }
    for (int g = 0; g < luminaire->emission_count; g++) {
        size_t count = 0;
        for (size_t i = 0; i < n; i++) {
            if (group[i] != g) continue;
            memcpy(points[count], s[i], sizeof points[count]);
            memcpy(numbers[count], (float[3]){stretched[i], u[i][1], u[i][2]}, sizeof numbers[count]);
            slot[count++] = i;
        }
        if (!count) continue;
        sampling_sample_batch(luminaire->emissions[g].density, count, (const float(*)[3])points,
                              (const float(*)[3])numbers, found, own);
        for (size_t k = 0; k < count; k++) memcpy(direction[slot[k]], found[k], sizeof found[k]);
    }
    luminaire_pdf(luminaire, n, s, (const float(*)[3])direction, pdf_sa);
}

void luminaire_sample(const struct luminaire *luminaire, size_t n, const float (*s)[3], const float (*u)[3],
                      float (*direction)[3], float *pdf_sa) {
    const int only = only_group(luminaire);
    if (luminaire->paper)
        paper_sample(luminaire->paper, n, s, u, direction, pdf_sa);
    else if (only >= 0)
        sampling_sample_batch(luminaire->emissions[only].density, n, s, u, direction, pdf_sa);
    else
        for (size_t first = 0; first < n; first += BLOCK)
            sample_block(luminaire, n - first < BLOCK ? n - first : BLOCK, s + first, u + first, direction + first,
                         pdf_sa + first);
}

void luminaire_pdf(const struct luminaire *luminaire, size_t n, const float (*s)[3], const float (*direction)[3],
                   float *pdf_sa) {
    const int only = only_group(luminaire);
    if (luminaire->paper) {
        paper_pdf(luminaire->paper, n, s, direction, pdf_sa);
        return;
    }
    if (only >= 0) {
        sampling_pdf_batch(luminaire->emissions[only].density, n, s, direction, pdf_sa);
        return;
    }
    for (size_t first = 0; first < n; first += BLOCK) {
        const size_t count = n - first < BLOCK ? n - first : BLOCK;
        float one[BLOCK];
        memset(pdf_sa + first, 0, count * sizeof *pdf_sa);
        for (int g = 0; g < luminaire->emission_count; g++) {
            if (!(luminaire->share[g] > 0)) continue;
            sampling_pdf_batch(luminaire->emissions[g].density, count, s + first, direction + first, one);
            for (size_t i = 0; i < count; i++) pdf_sa[first + i] += luminaire->share[g] * one[i];
        }
    }
}
