// Image files. EXR files of every compression are made by the OpenEXR C++ library (through its C wrapper), which shares
// no code with the OpenEXRCore that image_exr.c reads with.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>
#include <cmocka.h>
#include <ImfCRgbaFile.h>

#include "base/file.h"
#include "image/image.h"

static char path[64];

static int make_path(void **state) {
    (void)state;
    snprintf(path, sizeof path, "/tmp/sconce_test_image_%ld.exr", (long)getpid());
    return 0;
}

static int remove_path(void **state) {
    (void)state;
    remove(path);
    return 0;
}

static void test_named_channels(void **state) {
    (void)state;
    struct image a, b;
    assert_int_equal(image_init(&a, 37, 53, 5, NULL), STATUS_OK);
    char names[5][32] = {"variance.R", "R", "B", "G", "albedo"};
    a.channel_names = malloc(sizeof names);
    assert_non_null(a.channel_names);
    memcpy(a.channel_names, names, sizeof names);
    for (int i = 0; i < 37 * 53 * 5; ++i) a.pixels[i] = sinf((float)i) * expf((float)(i % 60) - 30);
    assert_int_equal(image_save(&a, path, 1, NULL), STATUS_OK);
    assert_int_equal(image_load(&b, path, false, NULL), STATUS_OK);
    assert_int_equal(b.width, 37);
    assert_int_equal(b.height, 53);
    assert_int_equal(b.channels, 5);
    const char *expected[] = {"R", "G", "B", "albedo", "variance.R"};
    const int source[] = {1, 3, 2, 4, 0};
    for (int c = 0; c < 5; ++c) {
        assert_string_equal(b.channel_names[c], expected[c]);
        for (int i = 0; i < 37 * 53; ++i) assert_float_equal(b.pixels[i * 5 + c], a.pixels[i * 5 + source[c]], 0);
    }
    // The C++ library reads the same colours (as half).
    ImfInputFile *file = ImfOpenInputFile(path);
    assert_non_null(file);
    ImfRgba *rgba = calloc(37 * 53, sizeof *rgba);
    assert_non_null(rgba);
    assert_true(ImfInputSetFrameBuffer(file, rgba, 1, 37) && ImfInputReadPixels(file, 0, 52));
    ImfCloseInputFile(file);
    for (int i = 0; i < 37 * 53; ++i) {
        float g = a.pixels[i * 5 + 3];
        if (fabsf(g) > 1e-4f && fabsf(g) < 6e4f) assert_float_equal(ImfHalfToFloat(rgba[i].g), g, fabsf(g) * 1e-3f);
    }
    free(rgba);
    image_fini(&a);
    image_fini(&b);
}

enum { WIDTH = 75, HEIGHT = 70 };

static void fill_rgba(ImfRgba *rgba) {
    for (int i = 0; i < WIDTH * HEIGHT; ++i) {
        ImfFloatToHalf(0.01f * (float)(i % WIDTH), &rgba[i].r);
        ImfFloatToHalf(0.02f * (float)(i / WIDTH), &rgba[i].g);
        ImfFloatToHalf(1 + sinf(0.01f * (float)i), &rgba[i].b);
        ImfFloatToHalf(0.5f, &rgba[i].a);
    }
}

// image_load of the file at `path` is what the C++ library reads of it, and where that is lossless what was written.
static void assert_rgba(const ImfRgba *written, bool lossless, bool supported) {
    static ImfRgba buffer[(HEIGHT + 8) * WIDTH];
    ImfRgba *rgba = buffer + 8 * WIDTH;
    ImfInputFile *file = ImfOpenInputFile(path);
    assert_non_null(file);
    assert_true(ImfInputSetFrameBuffer(file, rgba + 3 - 7 * WIDTH, 1, WIDTH) &&
                ImfInputReadPixels(file, 7, HEIGHT + 6));
    ImfCloseInputFile(file);
    if (lossless) assert_memory_equal(rgba, written, sizeof *written * WIDTH * HEIGHT);
    float tolerance = lossless ? 0 : 1e-3f;
    struct image image;
    struct error error = {0};
    enum status status = image_load(&image, path, false, &error);
    if (!supported) {
        assert_int_equal(status, STATUS_UNSUPPORTED);
        return;
    }
    if (status != STATUS_OK) fail_msg("%s", error.text);
    assert_int_equal(image.width, WIDTH);
    assert_int_equal(image.height, HEIGHT);
    assert_int_equal(image.channels, 4);
    for (int i = 0; i < WIDTH * HEIGHT; ++i) {
        assert_float_equal(image.pixels[4 * i], ImfHalfToFloat(rgba[i].r), tolerance);
        assert_float_equal(image.pixels[4 * i + 1], ImfHalfToFloat(rgba[i].g), tolerance);
        assert_float_equal(image.pixels[4 * i + 2], ImfHalfToFloat(rgba[i].b), tolerance);
        assert_float_equal(image.pixels[4 * i + 3], ImfHalfToFloat(rgba[i].a), tolerance);
    }
    image_fini(&image);
}

