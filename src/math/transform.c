// 4x4 transforms kept together with their inverse. Used by the scene loader (every <transform>), shapes and cameras.
// Composition and inversion run in double so that long chains of a scene file lose no digits.
#include "math/transform.h"

#include <string.h>

struct transform transform_identity(void) {
    struct transform t = {0};
    for (int i = 0; i < 4; ++i) t.m[i][i] = t.inverse[i][i] = 1;
    return t;
}

struct transform transform_translate(vec3 v) {
    struct transform t = transform_identity();
    t.m[0][3] = v.x, t.m[1][3] = v.y, t.m[2][3] = v.z;
    t.inverse[0][3] = -v.x, t.inverse[1][3] = -v.y, t.inverse[2][3] = -v.z;
    return t;
}

struct transform transform_scale(vec3 v) {
    struct transform t = transform_identity();
    t.m[0][0] = v.x, t.m[1][1] = v.y, t.m[2][2] = v.z;
    t.inverse[0][0] = 1 / v.x, t.inverse[1][1] = 1 / v.y, t.inverse[2][2] = 1 / v.z;
    return t;
}

// Rodrigues' formula; the inverse of a rotation is its transpose.
struct transform transform_rotate(vec3 axis, float degrees) {
    double length = sqrt((double)axis.x * axis.x + (double)axis.y * axis.y + (double)axis.z * axis.z);
    double a[3] = {axis.x / length, axis.y / length, axis.z / length};
    double angle = degrees * (M_PI / 180), c = cos(angle), s = sin(angle);
    double cross[3][3] = {{0, -a[2], a[1]}, {a[2], 0, -a[0]}, {-a[1], a[0], 0}};
    struct transform t = transform_identity();
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            double value = (i == j ? c : 0) + (1 - c) * a[i] * a[j] + s * cross[i][j];
            t.m[i][j] = t.inverse[j][i] = (float)value;
        }
    }
    return t;
}

// Columns (left, up, forward) as in Mitsuba: left = up x forward. An `up` along the view direction is replaced by any
// perpendicular one.
struct transform transform_look_at(vec3 origin, vec3 target, vec3 up) {
    vec3 forward = vec3_normalize(vec3_sub(target, origin));
    vec3 left = vec3_cross(up, forward);
    if (vec3_length(left) <= 1e-6f * vec3_length(up)) left = frame_from_normal(forward).s;
    left = vec3_normalize(left);
    vec3 true_up = vec3_cross(forward, left);
    float m[4][4] = {{left.x, true_up.x, forward.x, origin.x},
                     {left.y, true_up.y, forward.y, origin.y},
                     {left.z, true_up.z, forward.z, origin.z},
                     {0, 0, 0, 1}};
    return transform_from_matrix((const float(*)[4])m, NULL);
}

// Gauss-Jordan with partial pivoting. Where the matrix is singular *invertible is false and the inverse is zero.
struct transform transform_from_matrix(const float m[4][4], bool *invertible) {
    struct transform t = {0};
    memcpy(t.m, m, sizeof t.m);
    double work[4][8] = {{0}}, largest = 0;
    for (int i = 0; i < 4; ++i) {
        for (int j = 0; j < 4; ++j) {
            work[i][j] = m[i][j];
            largest = fmax(largest, fabs(work[i][j]));
        }
        work[i][4 + i] = 1;
    }
    bool regular = isfinite(largest);
    for (int column = 0; column < 4 && regular; ++column) {
        int pivot = column;
        for (int row = column + 1; row < 4; ++row) {
            if (fabs(work[row][column]) > fabs(work[pivot][column])) pivot = row;
        }
        double value = work[pivot][column];
        regular = isfinite(value) && fabs(value) > 1e-14 * largest;
        for (int j = 0; j < 8 && regular; ++j) {
            double swap = work[pivot][j];
            work[pivot][j] = work[column][j];
            work[column][j] = swap / value;
        }
        for (int row = 0; row < 4 && regular; ++row) {
            double factor = work[row][column];
            for (int j = 0; j < 8 && row != column; ++j) work[row][j] -= factor * work[column][j];
        }
    }
    for (int i = 0; i < 4 && regular; ++i) {
        for (int j = 0; j < 4; ++j) t.inverse[i][j] = (float)work[i][4 + j];
    }
    if (invertible) *invertible = regular;
    return t;
}

