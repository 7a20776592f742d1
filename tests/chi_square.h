// Shared by the statistical tests: Pearson's chi-square test of counts, and of a sampling routine over directions
// against its density. Cells with fewer than 5 expected samples are pooled; over many tests the level is corrected
// after Sidak 1967. The incomplete gamma function is the series and continued fraction of DLMF 8.7.1 and 8.9.2.
#pragma once

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include "math/vec.h"

// Regularised upper incomplete gamma function Q(a, x), a > 0, x >= 0.
static inline double chi_square_gamma_q(double a, double x) {
    if (x <= 0) return 1;
    double front = exp(a * log(x) - x - lgamma(a));
    if (x < a + 1) {
        double term = 1 / a, sum = term;
        for (int n = 1; n < 10000 && fabs(term) > 1e-16 * fabs(sum); ++n) sum += term *= x / (a + n);
        return 1 - sum * front;
    }
    double b = x + 1 - a, c = 1e300, d = 1 / b, h = d; // modified Lentz
    for (int n = 1; n < 10000; ++n) {
        double an = -n * (n - a);
        b += 2;
        d = an * d + b;
        c = b + an / c;
        if (fabs(d) < 1e-300) d = 1e-300;
        if (fabs(c) < 1e-300) c = 1e-300;
        d = 1 / d;
        double factor = d * c;
        h *= factor;
        if (fabs(factor - 1) < 1e-15) break;
    }
    return front * h;
}

// The level for one test such that `tests` independent ones together reject a true hypothesis with probability `level`.
static inline double chi_square_sidak(double level, size_t tests) { return -expm1(log1p(-level) / (double)tests); }

struct chi_square {
    double statistic, p; // p: the probability of a statistic at least as large under the hypothesis
    int dof;
    double sampled, integral; // shares: of samples that gave a result, and the integral of the density
};

struct chi_square_cell {
    double observed, expected;
};

static inline int chi_square_by_expected(const void *a, const void *b) {
    double x = ((const struct chi_square_cell *)a)->expected, y = ((const struct chi_square_cell *)b)->expected;
    return x < y ? -1 : x > y;
}

// Sorts `cells` by expectation and pools the small ones. A sample where (almost) none may be gives p = 0.
static inline struct chi_square chi_square_counts(struct chi_square_cell *cells, size_t n) {
    struct chi_square result = {.p = 1, .dof = -1};
    struct chi_square_cell pool = {0, 0};
    qsort(cells, n, sizeof *cells, chi_square_by_expected);
    for (size_t i = 0; i < n; ++i) {
        if (cells[i].expected <= 1e-6 && cells[i].observed > 0) result.p = 0;
        pool.observed += cells[i].observed;
        pool.expected += cells[i].expected;
        double left = 0;
        for (size_t j = i + 1; j < n && left < 5; ++j) left += cells[j].expected;
        if (pool.expected < 5 || (left < 5 && i + 1 < n)) continue;
        result.statistic += (pool.observed - pool.expected) * (pool.observed - pool.expected) / pool.expected;
        ++result.dof;
        pool = (struct chi_square_cell){0, 0};
    }
    if (pool.observed > 50) result.p = 0; // fewer than 5 expected in all, many seen
    if (result.dof > 0 && result.p > 0) result.p = chi_square_gamma_q(0.5 * result.dof, 0.5 * result.statistic);
    return result;
}

// A sampling routine over the sphere and its density per solid angle.
struct chi_square_direction {
    bool (*sample)(void *user, uint64_t index,
                   vec3 *w); // the index-th sample (a pure function of it); false: no result
    double (*pdf_sa)(void *user, vec3 w);
    void *user;
    size_t samples; // 100000 ..
    int rows, columns; // of the grid in cos(theta) x phi; rows even puts a boundary at the equator; e.g. 20 x 40
    struct frame frame; // the grid's axis: put a spike's centre away from the poles; zero: the standard frame
};

static inline double chi_square_pdf_at(const struct chi_square_direction *t, const struct frame *f, double z,
                                       double phi) {
    double r = sqrt(fmax(0, 1 - z * z));
    return t->pdf_sa(t->user,
                     frame_world_from_local(f, (vec3){(float)(r * cos(phi)), (float)(r * sin(phi)), (float)z}));
}

