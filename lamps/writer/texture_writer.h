// Textures: colours as a function of the place, written as 8-bit PNG.
#pragma once

#include <stdbool.h>
#include <stdio.h>

struct color {
    double r, g, b; // as the file has them: sRGB, 0 to 1
};

struct color color_mix(struct color a, struct color b, double t);
// A whole number's own number in [0, 1).
double texture_hash(int x, int y);
// Smooth noise in [0, 1]; repeats after `period` cells both ways.
double texture_noise(double x, double y, int period);
bool texture_write(FILE *file, struct color (*texture)(double u, double v));
