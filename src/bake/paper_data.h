// Training data for the published networks. Their loss is not linear in the data, so every target is a mean of many
// traces: with a squared error of log(1 + y) a perfect network keeps 6, 28, 65 and 85 % of the flower's flux at 1, 4,
// 16 and 64 traces a line, 40, 77, 93 and 97 % of a frosted bulb's. Published: 256, 128 and 4096 traces.
#pragma once

#include "bake/gather.h"
#include "luminaire/paper.h"

enum { PAPER_LINE_TRACES = 64, PAPER_TRANSMITTANCE_TRACES = 32, PAPER_PIXEL_TRACES = 16 };

// As gather_lines with traces, each the mean of `traces`.
void paper_gather_lines(struct line_sample *lines, const struct lamp *lamp, const struct line_guide *guide,
                        enum gather_stream stream, size_t first, size_t n, int traces);
// Pictures from points at 1 to 12 radii, a tenth of them within the sphere.
void paper_gather_views(struct paper_view *views, const struct lamp *lamp, const struct paper *paper,
                        enum gather_stream stream, size_t first, size_t n);
