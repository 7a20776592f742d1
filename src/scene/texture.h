// Textures: colour over uv. texture_table lists every type.
#pragma once

#include "base/param.h"
#include "scene/commit.h"
#include "math/vec.h"

struct texture {
    const struct texture_type *type; // NULL: constant
    rgb value; // of a constant texture; of another, its mean
};

struct texture_type {
    const char *name, *help;
    const struct param *params;
    size_t size; // of the plugin's struct, which begins with struct texture
    // Called once after the parameters are read: loads files, fills `value`. NULL: nothing to do.
    enum status (*commit)(struct texture *texture, struct commit_context *context, struct error *error);
    rgb (*eval)(const struct texture *texture, vec2 uv);
    void (*fetch)(const struct texture *texture, vec2 uv); // asks the memory for what eval will read; NULL: nothing
};
extern const struct texture_type *const texture_table[]; // ends with NULL

static inline rgb texture_eval(const struct texture *t, vec2 uv) { return t->type ? t->type->eval(t, uv) : t->value; }
static inline float texture_eval_scalar(const struct texture *t, vec2 uv) { return rgb_mean(texture_eval(t, uv)); }
