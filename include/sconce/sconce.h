// sconce: bakes complicated lamps into compact neural light-field emitters, and renders rooms with them.
//
// Conventions of every function here:
// - Lengths are in the file's own unit; colours are linear Rec. 709; radiance is in the unit of the scene's emitters
//   (W/(m^2 sr) where lengths are metres and the emitters say so).
// - A function that can fail returns a status and, where it is not SCONCE_OK, has filled *error (NULL is allowed).
//   Texts are "file:line:column: what is wrong; what to do".
// - Nothing is printed, nothing exits, there are no mutable globals. Calls on different objects may run on different
//   threads; what is said to be thread-safe may also share one object.
// - Strings and arrays that come back in a struct belong to the caller where the comment says "free()".
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define SCONCE_API __attribute__((visibility("default")))

enum sconce_status {
    SCONCE_OK = 0,
    SCONCE_INVALID, // the input is wrong
    SCONCE_IO, // a file could not be read or written
    SCONCE_MEMORY, // an allocation failed
    SCONCE_CANCELLED, // cancelled() said so; what was finished is on disk and usable
    SCONCE_UNSUPPORTED, // correct input that this version cannot serve
};

struct sconce_error {
    enum sconce_status status;
    char text[1000];
};

struct sconce_progress {
    const char *stage; // "tracing", "training", ...
    double fraction; // done, 0..1
    double elapsed_s; // since the stage began
    double eta_s; // seconds left, < 0 when unknown
    const char *detail; // or NULL
};

// What a long call needs from its caller. A zeroed struct is fine: all cores, seed 0, silence.
struct sconce_run {
    int threads; // <= 0: all cores
    uint64_t seed; // every random number is a pure function of it; results do not depend on `threads`
    void (*message)(void *user, bool warning, const char *text);
    void (*progress)(void *user, const struct sconce_progress *progress);
    bool (*cancelled)(void *user); // polled a few times a second from the calling thread
    void *user;
};

// name=value for the $name of a scene file.
struct sconce_definition {
    const char *name, *value;
};

SCONCE_API const char *sconce_version(void);

// ---- A baked luminaire: four calls are all that a renderer needs ------------------------------------------------
// Zhu et al. 2021, "Neural Complex Luminaires", sections 3 and 5. Coordinates are the lamp's own. A line is given by
// any point on it and the unit direction w in which light travels along it. Arrays are n times three floats.

struct sconce_luminaire;

// Errors: the file is missing, truncated, of another format version, or inconsistent. sconce_luminaire_close frees it.
SCONCE_API enum sconce_status sconce_luminaire_open(struct sconce_luminaire **luminaire, const char *path,
                                                    struct sconce_error *error);
SCONCE_API void sconce_luminaire_close(struct sconce_luminaire *luminaire); // NULL is allowed

// Where the proxy is: its bounding sphere [length], and where the line origin + t direction crosses the proxy
// (t_near <= t_far, either may be negative); false: it misses. Thread-safe.
SCONCE_API void sconce_luminaire_bounds(const struct sconce_luminaire *luminaire, float center[3], float *radius);
SCONCE_API bool sconce_luminaire_span(const struct sconce_luminaire *luminaire, const float origin[3],
                                      const float direction[3], float *t_near, float *t_far);

// Radiance L >= 0 of the lamp along each line; 0 where the line misses the proxy. Thread-safe, does no checks.
SCONCE_API void sconce_luminaire_eval(const struct sconce_luminaire *luminaire, size_t n, const float (*point)[3],
                                      const float (*w)[3], float (*radiance)[3]);
// Fraction T in [0,1] of the light behind the lamp that gets straight through; 1 where the line misses. Thread-safe.
SCONCE_API void sconce_luminaire_transmittance(const struct sconce_luminaire *luminaire, size_t n,
                                               const float (*point)[3], const float (*w)[3], float (*transmittance)[3]);
