// The verb `table1`: Zhu et al. 2021, Table 1, measured anew with this program's lamps and rooms.
#pragma once

#include "base/error.h"
#include "base/run.h"

struct table1_options {
    const char *folder; // of the results; made where it is not there
    const char *data; // see evidence_data_find; NULL: found
    double scale; // of the picture's sides and of all samples; 1: 400 pixels high, bdpt with 1024 samples
    double reference; // samples of each of the two references, in terms of bdpt's, 1 to 64
    const char *only; // names with commas between them; NULL: all
};

// *json and *markdown are malloc'ed: the table of the rows that are finished, also on STATUS_CANCELLED (NULL where
// there are none, and on other errors). The same is in the folder as table1.json, table1.md and table1.html, renewed
// after every row. Renderings are kept there and used again (evidence/long_render.h).
enum status table1_make(const struct table1_options *options, const struct run *run, char **json, char **markdown,
                        struct error *error);
