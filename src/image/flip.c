// FLIP of two LDR images: Andersson et al. 2020, "FLIP: A Difference Evaluator for Alternating Images", PACM CGIT 3(2).
// Images are exposed, clamped to [0,1] and seen at 67 pixels per degree (a 0.7 m wide 4K screen at 0.7 m).
// Flow: colour pipeline (contrast sensitivity filters in YCxCz, Hunt adjustment, HyAB distance, remapped) and feature
// pipeline (edges and points of the luma); the feature difference is the exponent of the colour difference.
// No deviation: the filters are sums of Gaussians and their derivatives, so they run as rows, then columns.
// tests/reference/flip.py compares with the authors' program.
#include "image/metric.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>

enum { RADIUS_MAX = 16, TAPS_MAX = 2 * RADIUS_MAX + 1 };

static const double pixels_per_degree = 0.7 * (3840 / 0.7) * M_PI / 180;
static const double white[3] = {0.950428545, 1.0, 1.088900371}; // D65, the sums of the matrix rows below
static const double xyz_from_rgb[3][3] = {
    {10135552.0 / 24577794, 8788810.0 / 24577794, 4435075.0 / 24577794},
    {2613072.0 / 12288897, 8788810.0 / 12288897, 887015.0 / 12288897},
    {1425312.0 / 73733382, 8788810.0 / 73733382, 70074185.0 / 73733382},
};
static const double rgb_from_xyz[3][3] = {
    // the inverse of the above
    {3.241003232976359, -1.537398969488786, -0.498615881996363},
    {-0.969224252202517, 1.875929983695176, 0.041554226340085},
    {0.055639419851975, -0.204011206123910, 1.057148977187534},
};

typedef struct {
    float v[3];
} color;

struct kernel {
    int radius;
    float taps[TAPS_MAX];
};

static color matrix_apply(const double m[3][3], const double v[3]) {
    color result;
    for (int i = 0; i < 3; ++i) result.v[i] = (float)(m[i][0] * v[0] + m[i][1] * v[1] + m[i][2] * v[2]);
    return result;
}

static color ycxcz_from_rgb(color rgb) {
    color xyz = matrix_apply(xyz_from_rgb, (const double[3]){rgb.v[0], rgb.v[1], rgb.v[2]});
    double x = xyz.v[0] / white[0], y = xyz.v[1] / white[1], z = xyz.v[2] / white[2];
    return (color){{(float)(116 * y - 16), (float)(500 * (x - y)), (float)(200 * (y - z))}};
}

static color rgb_from_ycxcz(color c) {
    double y = ((double)c.v[0] + 16) / 116, x = y + (double)c.v[1] / 500, z = y - (double)c.v[2] / 200;
    return matrix_apply(rgb_from_xyz, (const double[3]){x * white[0], y * white[1], z * white[2]});
}

static double lab_curve(double t) { // CIE 1976
    const double delta = 6.0 / 29;
    return t > delta * delta * delta ? cbrt(t) : t / (3 * delta * delta) + 4.0 / 29;
}

// L*a*b* with chroma scaled by the lightness (Hunt 1952).
static color hunt_lab_from_rgb(color rgb) {
    color xyz = matrix_apply(xyz_from_rgb, (const double[3]){rgb.v[0], rgb.v[1], rgb.v[2]});
    double x = lab_curve(xyz.v[0] / white[0]), y = lab_curve(xyz.v[1] / white[1]), z = lab_curve(xyz.v[2] / white[2]);
    double lightness = 116 * y - 16;
    return (color){
        {(float)lightness, (float)(0.01 * lightness * 500 * (x - y)), (float)(0.01 * lightness * 200 * (y - z))}};
}

static double hyab(color a, color b) {
    double da = (double)a.v[1] - (double)b.v[1], db = (double)a.v[2] - (double)b.v[2];
    return fabs((double)a.v[0] - (double)b.v[0]) + sqrt(da * da + db * db);
}