// Directions from shading points s (outside or inside the proxy) towards the lamp, and their density per solid angle
// [1/sr]. u: three random numbers in [0,1) each. The light then travels along -direction: the estimate of the
// irradiance at s is L(s, -direction) cos / pdf_sa. pdf_sa > 0 wherever the proxy's bounding sphere is seen.
// Thread-safe.
SCONCE_API void sconce_luminaire_sample(const struct sconce_luminaire *luminaire, size_t n, const float (*s)[3],
                                        const float (*u)[3], float (*direction)[3], float *pdf_sa);
SCONCE_API void sconce_luminaire_pdf(const struct sconce_luminaire *luminaire, size_t n, const float (*s)[3],
                                     const float (*direction)[3], float *pdf_sa);
// What the lamp does to the room's light that meets it from all sides and is not let through (1 - T): the shares that
// it scatters back and onward, in [0,1]; the rest is absorbed. sconce's path tracer lets (1 - T) of a ray scatter so,
// by a cosine, at the middle of the chord between t_near and t_far; 0 in files of versions that did not measure it.
SCONCE_API void sconce_luminaire_scattering(const struct sconce_luminaire *luminaire, float back[3], float onward[3]);
// Total emitted flux per channel. Metadata by key (docs/luminaire-format.md), NULL where absent; owned by the
// luminaire.
SCONCE_API void sconce_luminaire_flux(const struct sconce_luminaire *luminaire, float flux[3]);
SCONCE_API const char *sconce_luminaire_metadata(const struct sconce_luminaire *luminaire, const char *key);
// Groups of emitters that were baked separately: the name of the index-th, NULL past the last (or where there are
// none), owned by the luminaire; flux (or NULL): of the group as baked. Thread-safe.
SCONCE_API const char *sconce_luminaire_group(const struct sconce_luminaire *luminaire, size_t index, float flux[3]);
// The same lamp with its groups dimmed and tinted by `settings`, "bulb=0.3; spot=800lm 2700K" (docs/scene-files.md; the
// group "all" is the whole lamp; lumens as though the lamp's length unit were the metre), for all the calls above.
// It shares the original's tables, costs no more than itself to close, and must be closed before the original. Any
// number of such luminaires may be used at once, by any threads. Errors: unknown groups, what is no setting.
SCONCE_API enum sconce_status sconce_luminaire_dim(struct sconce_luminaire **dimmed,
                                                   const struct sconce_luminaire *original, const char *settings,
                                                   struct sconce_error *error);

// ---- The verbs of the program ------------------------------------------------------------------------------------

struct sconce_bake_options {
    const char *lamp; // Mitsuba XML of the lamp
    const char *output; // .safetensors
    const struct sconce_definition *definitions;
    size_t definition_count;
    bool skip_missing; // a missing mesh is a warning
    const char *preset; // "compact" (NULL), or "paper": the published networks of Zhu et al. 2021, for comparison
    const char *quality; // "draft", "standard" (NULL) or "high": fixed work, so that one seed gives one file
    const char *size; // of the file: "small" (0.6 MB), "default" (NULL; 2 MB) or "large" (8 MB)
    double seconds; // > 0: as much as fits in this wall time, instead of quality
    const char *proxy; // "auto" (NULL), "sphere", "box", "cylinder", or a closed mesh's file
    bool resume; // go on from OUTPUT's checkpoint; preset "paper" has none
    const char *view; // "hull" (NULL): the file also holds a small hull for appearance=surface; "none"
    // "none" (NULL); "named": emitters whose ids begin alike, up to the first '.', are a group that can be dimmed and
    // tinted later; "each": every emitter is one. 16 groups at most.
    const char *groups;
};

