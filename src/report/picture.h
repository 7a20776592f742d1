// Pictures made of pictures, for pages: differences and crops.
#pragma once

#include "image/image.h"

enum { DIFFERENCE_GAIN = 16 }; // differences are shown this many times brighter than the pictures

// |a - r| in RGB; both have the same size.
enum status image_difference(struct image *difference, const struct image *a, const struct image *r,
                             struct error *error);
// The RGB of width x height pixels whose top left corner is (x, y), each shown as zoom x zoom pixels.
enum status image_crop(struct image *crop, const struct image *image, int x, int y, int width, int height, int zoom,
                       struct error *error);
