// The rooms' textures: wood, cloth, stone, brick, pictures.
#include <math.h>

#include "writer/model.h"

static double fractal(double u, double v, int period) {
    double sum = 0, weight = 0.5;
    for (int octave = 0; octave < 5; octave++, weight *= 0.5, period *= 2)
        sum += weight * texture_noise(u * period, v * period, period);
    return sum / 0.96875;
}

// Grain along v.
static struct color grain(double u, double v, double shift) {
    double wave = texture_noise(8 * u + 13 * shift, 2 * v + 7 * shift, 64);
    double rings = 0.5 + 0.5 * sin(2 * pi * (14 * u + 3.0 * wave));
    double fibre = texture_noise(220 * u, 6 * v + 31 * shift, 256);
    struct color dark = {0.42, 0.27, 0.17}, light = {0.70, 0.51, 0.34};
    return color_mix(dark, light, 0.15 + 0.5 * rings * wave + 0.35 * fibre);
}

static struct color wood(double u, double v) { return grain(u, v, 0); }

// Eight boards side by side, each in two pieces.
static struct color planks(double u, double v) {
    int board = (int)(8 * u);
    double across = 8 * u - board, along = v + 0.37 * board;
    int piece = (int)(2 * along);
    double tone = 0.78 + 0.30 * texture_hash(board, piece % 2);
    double shift = texture_hash(board + 40, piece % 2);
    struct color color = grain(0.12 * across + shift, along, shift);
    double joint = fmin(fmin(across, 1 - across) * 60, fabs(2 * along - piece - 0.5) > 0.497 ? 0.3 : 1);
    tone *= fmin(1, 0.35 + 0.65 * fmin(joint, 1));
    return (struct color){color.r * tone, color.g * tone, color.b * tone};
}

// A plain weave.
static struct color cloth(double u, double v) {
    double x = 64 * u, y = 64 * v;
    bool over = ((int)x + (int)y) % 2;
    double thread = over ? sin(pi * (x - floor(x))) : sin(pi * (y - floor(y)));
    double tone = 0.62 + 0.22 * thread + 0.16 * fractal(u, v, 16);
    return (struct color){tone, tone * 0.98, tone * 0.95};
}

static struct color marble(double u, double v) {
    double vein = fabs(sin(pi * (2 * (u + v) + 2.4 * fractal(u, v, 4))));
    double cloud = fractal(u + 0.3, v + 0.7, 6);
    struct color stone = color_mix((struct color){0.86, 0.84, 0.80}, (struct color){0.74, 0.71, 0.68}, cloud);
    return color_mix((struct color){0.38, 0.34, 0.31}, stone, fmin(1, 0.35 + 2.6 * vein));
}

static struct color brick(double u, double v) {
    int row = (int)(16 * v);
    double y = 16 * v - row, x = 6 * u + 0.5 * (row % 2);
    int column = (int)x % 6;
    x -= floor(x);
    double edge = fmin(fmin(x, 1 - x) * 22, fmin(y, 1 - y) * 8);
    struct color red = {0.58, 0.30, 0.22}, brown = {0.42, 0.24, 0.19}, mortar = {0.66, 0.62, 0.57};
    struct color body = color_mix(red, brown, 0.7 * texture_hash(row, column) + 0.4 * fractal(u, v, 16) - 0.1);
    return color_mix(mortar, body, fmin(1, fmax(0, edge - 0.5)));
}

// A carpet: a border, a field of lozenges.
static struct color carpet(double u, double v) {
    double edge = fmin(fmin(u, 1 - u), fmin(v, 1 - v));
    double lozenge = fabs(fmod(8 * u, 1) - 0.5) + fabs(fmod(8 * v, 1) - 0.5);
    struct color red = {0.46, 0.12, 0.11}, cream = {0.80, 0.72, 0.58}, blue = {0.13, 0.18, 0.30};
    struct color color = lozenge < 0.18 ? cream : lozenge < 0.42 ? blue : red;
    if (edge < 0.11) color = fmod(24 * (u + v), 1) < 0.5 ? blue : cream;
    if (edge < 0.030 || (edge > 0.095 && edge < 0.11)) color = red;
    double pile = 0.85 + 0.25 * texture_noise(180 * u, 180 * v, 180);
    return (struct color){color.r * pile, color.g * pile, color.b * pile};
}