// The data window does not start at 0, and neither side is a multiple of a tile or of a compressed block.
static void test_foreign_files(void **state) {
    (void)state;
    // Rows in front stay unused: the frame buffer's origin lies there.
    static ImfRgba buffer[(HEIGHT + 8) * WIDTH];
    ImfRgba *rgba = buffer + 8 * WIDTH;
    fill_rgba(rgba);
    const int lossless[] = {IMF_NO_COMPRESSION,  IMF_RLE_COMPRESSION, IMF_ZIPS_COMPRESSION,
                            IMF_ZIP_COMPRESSION, IMF_PIZ_COMPRESSION, IMF_PXR24_COMPRESSION};
    const int lossy[] = {IMF_B44_COMPRESSION, IMF_B44A_COMPRESSION, IMF_DWAA_COMPRESSION, IMF_DWAB_COMPRESSION};
    for (int k = 0; k < 10; ++k) {
        ImfHeader *header = ImfNewHeader();
        ImfHeaderSetDataWindow(header, -3, 7, WIDTH - 4, HEIGHT + 6);
        ImfHeaderSetCompression(header, k < 6 ? lossless[k] : lossy[k - 6]);
        ImfRgba *origin = rgba + 3 - 7 * WIDTH;
        ImfOutputFile *file = ImfOpenOutputFile(path, header, IMF_WRITE_RGBA);
        assert_non_null(file);
        assert_true(ImfOutputSetFrameBuffer(file, origin, 1, WIDTH) && ImfOutputWritePixels(file, HEIGHT));
        ImfCloseOutputFile(file);
        assert_rgba(rgba, k < 6, k < 8);
        ImfTiledOutputFile *tiled =
            ImfOpenTiledOutputFile(path, header, IMF_WRITE_RGBA, 32, 16, IMF_ONE_LEVEL, IMF_ROUND_DOWN);
        assert_non_null(tiled);
        assert_true(ImfTiledOutputSetFrameBuffer(tiled, origin, 1, WIDTH) &&
                    ImfTiledOutputWriteTiles(tiled, 0, 2, 0, 4, 0, 0));
        ImfCloseTiledOutputFile(tiled);
        assert_rgba(rgba, k < 6, k < 8);
        ImfDeleteHeader(header);
    }
}

// Any truncation or flipped byte gives an error or an image, never a crash.
static void test_damaged_exr(void **state) {
    (void)state;
    struct image image;
    struct error error;
    uint8_t *bytes;
    size_t length;
    assert_int_equal(image_init(&image, 20, 20, 3, NULL), STATUS_OK);
    assert_int_equal(image_save(&image, path, 1, NULL), STATUS_OK);
    image_fini(&image);
    assert_int_equal(file_read(path, &bytes, &length, NULL), STATUS_OK);
    for (size_t i = 0; i < length; ++i) {
        assert_int_equal(file_write_atomic(path, bytes, i, NULL), STATUS_OK);
        assert_true(image_load(&image, path, false, &error) != STATUS_OK);
        assert_non_null(strstr(error.text, path));
        bytes[i] ^= 0x55;
        assert_int_equal(file_write_atomic(path, bytes, length, NULL), STATUS_OK);
        if (image_load(&image, path, false, &error) == STATUS_OK) image_fini(&image);
        bytes[i] ^= 0x55;
    }
    free(bytes);
}

static void test_full_disk(void **state) {
    (void)state;
    struct image image;
    struct error error;
    assert_int_equal(image_init(&image, 200, 200, 3, NULL), STATUS_OK);
    for (int i = 0; i < 120000; ++i) image.pixels[i] = sinf((float)i * (float)i);
    remove(path);
    struct rlimit limit, small;
    getrlimit(RLIMIT_FSIZE, &limit);
    small = limit;
    small.rlim_cur = 10000;
    signal(SIGXFSZ, SIG_IGN);
    setrlimit(RLIMIT_FSIZE, &small);
    enum status status = image_save(&image, path, 1, &error);
    setrlimit(RLIMIT_FSIZE, &limit);
    assert_int_equal(status, STATUS_IO);
    assert_int_not_equal(access(path, F_OK), 0);
    assert_int_equal(image_save(&image, "/nowhere/a.exr", 1, &error), STATUS_IO);
    assert_non_null(strstr(error.text, "/nowhere/a.exr"));
    assert_int_equal(image_save(&image, "a.tga", 1, &error), STATUS_INVALID);
    image_fini(&image);
}