// One pass along rows or columns; the border pixel is repeated.
static void convolve(const float *source, float *target, int width, int height, const struct kernel *kernel,
                     bool along_x) {
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            double sum = 0;
            for (int k = -kernel->radius; k <= kernel->radius; ++k) {
                int sx = along_x ? x + k : x, sy = along_x ? y : y + k;
                sx = sx < 0 ? 0 : sx >= width ? width - 1 : sx;
                sy = sy < 0 ? 0 : sy >= height ? height - 1 : sy;
                sum +=
                    (double)kernel->taps[k + kernel->radius] * (double)source[(size_t)sy * (size_t)width + (size_t)sx];
            }
            target[(size_t)y * (size_t)width + (size_t)x] = (float)sum;
        }
    }
}

// The contrast sensitivity functions as Gaussians a sqrt(pi / b) exp(-pi^2 d^2 / b), d in degrees (table 1 of the
// paper).
static const struct sensitivity {
    double a[2], b[2];
} sensitivities[3] = {
    {{1, 0}, {0.0047, 1e-5}}, // achromatic
    {{1, 0}, {0.0053, 1e-5}}, // red-green
    {{34.1, 13.5}, {0.04, 0.025}}, // blue-yellow
};

static struct kernel gaussian_kernel(double b) {
    struct kernel kernel = {.radius = (int)ceil(3 * sqrt(0.04 / (2 * M_PI * M_PI)) * pixels_per_degree)};
    for (int k = -kernel.radius; k <= kernel.radius; ++k) {
        double d = k / pixels_per_degree;
        kernel.taps[k + kernel.radius] = (float)exp(-M_PI * M_PI * d * d / b);
    }
    return kernel;
}

static double kernel_sum(const struct kernel *kernel) {
    double sum = 0;
    for (int k = 0; k <= 2 * kernel->radius; ++k) sum += (double)kernel->taps[k];
    return sum;
}

// plane := its convolution with the sensitivity, whose weights sum to 1. Two scratch planes.
static void filter_plane(float *plane, float *rows, float *both, int width, int height, const struct sensitivity *s) {
    size_t count = (size_t)width * (size_t)height;
    struct kernel kernels[2] = {gaussian_kernel(s->b[0]), gaussian_kernel(s->b[1])};
    double weights[2], total = 0;
    for (int i = 0; i < 2; ++i) {
        weights[i] = s->a[i] * sqrt(M_PI / s->b[i]);
        total += weights[i] * kernel_sum(&kernels[i]) * kernel_sum(&kernels[i]);
    }
    float *sum = both + count;
    for (size_t i = 0; i < count; ++i) sum[i] = 0;
    for (int i = 0; i < 2; ++i) {
        if (weights[i] == 0) continue;
        convolve(plane, rows, width, height, &kernels[i], true);
        convolve(rows, both, width, height, &kernels[i], false);
        for (size_t p = 0; p < count; ++p) sum[p] += (float)(weights[i] / total) * both[p];
    }
    for (size_t i = 0; i < count; ++i) plane[i] = sum[i];
}

// Gaussian, first and second derivative (section 4.2); lobes of either sign sum to 1 in absolute value.
static void feature_kernels(struct kernel *smooth, struct kernel *edge, struct kernel *point) {
    double deviation = 0.5 * 0.082 * pixels_per_degree;
    int radius = (int)ceil(3 * deviation);
    double sum = 0, edge_sum = 0, positive = 0, negative = 0;
    smooth->radius = edge->radius = point->radius = radius;
    for (int pass = 0; pass < 2; ++pass) {
        for (int k = -radius; k <= radius; ++k) {
            double g = exp(-k * k / (2 * deviation * deviation)), second = (k * k / (deviation * deviation) - 1) * g;
            if (pass == 0) {
                sum += g;
                edge_sum += k > 0 ? k * g : 0;
                positive += fmax(second, 0);
                negative -= fmin(second, 0);
            } else {
                smooth->taps[k + radius] = (float)(g / sum);
                edge->taps[k + radius] = (float)(-k * g / edge_sum);
                point->taps[k + radius] = (float)(second / (second > 0 ? positive : negative));
            }
        }
    }
}

// Planes kept of one image: 3 of YCxCz, later of Hunt-adjusted L*a*b*; edge and point strength; scratch.
enum { EDGE = 3, POINT = 4, SCRATCH = 5, PLANES = 9 };

