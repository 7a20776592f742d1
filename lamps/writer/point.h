// Points and vectors of the generators, in double so that what they print is the same on every machine.
#pragma once

#include <math.h>

static const double pi = 3.14159265358979323846;

struct point {
    double x, y, z;
};

static inline struct point point_add(struct point a, struct point b) {
    return (struct point){a.x + b.x, a.y + b.y, a.z + b.z};
}
static inline struct point point_scale(struct point a, double s) { return (struct point){a.x * s, a.y * s, a.z * s}; }
static inline struct point point_sub(struct point a, struct point b) { return point_add(a, point_scale(b, -1)); }
static inline struct point point_mix(struct point a, struct point b, double t) {
    return point_add(point_scale(a, 1 - t), point_scale(b, t));
}
static inline double point_dot(struct point a, struct point b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static inline double point_length(struct point a) { return sqrt(point_dot(a, a)); }
static inline struct point point_cross(struct point a, struct point b) {
    return (struct point){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
static inline struct point point_normalize(struct point a) { return point_scale(a, 1 / point_length(a)); }
// On the circle of `radius` about the vertical axis, at height y.
static inline struct point point_around(double radius, double y, double angle) {
    return (struct point){radius * cos(angle), y, radius * sin(angle)};
}