struct sconce_figures { // what was measured on held-out lines, beside the black image's score (1 = nothing learned)
    float flux[3], flux_noise[3]; // of the traced lamp, and its relative standard error
    float flux_error[3]; // of the file against it, relative and signed
    int distance_count;
    // Mean relative error over points at that distance.
    float distance_radii[8], irradiance_error[8], irradiance_noise[8];
    // Mean squared error of radiance over bundles of lines, relative to the mean square.
    float light_field_error, light_field_error_black;
    float transparency_error, transparency_error_black; // mean absolute error
    float transparency_noise; // what a perfect luminaire would score
    // Relative variance of L cos / p of one light sample; of a uniform one.
    float sample_variance, sample_variance_uniform;
    // By sconce_evaluate only (else false): the irradiance map of 256 x 256 pixels on a wall 2 radii away; orthographic
    // pictures of the lamp from 8 directions, as mean squared error of log(1 + x) in dB below the black image's. Noise
    // is taken out of relMSE and dB; FLIP is extrapolated to none (too large where errors are few), *_noise is what the
    // noise alone would score.
    bool wall_measured, view_measured;
    int view_samples; // lines a pixel of the direct views
    float wall_relmse, wall_relmse_noise, wall_flip, wall_flip_noise;
    float view_gain_db, view_flip, view_flip_black, view_flip_noise;
    bool surface_measured; // the same pictures as the hull shows the lamp, where the file has one
    float surface_gain_db, surface_flip;
    size_t bytes;
    double seconds;
};

SCONCE_API enum sconce_status sconce_bake(const struct sconce_bake_options *options, const struct sconce_run *run,
                                          struct sconce_figures *figures, struct sconce_error *error);
struct sconce_evaluate_options {
    const char *luminaire; // .safetensors
    const char *lamp; // Mitsuba XML of the lamp
    const struct sconce_definition *definitions;
    size_t definition_count;
    bool skip_missing; // a missing mesh is a warning
    const char *quality; // "draft", "standard" (NULL) or "high": how little noise the measurement has
};
// The same figures for a file against the lamp's geometry.
SCONCE_API enum sconce_status sconce_evaluate(const struct sconce_evaluate_options *options,
                                              const struct sconce_run *run, struct sconce_figures *figures,
                                              struct sconce_error *error);

struct sconce_render_options {
    const char *scene;
    const char *output; // .exr (with the variance of each pixel) or .png
    const struct sconce_definition *definitions;
    size_t definition_count;
    const char *integrator; // "path", "bdpt", "particle"; NULL: the scene's
    int samples; // per pixel; 0: the scene's
    double seconds; // > 0: as many samples as fit in this wall time, instead
    int width, height; // 0: the scene's
    int max_depth; // 0: the scene's; -1: unlimited
    bool skip_missing;
    // Integrator "path" shares no light. Without, pixels that see one surface side by side share what they find to
    // arrive there as far as their samples cannot tell it apart, and, where max_depth is 16 or more or unlimited, a
    // path may end at the second surface that scatters it, or later, with the light that others found there: less noise
    // in less time, for a small error that falls with the samples (docs/design.md, section 4).
    bool exact;
    // Full transport in the mean, whatever the baked lamps' errors: integrator "path" traces the geometry they were
    // baked from and uses their light fields to aim its samples and to take noise out of them. Errors: that geometry is
    // not found, or is not what was baked. keep and appearance of the lamps are ignored.
    bool unbiased;
    float exposure; // of a .png; 0: automatic
    // An .exr to write as well: 1 where the camera sees no baked lamp, directly or in a mirror; or NULL.
    const char *mask;
    const char *png; // a .png to write beside the output, or NULL
};

struct sconce_render_result {
    int width, height, samples;
    char integrator[16];
    double wall_s, cpu_s; // of the rendering, without loading
    double load_s;
    float mean[3];
};

SCONCE_API enum sconce_status sconce_render(const struct sconce_render_options *options, const struct sconce_run *run,
                                            struct sconce_render_result *result, struct sconce_error *error);

struct sconce_comparison {
    double mse, rel_mse, psnr_db, psnr_log_db, flip; // rel_mse: mean of (a - r)^2 / (r^2 + 1e-3)
    // rel_mse less what the reference's own noise adds (its variance channels), or NAN without.
    double rel_mse_corrected;
    double mean_ratio[3];
    double block_error_max, block_error_mean; // |mean ratio - 1| over 4x4 blocks
    size_t pixel_count;
};

