// Construction, encodings, and the two networks over lines.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "luminaire/line.h"
#include "luminaire/paper_private.h"
#include "net/kernel.h"

enum { FREQUENCIES = 10, ENCODED = 3 * 2 * FREQUENCIES };

const struct dense_shape paper_shapes[PAPER_NETS] = {
    [PAPER_EVAL] = {2 * ENCODED, 512, 7, 3},
    [PAPER_TRANSPARENCY] = {2 * ENCODED, 512, 7, 3},
    [PAPER_SAMPLING] = {3, 256, 4, 3 * PAPER_PIXELS},
};

size_t paper_parameters(enum paper_net net) { return dense_parameters(&paper_shapes[net]); }

const struct dense_packed *paper_net(const struct paper *paper, enum paper_net net) {
    return paper->training == (int)net ? &paper->trainer.packed : &paper->packed[net];
}

enum status paper_create(struct paper **paper, const struct proxy *proxy, struct error *error) {
    struct paper *p = *paper = calloc(1, sizeof *p);
    if (!p) return error_set(error, STATUS_MEMORY, "out of memory for the networks");
    memcpy(p->center, proxy->center, sizeof p->center);
    p->radius = proxy->radius;
    p->training = -1;
    enum status status = STATUS_OK;
    for (int net = 0; net < PAPER_NETS && status == STATUS_OK; net++) {
        p->parameters[net] = calloc(paper_parameters((enum paper_net)net), sizeof(float));
        if (!p->parameters[net])
            status = error_set(error, STATUS_MEMORY, "out of memory for the networks");
        else
            status = dense_packed_init(&p->packed[net], &paper_shapes[net], error);
        if (status != STATUS_OK) break;
        dense_packed_set(&p->packed[net], p->parameters[net]);
    }
    if (status == STATUS_OK) return STATUS_OK;
    paper_destroy(p);
    *paper = NULL;
    return status;
}

void paper_destroy(struct paper *paper) {
    if (!paper) return;
    if (paper->training >= 0) dense_trainer_fini(&paper->trainer);
    for (int net = 0; net < PAPER_NETS; net++) {
        free(paper->parameters[net]);
        dense_packed_fini(&paper->packed[net]);
    }
    free(paper);
}

// sin and cos of 2^k pi v for k < FREQUENCIES (Mildenhall et al. 2020, eq. 4): feature 6 k + axis, and 3 further on.
// Each frequency comes from the one before by doubling the angle.
static void encode_vector(const float v[3][NET_LANES], float *x) {
    for (int a = 0; a < 3; a++) {
        float sine[NET_LANES], cosine[NET_LANES];
        for (int l = 0; l < NET_LANES; l++) {
            sine[l] = sinf(PI_F * v[a][l]);
            cosine[l] = cosf(PI_F * v[a][l]);
        }
        for (int k = 0; k < FREQUENCIES; k++) {
            float *to = x + (6 * k + a) * DENSE_SLICE;
            for (int l = 0; l < NET_LANES; l++) {
                to[l] = sine[l];
                to[3 * DENSE_SLICE + l] = cosine[l];
                float twice = 2 * sine[l] * cosine[l];
                cosine[l] = 1 - 2 * sine[l] * sine[l];
                sine[l] = twice;
            }
        }
    }
}

void paper_encode_lines(const struct paper *paper, int count, const float (*point)[3], const float (*w)[3], float *x,
                        float hit[DENSE_SLICE]) {
    for (int first = 0; first < count; first += NET_LANES) {
        struct line_block lines;
        line_block_load(&lines, paper->center, paper->radius, count - first < NET_LANES ? count - first : NET_LANES,
                        point + first, w + first);
        encode_vector((const float(*)[NET_LANES])lines.u, x + first);
        encode_vector((const float(*)[NET_LANES])lines.w, x + ENCODED * DENSE_SLICE + first);
        memcpy(hit + first, lines.hit, sizeof lines.hit);
    }
}

// Contracted beyond the sphere, r -> 2 - 1 / r: far points come close to the picture of their direction.
void paper_encode_points(const struct paper *paper, int count, const float (*s)[3], float *x) {
    for (int l = 0; l < count; l++) {
        float v[3], length2 = 0;
        for (int a = 0; a < 3; a++) {
            v[a] = (s[l][a] - paper->center[a]) / paper->radius;
            length2 += v[a] * v[a];
        }
        float inverse = 1 / sqrtf(fmaxf(length2, 1)), scale = (2 - inverse) * inverse;
        for (int a = 0; a < 3; a++) x[a * DENSE_SLICE + l] = v[a] * scale;
    }
}

void paper_radiance_from_log(float *z, size_t count) {
    for (size_t i = 0; i < count; i++) z[i] = z[i] > 0 ? (z[i] < 40 ? z[i] : 40) : 0; // also turns a NaN into 0
    kernel_best()->exponential(z, count);
    for (size_t i = 0; i < count; i++) z[i] -= 1;
}

void paper_sigmoid(float *z, size_t count) {
    for (size_t i = 0; i < count; i++) z[i] = z[i] > -40 ? (z[i] < 40 ? -z[i] : -40) : 40; // a NaN becomes 0
    kernel_best()->exponential(z, count);
    for (size_t i = 0; i < count; i++) z[i] = 1 / (1 + z[i]);
}

static void eval_lines(const struct paper *paper, enum paper_net net, size_t n, const float (*point)[3],
                       const float (*w)[3], void (*finish)(float *z, size_t count), float missed, float (*result)[3]) {
    _Alignas(64) float x[2 * ENCODED * DENSE_SLICE], z[3 * DENSE_SLICE], hit[DENSE_SLICE];
    for (size_t first = 0; first < n; first += DENSE_SLICE) {
        int count = (int)(n - first < DENSE_SLICE ? n - first : DENSE_SLICE);
        paper_encode_lines(paper, count, point + first, w + first, x, hit);
        dense_packed_forward(paper_net(paper, net), count, x, z);
        for (int c = 0; c < 3; c++) finish(z + c * DENSE_SLICE, ((size_t)count + NET_LANES - 1) & ~(NET_LANES - 1UL));
        for (int l = 0; l < count; l++)
            for (int c = 0; c < 3; c++) result[first + (size_t)l][c] = hit[l] > 0 ? z[c * DENSE_SLICE + l] : missed;
    }
}

void paper_eval(const struct paper *paper, size_t n, const float (*point)[3], const float (*w)[3],
                float (*radiance)[3]) {
    eval_lines(paper, PAPER_EVAL, n, point, w, paper_radiance_from_log, 0, radiance);
}

void paper_transmittance(const struct paper *paper, size_t n, const float (*point)[3], const float (*w)[3],
                         float (*transmittance)[3]) {
    eval_lines(paper, PAPER_TRANSPARENCY, n, point, w, paper_sigmoid, 1, transmittance);
}