static void test_png(void **state) {
    (void)state;
    struct image a, b;
    assert_int_equal(image_init(&a, 256, 2, 3, NULL), STATUS_OK);
    for (int i = 0; i < 512; ++i) {
        for (int c = 0; c < 3; ++c) a.pixels[3 * i + c] = linear_from_srgb((float)(i % 256) / 255) * 0.25f;
    }
    a.pixels[0] = NAN;
    a.pixels[1] = -1;
    a.pixels[255 * 3] = INFINITY;
    char png[64];
    snprintf(png, sizeof png, "%.*spng", (int)strlen(path) - 3, path);
    assert_int_equal(image_save(&a, png, 4, NULL), STATUS_OK); // exposure 4 undoes the 0.25
    assert_int_equal(image_load(&b, png, true, NULL), STATUS_OK);
    assert_int_equal(b.channels, 3);
    for (int i = 0; i < 512; ++i) assert_float_equal(b.pixels[3 * i + 2], (float)(i % 256) / 255, 1e-7f);
    assert_float_equal(b.pixels[0], 0, 0);
    assert_float_equal(b.pixels[1], 0, 0);
    assert_float_equal(b.pixels[255 * 3], 1, 0);
    image_fini(&b);
    assert_int_equal(image_load(&b, png, false, NULL), STATUS_OK);
    assert_float_equal(b.pixels[3 * 188 + 1], 0.5028865f, 1e-6f); // ((188/255 + .055) / 1.055)^2.4
    image_fini(&b);
    image_fini(&a);
    assert_int_equal(image_init(&a, 2, 1, 4, NULL), STATUS_OK);
    a.pixels[3] = 0.5f; // alpha stays linear and without exposure
    assert_int_equal(image_save(&a, png, 9, NULL), STATUS_OK);
    assert_int_equal(image_load(&b, png, false, NULL), STATUS_OK);
    assert_int_equal(b.channels, 4);
    assert_float_equal(b.pixels[3], 128 / 255.0f, 1e-6f);
    image_fini(&b);
    image_fini(&a);
    struct error error;
    assert_int_equal(file_write_atomic(png, "\x89PNG\r\n\x1a\nnonsense", 16, NULL), STATUS_OK);
    assert_int_equal(image_load(&b, png, false, &error), STATUS_INVALID);
    assert_non_null(strstr(error.text, png));
    remove(png);
    assert_int_equal(image_load(&b, png, false, &error), STATUS_IO);
}

static void test_sizes(void **state) {
    (void)state;
    struct image image;
    struct error error;
    assert_int_equal(image_init(&image, 0, 5, 3, &error), STATUS_INVALID);
    assert_int_equal(image_init(&image, 1 << 30, 1 << 30, 3, &error), STATUS_INVALID);
    assert_int_equal(image_init(&image, 5, 5, -1, &error), STATUS_INVALID);
    for (int i = 0; i <= 255; ++i) {
        float v = (float)i / 255;
        assert_float_equal(srgb_from_linear(linear_from_srgb(v)), v, 1e-6f);
    }
}

// Data that hardly shrink, which an encoder may store or deflate.
static void test_exr_keeps_data_that_hardly_compress(void **state) {
    (void)state;
    char stored[] = "/tmp/sconce_exr_XXXXXX.exr";
    int file = mkstemps(stored, 4);
    assert_true(file >= 0);
    close(file);
    srand(1);
    for (int trial = 0; trial < 40; trial++) {
        struct image image, back;
        assert_int_equal(image_init(&image, 32, 32, 3, NULL), STATUS_OK);
        for (int i = 0; i < 32 * 32 * 3; i++) {
            uint32_t bits = ((uint32_t)rand() << 16 ^ (uint32_t)rand()) & 0x3fffffffu;
            if (rand() % 1000 < 40 + trial % 30) bits = 0x3f000000u;
            memcpy(&image.pixels[i], &bits, 4);
        }
        assert_int_equal(image_save(&image, stored, 1, NULL), STATUS_OK);
        assert_int_equal(image_load(&back, stored, false, NULL), STATUS_OK);
        assert_memory_equal(image.pixels, back.pixels, 32 * 32 * 3 * sizeof(float));
        image_fini(&image);
        image_fini(&back);
    }
    unlink(stored);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_exr_keeps_data_that_hardly_compress),
        cmocka_unit_test(test_named_channels),
        cmocka_unit_test(test_foreign_files),
        cmocka_unit_test(test_damaged_exr),
        cmocka_unit_test(test_full_disk),
        cmocka_unit_test(test_png),
        cmocka_unit_test(test_sizes),
    };
    return cmocka_run_group_tests(tests, make_path, remove_path);
}
