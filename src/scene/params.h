// Fills a plugin's struct from an object of the scene by the plugin's table of parameters (base/param.h).
#pragma once

#include "base/param.h"
#include "scene/commit.h"
#include "scene/texture.h"

// Makes the texture that `object` describes, or returns the one made before.
struct texture_maker {
    enum status (*make)(void *user, struct object *object, const struct texture **texture, struct error *error);
    void *user;
};

// Sets every field of `params` in `plugin`, a zeroed struct, from the object's properties and texture children, or from
// the fallback; marks what it read as used. Errors: wrong kind of value, out of range, unknown choice, missing.
// `except` (or NULL): parameters that this table declares too are left alone here.
// Absent transforms become the identity. Spectra of an emitter are emissions, all others reflectances. maker may be
// NULL where no parameter is a texture.
enum status params_read(void *plugin, const struct param *params, const struct param *except, struct object *object,
                        struct commit_context *context, const struct texture_maker *maker, struct error *error);

// Marks the properties whose names are in `names` (NULL at the end) as used: cosmetic ones of other renderers.
void params_ignore(const struct object *object, const char *const *names);

// An error for the first property that nothing has read, with the nearest name of the tables.
enum status params_check_properties(const struct object *object, const struct param *const *tables, size_t table_count,
                                    struct error *error);

// The same for settings that cannot change what the scene is: only what looks like a misspelt name of the table is an
// error, the rest a note.
enum status params_check_settings(const struct object *object, const struct param *const *tables, size_t table_count,
                                  const struct run *run, struct error *error);

// An error for the first property, or texture child, that nothing has read, with the nearest name of the tables (any
// may be NULL).
enum status params_check_used(const struct object *object, const struct param *const *tables, size_t table_count,
                              struct error *error);
