// The tracing side of a bake: particles that leave the lamp and camera lines into it, in parallel blocks. Every number
// is a pure function of (seed, stream, index), whatever the number of threads.
#pragma once

#include "luminaire/proxy.h"
#include "scene/scene.h"
#include "trace/line_radiance.h"

struct line_guide;

enum gather_stream { // separate random numbers for separate purposes
    STREAM_SURVEY = 1,
    STREAM_TRIAL,
    STREAM_HELD_OUT,
    STREAM_TRAINING,
    STREAM_TRANSPARENCY,
    STREAM_SCALE,
    STREAM_EVALUATION,
    STREAM_SCATTERING,
    STREAM_HULL = 64, // and the streams of view_bake.c
    STREAM_VIEW_PILOT,
    STREAM_VIEW,
    STREAM_VIEW_SCALE,
};

struct lamp { // what is baked, as the tracers see it
    const struct scene *scene;
    struct proxy proxy;
    struct proxy_shape shape; // of the proxy
    const struct aim *aims; // emission clusters, for camera lines
    size_t aim_count;
    uint64_t seed;
    int threads;
};

struct exit_list {
    struct line_exit *exits;
    vec3 *origin; // where each was emitted or scattered last; NULL where nobody asked
    size_t count, emitted, rays; // exits; particles, and the rays traced for them
};

// Traces the particles [first, first + n) of a stream. Exits that the proxy's bounding sphere does not see cannot
// occur. `origins`: also fill list->origin.
enum status gather_exits(struct exit_list *list, const struct lamp *lamp, enum gather_stream stream, size_t first,
                         size_t n, bool origins, const struct run *run, struct error *error);
void exit_list_fini(struct exit_list *list);

// Lines [first, first + n) of a stream, drawn from the guide: mass = 1 / density, target = radiance / density where
// `trace`, else 0. Lines that miss the proxy have mass 0 and target 0 and count as samples.
void gather_lines(struct line_sample *lines, const struct lamp *lamp, const struct line_guide *guide,
                  enum gather_stream stream, size_t first, size_t n, bool trace);
// Traces the first n lines of a stream once more, by other random numbers.
void gather_again(struct line_sample *lines, const struct lamp *lamp, enum gather_stream stream, size_t n);

// Uniform lines that cross the proxy: mass = 1, target = the mean of `repeats` estimates of the transmittance, of fewer
// where the first 64 agree. Another `round`: other estimates on the same lines. `learner`: lines that it does not learn
// from are not traced and have mass 0; or NULL.
void gather_transmittance(struct line_sample *lines, const struct lamp *lamp, enum gather_stream stream, size_t first,
                          size_t n, int repeats, int round, const struct transparency *learner);
// Uniform lines as well: mass = 1, target = an estimate of the light that leaves the lamp anywhere when it comes along
// the line, or, `onward`, that leaves it to the other side than it came from.
void gather_escapes(struct line_sample *lines, const struct lamp *lamp, enum gather_stream stream, size_t n,
                    bool onward);
