// Training data for the published networks: their loss is not linear in the data, so every target is a mean of several
// traces.
#pragma once

#include "bake/gather.h"
#include "luminaire/paper.h"

enum { PAPER_TRACES = 16 }; // a line, a pixel; of log(1 + y) about 2 % of the light is lost to their noise

// As gather_lines with traces, each the mean of `traces`.
void paper_gather_lines(struct line_sample *lines, const struct lamp *lamp, const struct line_guide *guide,
                        enum gather_stream stream, size_t first, size_t n, int traces);
// Pictures from points at 1 to 12 radii, a tenth of them within the sphere.
void paper_gather_views(struct paper_view *views, const struct lamp *lamp, const struct paper *paper,
                        enum gather_stream stream, size_t first, size_t n);