static void detect_features(float *planes, size_t count, int width, int height) {
    struct kernel smooth, edge, point;
    feature_kernels(&smooth, &edge, &point);
    float *rows = planes + SCRATCH * count, *gx = rows + count, *gy = gx + count, *luma = gy + count;
    for (size_t i = 0; i < count; ++i) luma[i] = (planes[i] + 16) / 116;
    const struct kernel *kernels[2] = {&edge, &point};
    for (int k = 0; k < 2; ++k) {
        convolve(luma, rows, width, height, kernels[k], true);
        convolve(rows, gx, width, height, &smooth, false);
        convolve(luma, rows, width, height, &smooth, true);
        convolve(rows, gy, width, height, kernels[k], false);
        float *strength = planes + (size_t)(EDGE + k) * count;
        for (size_t i = 0; i < count; ++i) strength[i] = hypotf(gx[i], gy[i]);
    }
}

static float *view_image(const struct image *image, float exposure) {
    size_t count = (size_t)image->width * (size_t)image->height;
    float *planes = count <= SIZE_MAX / (PLANES * sizeof *planes) ? calloc(count, PLANES * sizeof *planes) : NULL;
    if (!planes) return NULL;
    for (size_t i = 0; i < count; ++i) {
        color rgb;
        for (int c = 0; c < 3; ++c)
            rgb.v[c] = fminf(fmaxf(image->pixels[i * (size_t)image->channels + (size_t)c] * exposure, 0), 1);
        color opponent = ycxcz_from_rgb(rgb);
        for (int c = 0; c < 3; ++c) planes[(size_t)c * count + i] = opponent.v[c];
    }
    detect_features(planes, count, image->width, image->height);
    float *rows = planes + SCRATCH * count;
    for (int c = 0; c < 3; ++c) {
        filter_plane(planes + (size_t)c * count, rows, rows + count, image->width, image->height, &sensitivities[c]);
    }
    for (size_t i = 0; i < count; ++i) {
        color rgb = rgb_from_ycxcz((color){{planes[i], planes[count + i], planes[2 * count + i]}});
        for (int c = 0; c < 3; ++c) rgb.v[c] = fminf(fmaxf(rgb.v[c], 0), 1);
        color lab = hunt_lab_from_rgb(rgb);
        for (int c = 0; c < 3; ++c) planes[(size_t)c * count + i] = lab.v[c];
    }
    return planes;
}

static color plane_color(const float *planes, size_t count, size_t i) {
    return (color){{planes[i], planes[count + i], planes[2 * count + i]}};
}

enum status flip_map(struct image *map, const struct image *image, const struct image *reference, float exposure,
                     struct error *error) {
    *map = (struct image){0};
    if (image->width != reference->width || image->height != reference->height || image->channels < 3 ||
        reference->channels < 3) {
        return error_set(error, STATUS_INVALID, "FLIP needs two RGB images of one size");
    }
    size_t count = (size_t)image->width * (size_t)image->height;
    float *a = view_image(image, exposure), *b = view_image(reference, exposure);
    enum status status = a && b ? image_init(map, image->width, image->height, 1, error)
                                : error_set(error, STATUS_MEMORY, "out of memory for FLIP of %zu pixels", count);
    // The largest colour difference is that of green and blue; below 0.4 of it the errors take 95 % of the range.
    double largest = pow(hyab(hunt_lab_from_rgb((color){{0, 1, 0}}), hunt_lab_from_rgb((color){{0, 0, 1}})), 0.7),
           knee = 0.4 * largest;
    for (size_t i = 0; i < count && status == STATUS_OK; ++i) {
        double power = pow(hyab(plane_color(a, count, i), plane_color(b, count, i)), 0.7);
        double color_error = power < knee ? 0.95 / knee * power : 0.95 + (power - knee) / (largest - knee) * 0.05;
        double edge = fabs((double)a[EDGE * count + i] - (double)b[EDGE * count + i]);
        double point = fabs((double)a[POINT * count + i] - (double)b[POINT * count + i]);
        double feature_error = fmin(1, sqrt(fmax(edge, point) / sqrt(2)));
        map->pixels[i] = (float)pow(fmin(color_error, 1), 1 - feature_error);
    }
    free(a);
    free(b);
    return status;
}