static void matrix_multiply(float result[4][4], const float a[4][4], const float b[4][4]) {
    for (int i = 0; i < 4; ++i) {
        for (int j = 0; j < 4; ++j) {
            double sum = 0;
            for (int k = 0; k < 4; ++k) sum += (double)a[i][k] * b[k][j];
            result[i][j] = (float)sum;
        }
    }
}

struct transform transform_multiply(const struct transform *a, const struct transform *b) {
    struct transform t;
    matrix_multiply(t.m, (const float(*)[4])a->m, (const float(*)[4])b->m);
    matrix_multiply(t.inverse, (const float(*)[4])b->inverse, (const float(*)[4])a->inverse);
    return t;
}

struct transform transform_inverse(const struct transform *t) {
    struct transform result;
    memcpy(result.m, t->inverse, sizeof result.m);
    memcpy(result.inverse, t->m, sizeof result.inverse);
    return result;
}

vec3 transform_point(const struct transform *t, vec3 p) {
    const float(*m)[4] = (const float(*)[4])t->m;
    vec3 q = {m[0][0] * p.x + m[0][1] * p.y + m[0][2] * p.z + m[0][3],
              m[1][0] * p.x + m[1][1] * p.y + m[1][2] * p.z + m[1][3],
              m[2][0] * p.x + m[2][1] * p.y + m[2][2] * p.z + m[2][3]};
    float w = m[3][0] * p.x + m[3][1] * p.y + m[3][2] * p.z + m[3][3];
    return w == 1 ? q : vec3_scale(q, 1 / w);
}

vec3 transform_vector(const struct transform *t, vec3 v) {
    const float(*m)[4] = (const float(*)[4])t->m;
    return (vec3){m[0][0] * v.x + m[0][1] * v.y + m[0][2] * v.z, m[1][0] * v.x + m[1][1] * v.y + m[1][2] * v.z,
                  m[2][0] * v.x + m[2][1] * v.y + m[2][2] * v.z};
}

vec3 transform_normal(const struct transform *t, vec3 n) {
    const float(*i)[4] = (const float(*)[4])t->inverse;
    return (vec3){i[0][0] * n.x + i[1][0] * n.y + i[2][0] * n.z, i[0][1] * n.x + i[1][1] * n.y + i[2][1] * n.z,
                  i[0][2] * n.x + i[1][2] * n.y + i[2][2] * n.z};
}

static vec3 matrix_column(const struct transform *t, int j) { return (vec3){t->m[0][j], t->m[1][j], t->m[2][j]}; }

bool transform_flips_handedness(const struct transform *t) {
    return vec3_dot(vec3_cross(matrix_column(t, 0), matrix_column(t, 1)), matrix_column(t, 2)) < 0;
}

float transform_uniform_scale(const struct transform *t) {
    vec3 x = matrix_column(t, 0), y = matrix_column(t, 1), z = matrix_column(t, 2);
    float scale = vec3_length(x), tolerance = 1e-4f;
    bool affine = t->m[3][0] == 0 && t->m[3][1] == 0 && t->m[3][2] == 0 && t->m[3][3] == 1;
    bool equal =
        fabsf(vec3_length(y) - scale) <= tolerance * scale && fabsf(vec3_length(z) - scale) <= tolerance * scale;
    float skew = tolerance * scale * scale;
    bool orthogonal = fabsf(vec3_dot(x, y)) <= skew && fabsf(vec3_dot(y, z)) <= skew && fabsf(vec3_dot(z, x)) <= skew;
    return affine && equal && orthogonal && !transform_flips_handedness(t) ? scale : 0;
}
