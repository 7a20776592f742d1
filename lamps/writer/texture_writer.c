#include "texture_writer.h"

#include <math.h>
#include <png.h>
#include <stdint.h>
#include <stdlib.h>

enum { TEXTURE_SIZE = 512 };

struct color color_mix(struct color a, struct color b, double t) {
    return (struct color){a.r + (b.r - a.r) * t, a.g + (b.g - a.g) * t, a.b + (b.b - a.b) * t};
}

double texture_hash(int x, int y) {
    uint32_t h = (uint32_t)x * 0x9e3779b9u ^ (uint32_t)y * 0x85ebca6bu;
    h = (h ^ h >> 16) * 0x7feb352du;
    h = (h ^ h >> 15) * 0x846ca68bu;
    return (double)(h ^ h >> 16) / 4294967296.0;
}

double texture_noise(double x, double y, int period) {
    int x0 = (int)floor(x), y0 = (int)floor(y);
    double fx = x - x0, fy = y - y0, corner[4];
    for (int i = 0; i < 4; i++) {
        int cx = (x0 + i % 2) % period, cy = (y0 + i / 2) % period;
        corner[i] = texture_hash(cx < 0 ? cx + period : cx, cy < 0 ? cy + period : cy);
    }
    fx = fx * fx * (3 - 2 * fx);
    fy = fy * fy * (3 - 2 * fy);
    double low = corner[0] + (corner[1] - corner[0]) * fx, high = corner[2] + (corner[3] - corner[2]) * fx;
    return low + (high - low) * fy;
}

bool texture_write(FILE *file, struct color (*texture)(double u, double v)) {
    uint8_t *samples = malloc(3 * TEXTURE_SIZE * TEXTURE_SIZE), *sample = samples;
    if (!samples) return false;
    for (int y = 0; y < TEXTURE_SIZE; y++)
        for (int x = 0; x < TEXTURE_SIZE; x++) {
            struct color color = texture((x + 0.5) / TEXTURE_SIZE, (y + 0.5) / TEXTURE_SIZE);
            const double channels[3] = {color.r, color.g, color.b};
            for (int c = 0; c < 3; c++) *sample++ = (uint8_t)(fmin(fmax(channels[c], 0), 1) * 255 + 0.5);
        }
    png_image png = {
        .version = PNG_IMAGE_VERSION, .width = TEXTURE_SIZE, .height = TEXTURE_SIZE, .format = PNG_FORMAT_RGB};
    bool written = png_image_write_to_stdio(&png, file, 0, samples, 0, NULL);
    free(samples);
    return written;
}