static inline double chi_square_quadrature(const struct chi_square_direction *t, const struct frame *f,
                                           const double box[4]) {
    static const double node[2] = {0.33998104358485626, 0.86113631159405258}; // Gauss-Legendre, 4 points
    static const double weight[2] = {0.65214515486254614, 0.34785484513745386};
    double cz = 0.5 * (box[0] + box[1]), hz = 0.5 * (box[1] - box[0]);
    double cp = 0.5 * (box[2] + box[3]), hp = 0.5 * (box[3] - box[2]), sum = 0;
    for (int i = 0; i < 4; ++i) {
        for (int j = 0; j < 4; ++j) {
            double z = cz + (i & 1 ? hz : -hz) * node[i >> 1], phi = cp + (j & 1 ? hp : -hp) * node[j >> 1];
            sum += weight[i >> 1] * weight[j >> 1] * chi_square_pdf_at(t, f, z, phi);
        }
    }
    return sum * hz * hp;
}

// Adaptive: halves both sides until the sum of the quarters agrees. d(solid angle) = d(cos theta) d(phi).
static inline double chi_square_integrate(const struct chi_square_direction *t, const struct frame *f,
                                          const double box[4], double whole, double tolerance, int depth) {
    double z = 0.5 * (box[0] + box[1]), phi = 0.5 * (box[2] + box[3]), part[4], sum = 0;
    double quarter[4][4] = {
        {box[0], z, box[2], phi}, {z, box[1], box[2], phi}, {box[0], z, phi, box[3]}, {z, box[1], phi, box[3]}};
    for (int i = 0; i < 4; ++i) sum += part[i] = chi_square_quadrature(t, f, quarter[i]);
    if (depth == 0 || fabs(sum - whole) <= tolerance) return sum;
    sum = 0;
    for (int i = 0; i < 4; ++i) sum += chi_square_integrate(t, f, quarter[i], part[i], tolerance * 0.5, depth - 1);
    return sum;
}

// Samples without a result count as one more cell, expected where the density integrates to less than 1.
static inline struct chi_square chi_square_test_directions(const struct chi_square_direction *t) {
    struct frame frame = t->frame;
    if (vec3_dot(frame.n, frame.n) == 0) frame = frame_from_normal((vec3){0, 0, 1});
    size_t n = (size_t)t->rows * (size_t)t->columns + 1;
    struct chi_square_cell *cells = calloc(n, sizeof *cells);
    if (!cells) abort();
    double integral = 0, failed = 0, count = (double)t->samples;
    for (int row = 0; row < t->rows; ++row) {
        for (int column = 0; column < t->columns; ++column) {
            double box[4] = {-1 + 2.0 * row / t->rows, -1 + 2.0 * (row + 1) / t->rows, 2 * M_PI * column / t->columns,
                             2 * M_PI * (column + 1) / t->columns};
            double whole = chi_square_quadrature(t, &frame, box);
            double share = chi_square_integrate(t, &frame, box, whole, 0.02 / count, 7);
            cells[row * t->columns + column].expected = share * count;
            integral += share;
        }
    }
    for (size_t i = 0; i < t->samples; ++i) {
        vec3 world;
        if (!t->sample(t->user, i, &world)) {
            ++failed;
            continue;
        }
        vec3 w = frame_local_from_world(&frame, world);
        int row = (int)(0.5 * (w.z + 1) * t->rows);
        double phi = atan2((double)w.y, (double)w.x);
        int column = (int)((phi < 0 ? phi + 2 * M_PI : phi) / (2 * M_PI) * t->columns);
        row = row < 0 ? 0 : row >= t->rows ? t->rows - 1 : row;
        column = column >= t->columns ? t->columns - 1 : column;
        ++cells[row * t->columns + column].observed;
    }
    cells[n - 1] = (struct chi_square_cell){failed, fmax(0, 1 - integral) * count};
    struct chi_square result = chi_square_counts(cells, n);
    result.sampled = 1 - failed / count;
    result.integral = integral;
    if (!(integral < 1 + 1e-2)) result.p = 0; // not a density
    free(cells);
    return result;
}

// Prints what failed; true where the test passes at `level` (already corrected with chi_square_sidak).
static inline bool chi_square_passes(const char *name, struct chi_square result, double level) {
    bool passes = result.p >= level && result.dof > 0;
    if (!passes) {
        printf(
            "%s: chi-square %.1f, %d degrees of freedom, p %.3g < %.3g; %.4f of the samples gave a result, the density "
            "integrates to %.4f\n",
            name, result.statistic, result.dof, result.p, level, result.sampled, result.integral);
    }
    return passes;
}