// mask: .exr, pixels count where > 0.5; NULL: all do.
SCONCE_API enum sconce_status sconce_compare(const char *image, const char *reference, const char *mask,
                                             struct sconce_comparison *comparison, struct sconce_error *error);

// What a scene, a luminaire or an image holds, as JSON. free() it.
SCONCE_API enum sconce_status sconce_info(const char *path, const struct sconce_definition *definitions,
                                          size_t definition_count, const struct sconce_run *run, char **json,
                                          struct sconce_error *error);
// Help on "bsdf", "shape", "emitter", "texture", "sensor" and their types, from the tables that parse scenes; both may
// be NULL. free() it.
SCONCE_API enum sconce_status sconce_help(const char *kind, const char *type, char **text, struct sconce_error *error);

struct sconce_report_entry {
    const char *name; // "baked, path"
    const char *image; // .exr
    const char *json; // what `sconce render --json` printed for it, a file; or NULL
};
// One self-contained HTML page: pictures, differences and figures of each entry against the reference.
struct sconce_report_options {
    const char *output, *title;
    struct sconce_report_entry reference;
    const struct sconce_report_entry *entries;
    size_t entry_count;
    const char *mask; // or NULL
    const char *bake_json; // what `sconce bake --json` printed, a file; or NULL
};
SCONCE_API enum sconce_status sconce_report(const struct sconce_report_options *options, struct sconce_error *error);

// Table 1 of Zhu et al. 2021, measured anew: five rooms by bidirectional path tracing of the lamps' geometry and with
// the baked lamps, at equal error. Renderings and table1.json, .md and .html are in the folder `output`; what is there
// from an earlier call with the same files and options is used again.
struct sconce_table1_options {
    const char *output; // a folder, made where it is missing
    const char *data; // folder with the project's scenes/ and lamps/; NULL: found from where the library is
    double scale; // of the picture's sides and of all samples, 0.01..4; 0 counts as 1: 400 pixels high, 1024 samples
    double reference; // samples of each of the two references, in terms of bdpt's, 1..64; 0 counts as 1
    const char *only; // rows, with commas between them: "statler,star,blossom,feather,vintage"; NULL: all
};
// *json: {"rows": [{"luminaire", "scene", "speedup", ...}], "settings": {...}}; *markdown: the same to be read. free()
// both. On SCONCE_CANCELLED they hold the finished rows (NULL without any), and the same call goes on from there; on
// other errors they are NULL. Errors: a baked lamp is missing, the folder cannot be written, an unknown row.
SCONCE_API enum sconce_status sconce_table1(const struct sconce_table1_options *options, const struct sconce_run *run,
                                            char **json, char **markdown, struct sconce_error *error);

// The figures of the paper, made anew with this program's lamps and rooms, and ablations: PNG and JSON files and one
// self-contained page OUTPUT/figures.html. What is there from a call with the same options and files is kept.
struct sconce_figure_options {
    const char *output; // a folder, made where it is missing
    double scale; // > 0; 1 (0 counts as 1): some 40 minutes on two cores. Time and pixels go with it
    const char *only; // names with commas between them, such as "4,13,ablations"; NULL: all but the ablations
    const char *paper; // a file of preset "paper" of the demonstration lamp, for figure 6; or NULL
    const char *data; // a folder with scenes/ and lamps/ in it; NULL: the program's own rooms and lamps
};
// *json: {"page": path, "figures": [...]} with every figure's tables and the names of its pictures; free() it.
// SCONCE_CANCELLED: the page shows what is finished, and the same call goes on from there.
SCONCE_API enum sconce_status sconce_make_figures(const struct sconce_figure_options *options,
                                                  const struct sconce_run *run, char **json,
                                                  struct sconce_error *error);

#ifdef __cplusplus
}
#endif
