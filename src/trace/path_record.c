// Path tracer: what the guide learns from. A record begins where a path has scattered broadly: the chain is the ray
// from there, which goes on through mirrors and narrow lobes as if it were not bent. What the path gets where the chain
// ends, at a surface that scatters broadly, counts as coming from its unfolded end; a lamp that is met on the chain (in
// a mirror, or as the gloss of a floor) is recorded at its own unfolded distance, which is where its image is: the same
// for all places that look at it. Light from lamps without such a bend is left to light samples.
#include "trace/path_state.h"

static struct guide_record record_at(const struct path_record *record, float distance, vec3 n, float gain) {
    return (struct guide_record){vec3_mad(record->direction, distance, record->origin), n, gain / record->beta, gain};
}

static void report_part(struct path_report *report, const struct path *path, enum record_part part) {
    const struct path_record *record = &path->record;
    const bool lamp = part == RECORD_LAMP;
    const float gain = lamp ? record->lamp : rgb_luminance(path->radiance) - record->before - record->lamp;
    report->parts[part] = record_at(record, lamp ? record->lamp_distance : record->distance,
                                    lamp ? vec3_neg(record->direction) : record->n, maxf(gain, 0));
}

void path_record_scatter(const struct path_tracer *tracer, struct path *path, const struct bsdf_sample *sample) {
    struct path_record *record = &path->record;
    const bool sharp = sample->delta || path_pdf_is_sharp(sample->pdf);
    if (record->state == RECORD_OPEN && !sharp) record->state = RECORD_CLOSED;
    if (record->state == RECORD_OPEN && !record->bent) {
        report_part(path_guide_report(tracer, path), path, RECORD_SURFACE);
        record->bent = true;
        record->before = rgb_luminance(path->radiance) - record->lamp;
    }
    if (record->state != RECORD_NONE || sample->delta || !path_guide_listens(tracer, path)) return;
    *record = (struct path_record){
        .state = RECORD_LEAVES, .origin = path->surface.p, .direction = sample->wo, .beta = rgb_luminance(path->beta)};
    if (!(record->beta > 0)) record->state = RECORD_NONE;
    for (int part = 0; part < RECORD_PARTS; part++) path_guide_report(tracer, path)->parts[part].radiance = -1;
}

void path_record_hit(struct path *path) {
    struct path_record *record = &path->record;
    if (record->state != RECORD_LEAVES && record->state != RECORD_OPEN) return;
    record->distance += path->surface.t;
    if (path->status != PATH_SCATTERS) return;
    const vec3 ng = path->surface.ng;
    record->n = vec3_dot(ng, path->ray.direction) > 0 ? vec3_neg(ng) : ng;
    if (record->bent) record->n = vec3_neg(record->direction);
    if (record->state == RECORD_OPEN) return;
    record->state = RECORD_OPEN;
    record->before = rgb_luminance(path->radiance);
}

void path_record_lamp(struct path *path, rgb contribution, float distance) {
    struct path_record *record = &path->record;
    if (record->state != RECORD_OPEN) return;
    record->lamp += rgb_luminance(contribution);
    record->lamp_distance = record->distance + distance;
}

void path_record_end(const struct path_tracer *tracer, const struct path *path) {
    const struct path_record *record = &path->record;
    if (record->state == RECORD_NONE) return;
    struct path_report *report = path_guide_report(tracer, path);
    report->whole = rgb_luminance(path->radiance);
    if (record->state == RECORD_LEAVES) return;
    report_part(report, path, record->bent ? RECORD_BEYOND : RECORD_SURFACE);
    if (record->lamp > 0) report_part(report, path, RECORD_LAMP);
}