// A landscape at dusk: sky, sun, hills, water.
static struct color landscape(double u, double v) {
    struct color sky = color_mix((struct color){0.95, 0.62, 0.32}, (struct color){0.20, 0.30, 0.52},
                                 fmin(1, fmax(0, 1.7 * (v - 0.35))));
    double sun = hypot(u - 0.64, 0.9 * (v - 0.52));
    if (sun < 0.055) sky = (struct color){1.0, 0.90, 0.66};
    sky = color_mix(sky, (struct color){1.0, 0.78, 0.50}, 0.5 * exp(-9 * sun));
    struct color color = sky;
    for (int hill = 0; hill < 4; hill++) {
        double ridge = 0.50 - 0.07 * hill + 0.16 * (fractal(0.8 * u + 0.23 * hill, 0.1 * hill, 5) - 0.5);
        struct color near = {0.07, 0.13, 0.12}, far = {0.50, 0.40, 0.44};
        if (v < ridge) color = color_mix(far, near, hill / 3.0);
    }
    if (v < 0.20)
        color = color_mix((struct color){0.12, 0.18, 0.26}, sky, 0.35 + 0.4 * texture_noise(10 * u, 90 * v, 90));
    double brush = 0.90 + 0.2 * texture_noise(60 * u, 24 * v, 60);
    return (struct color){color.r * brush, color.g * brush, color.b * brush};
}

// Overlapping discs and bars.
static struct color abstract(double u, double v) {
    struct color color = {0.90, 0.86, 0.78};
    static const struct {
        double u, v, r;
        struct color color;
    } discs[] = {{0.30, 0.62, 0.24, {0.75, 0.22, 0.14}},
                 {0.62, 0.40, 0.30, {0.13, 0.25, 0.42}},
                 {0.74, 0.74, 0.13, {0.88, 0.64, 0.18}},
                 {0.24, 0.26, 0.11, {0.12, 0.12, 0.12}}};
    for (int i = 0; i < 4; i++)
        if (hypot(u - discs[i].u, v - discs[i].v) < discs[i].r) color = color_mix(color, discs[i].color, 0.88);
    if (fabs(v - 0.5 - 0.18 * (u - 0.5)) < 0.012 || fabs(u - 0.44 + 0.1 * v) < 0.008)
        color = (struct color){0.1, 0.1, 0.1};
    double canvas = 0.94 + 0.08 * texture_noise(150 * u, 150 * v, 150);
    return (struct color){color.r * canvas, color.g * canvas, color.b * canvas};
}

// The backs of books: a palette in 16 columns, each with two lines in gold.
static struct color book_backs(double u, double v) {
    int book = (int)(16 * u);
    double hue = texture_hash(book, 3), tone = 0.25 + 0.45 * texture_hash(book, 5);
    struct color color = color_mix((struct color){0.75, 0.30, 0.20}, (struct color){0.18, 0.36, 0.48}, hue);
    color = color_mix(color, (struct color){0.85, 0.78, 0.62}, texture_hash(book, 9) > 0.7 ? 0.8 : 0.05);
    if (fabs(v - 0.82) < 0.012 || fabs(v - 0.74) < 0.006 || fabs(v - 0.12) < 0.012)
        return (struct color){0.78, 0.62, 0.30};
    return (struct color){color.r * tone * 1.5, color.g * tone * 1.5, color.b * tone * 1.5};
}

const struct model model = {"make_textures", (const struct model_file[]){{"wood.png", .texture = wood},
                                                                         {"planks.png", .texture = planks},
                                                                         {"cloth.png", .texture = cloth},
                                                                         {"marble.png", .texture = marble},
                                                                         {"brick.png", .texture = brick},
                                                                         {"carpet.png", .texture = carpet},
                                                                         {"landscape.png", .texture = landscape},
                                                                         {"abstract.png", .texture = abstract},
                                                                         {"books.png", .texture = book_backs},
                                                                         {0}}};
