// The learning side of a bake: light field and transparency, fed chunk by chunk with freshly traced lines. What a chunk
// does depends on (seed, its index) and the state before it alone, so that a resumed bake gives the same file.
#pragma once

#include "bake/survey.h"

enum data_source {
    DATA_CAMERA, // guided camera lines
    DATA_PARTICLES, // particles for what is there, untraced guided lines for what is not
    DATA_BOTH, // camera lines and particles, half the weight each
};
extern const char *const data_source_names[3];

struct encoding_choice {
    const char *name;
    bool grid4, shells;
};
enum { ENCODING_CHOICES = 3 };
extern const struct encoding_choice encoding_choices[ENCODING_CHOICES];

struct light_recipe {
    enum data_source data;
    int encoding; // index in encoding_choices
    int log2_entries;
    enum light_loss loss;
    size_t chunks; // planned
};

struct light_training {
    const struct lamp *lamp;
    const struct survey *survey;
    const struct line_guide *guide;
    struct light_recipe recipe;
    enum gather_stream stream;
    struct light_field *field;
    float radiance_unit;
    struct line_sample *samples, *batch; // of one chunk; of one step
    size_t traced;
    double loss; // of the last chunk
};

enum { CHUNK_STEPS = 16, LIGHT_BATCH = 8192, TRANSPARENCY_BATCH = 4096 };

enum status light_training_create(struct light_training *training, const struct lamp *lamp, const struct survey *survey,
                                  const struct line_guide *guide, const struct light_recipe *recipe,
                                  enum gather_stream stream, struct error *error);
void light_training_destroy(struct light_training *training); // the field too, unless it was taken (set to NULL)
// CHUNK_STEPS optimiser steps on freshly traced lines.
enum status light_training_chunk(struct light_training *training, size_t chunk, struct error *error);

// Whether the transparency's hull errs at most half as much as a constant would on the lines that it answers itself:
// a hull of too few triangles for its lamp (a thousand feathers) is worse than none.
enum status transparency_fits_hull(const struct transparency *transparency, const struct lamp *lamp, bool *fits,
                                   struct error *error);
// The same for the transparency; `samples` has CHUNK_STEPS * TRANSPARENCY_BATCH slots.
// Returns how many lines it learned from.
size_t transparency_training_chunk(struct transparency *transparency, const struct lamp *lamp, size_t chunk,
                                   struct line_sample *samples, double *loss);

// Light that no training has seen. The score is the mean of -log(L_hat / its integral) over the flux of the exits: the
// cross entropy of the two light fields as distributions over lines. It is smallest for the true field, in any unit and
// for any scale of L_hat, and differences between two fields on the same held-out light have little noise.
struct held_out {
    struct exit_list exits;
    struct line_sample *lines; // guided, untraced
    size_t line_count;
};
enum status held_out_create(struct held_out *held_out, const struct lamp *lamp, const struct line_guide *guide,
                            size_t n, struct error *error);
void held_out_destroy(struct held_out *held_out);
enum status held_out_score(const struct held_out *held_out, const struct light_field *field, const struct lamp *lamp,
                           double *score, struct error *error);

// At least `least` guided lines with the field's light as if they were exits (exit_list_fini is the caller's, also
// after an error), the field's integral over all lines per channel and its relative standard error: of so many lines,
// or of up to `most`, as many as bring that error below 0.15 %.
enum status light_field_exits(const struct light_field *field, const struct lamp *lamp, const struct line_guide *guide,
                              size_t least, size_t most, struct exit_list *exits, double flux[3], double noise[3],
                              struct error *error);
