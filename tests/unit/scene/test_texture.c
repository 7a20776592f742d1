// Textures: interpolation, wrapping, transforms and means against values worked out by hand (and seen in Mitsuba 3).
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <unistd.h>
#include <cmocka.h>

#include "image/image.h"
#include "../../bsdf_from_xml.h"

static char folder[] = "/tmp/test_texture_XXXXXX", exr[64], png[64];

// 2 x 2 texels: red, green; blue, white. And a PNG of one mid grey.
static int setup(void **state) {
    (void)state;
    if (!mkdtemp(folder)) return -1;
    snprintf(exr, sizeof exr, "%s/four.exr", folder);
    snprintf(png, sizeof png, "%s/gray.png", folder);
    struct image image;
    struct error error;
    if (image_init(&image, 2, 2, 3, &error) != STATUS_OK) return -1;
    const float four[12] = {1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 1};
    memcpy(image.pixels, four, sizeof four);
    if (image_save(&image, exr, 1, &error) != STATUS_OK) return -1;
    for (int i = 0; i < 12; ++i) image.pixels[i] = 0.21586050f; // sRGB 128
    if (image_save(&image, png, 1, &error) != STATUS_OK) return -1;
    image_fini(&image);
    return 0;
}

static int teardown(void **state) {
    (void)state;
    unlink(exr);
    unlink(png);
    return rmdir(folder);
}

struct textured {
    struct xml_plugins plugins;
    const struct texture *texture;
};

// The texture that a <texture ...> text describes.
static const struct texture *texture_make(struct textured *t, const char *xml) {
    struct error error;
    memset(t, 0, sizeof *t);
    size_t size = strlen(xml) + 64;
    char *text = malloc(size);
    snprintf(text, size, "<scene version='3.0.0'>%s</scene>", xml);
    if (description_parse(&t->plugins.description, "memory.xml", text, strlen(text), NULL, 0, NULL, &error) !=
        STATUS_OK)
        xml_fail(&error);
    free(text);
    struct object *object = t->plugins.description.root->children[0].object;
    if (xml_make_texture(&t->plugins, object, &t->texture, &error) != STATUS_OK) xml_fail(&error);
    return t->texture;
}

static void expect(const struct texture *t, float u, float v, float r, float g, float b) {
    rgb c = texture_eval(t, (vec2){u, v});
    if (fabsf(c.r - r) < 1e-5f && fabsf(c.g - g) < 1e-5f && fabsf(c.b - b) < 1e-5f) return;
    fail_msg("at (%g, %g): %g %g %g, should be %g %g %g", u, v, c.r, c.g, c.b, r, g, b);
}

static const struct texture *bitmap(struct textured *t, const char *file, const char *parameters) {
    char xml[600];
    snprintf(xml, sizeof xml, "<texture type='bitmap'><string name='filename' value='%s'/>%s</texture>", file,
             parameters);
    return texture_make(t, xml);
}

static void test_bilinear_repeat(void **state) {
    (void)state;
    struct textured t;
    const struct texture *b = bitmap(&t, exr, "");
    expect(b, 0.25f, 0.25f, 1, 0, 0); // centres of texels: the image's top row is at v = 0
    expect(b, 0.75f, 0.25f, 0, 1, 0);
    expect(b, 0.25f, 0.75f, 0, 0, 1);
    expect(b, 0.75f, 0.75f, 1, 1, 1);
    expect(b, 0.5f, 0.5f, 0.5f, 0.5f, 0.5f);
    expect(b, 0.1f, 0.2f, 0.66f, 0.3f, 0.1f); // across both borders, as Mitsuba 3.9
    expect(b, -2.9f, 7.2f, 0.66f, 0.3f, 0.1f);
    expect(b, 0, 0.25f, 0.5f, 0.5f, 0);
    expect(b, 1, 0.25f, 0.5f, 0.5f, 0);
    assert_true(fabsf(b->value.r - 0.5f) < 1e-6f && fabsf(b->value.b - 0.5f) < 1e-6f);
    xml_fini(&t.plugins);
}

// The exact 2 x 2 image: red, green / blue, white.
static void test_parameters_of_mitsuba_05(void **state) {
    (void)state;
    struct textured t;
    const struct texture *b = bitmap(&t, exr,
                                     "<string name='filterType' value='nearest'/><float name='uscale' value='2'/>"
                                     "<float name='uoffset' value='0.5'/><float name='voffset' value='-0.5'/>");
    expect(b, 0.1f, 0.1f, 1, 1, 1); // (0.7, -0.4)
    expect(b, 0.3f, 0.6f, 1, 0, 0); // (1.1, 0.1)
    xml_fini(&t.plugins);
    b = bitmap(&t, exr, "<float name='uvscale' value='0.5'/><string name='filterType' value='nearest'/>");
    expect(b, 1.5f, 0.5f, 0, 1, 0);
    xml_fini(&t.plugins);
    b = bitmap(&t, exr, "<string name='wrapMode' value='one'/><string name='channel' value='g'/>");
    expect(b, 0.75f, 0.25f, 1, 1, 1);
    expect(b, 0.25f, 0.25f, 0, 0, 0);
    expect(b, 1.25f, 0.25f, 1, 1, 1);
    xml_fini(&t.plugins);
    b = bitmap(&t, exr, "<float name='gamma' value='2'/>");
    expect(b, 0.25f, 0.25f, 1, 0, 0);
    xml_fini(&t.plugins);
}

static void test_wrap_and_filter(void **state) {
    (void)state;
    struct textured t;
    const struct texture *b = bitmap(&t, exr, "<string name='wrap_mode' value='clamp'/>");
    expect(b, 0, 0, 1, 0, 0);
    expect(b, -5, 0.25f, 1, 0, 0);
    expect(b, 9, 9, 1, 1, 1);
    xml_fini(&t.plugins);
    b = bitmap(&t, exr, "<string name='wrapMode' value='mirror'/>");
    expect(b, 0, 0.25f, 1, 0, 0); // the border meets its own image
    expect(b, -0.25f, 0.25f, 1, 0, 0);
    expect(b, 1.25f, 0.25f, 0, 1, 0);
    expect(b, 1.75f, 0.25f, 1, 0, 0);
    expect(b, 2, 0.25f, 1, 0, 0);
    xml_fini(&t.plugins);
    b = bitmap(&t, exr, "<string name='filter_type' value='nearest'/>");
    expect(b, 0.1f, 0.2f, 1, 0, 0);
    expect(b, 0.49f, 0.51f, 0, 0, 1);
    expect(b, 1, 0, 1, 0, 0);
    expect(b, -0.1f, 0, 0, 1, 0);
    xml_fini(&t.plugins);
}

static void test_to_uv(void **state) {
    (void)state;
    struct textured t;
    const struct texture *b = bitmap(&t, exr, "<transform name='to_uv'><translate x='0.1'/><scale x='2'/></transform>");
    expect(b, 0.1f, 0.25f, 0.7f, 0.3f, 0); // u = 2 (0.1 + 0.1), as Mitsuba 3.9
    xml_fini(&t.plugins);
}

static void test_raw(void **state) {
    (void)state;
    struct textured t;
    expect(bitmap(&t, png, ""), 0.3f, 0.3f, 0.2158605f, 0.2158605f, 0.2158605f);
    xml_fini(&t.plugins);
    expect(bitmap(&t, png, "<boolean name='raw' value='true'/>"), 0.3f, 0.3f, 128 / 255.0f, 128 / 255.0f, 128 / 255.0f);
    xml_fini(&t.plugins);
}

static void test_far_and_undefined_uv(void **state) {
    (void)state;
    const char *const wraps[] = {"repeat", "clamp", "mirror"};
    const float uvs[] = {0, 1, -1e-9f, 1e8f, -1e30f, INFINITY, -INFINITY, NAN};
    for (int w = 0; w < 3; ++w) {
        struct textured t;
        char parameter[100];
        snprintf(parameter, sizeof parameter, "<string name='wrap_mode' value='%s'/>", wraps[w]);
        const struct texture *b = bitmap(&t, exr, parameter);
        for (int i = 0; i < 64; ++i) assert_true(isfinite(rgb_mean(texture_eval(b, (vec2){uvs[i % 8], uvs[i / 8]}))));
        xml_fini(&t.plugins);
    }
}

static void test_checkerboard_and_scale(void **state) {
    (void)state;
    struct textured t;
    const struct texture *c = texture_make(&t, "<texture type='checkerboard'><float name='color0' value='0.1'/><rgb "
                                               "name='color1' value='0.9 0.5 0.3'/></texture>");
    expect(c, 0.1f, 0.1f, 0.1f, 0.1f, 0.1f);
    expect(c, 0.6f, 0.1f, 0.9f, 0.5f, 0.3f);
    expect(c, 0.1f, -0.4f, 0.9f, 0.5f, 0.3f);
    expect(c, 0.6f, 0.6f, 0.1f, 0.1f, 0.1f);
    assert_true(fabsf(c->value.g - 0.3f) < 1e-6f);
    xml_fini(&t.plugins);
    c = texture_make(&t, "<texture type='scale'><float name='scale' value='3'/><texture type='checkerboard'>"
                         "<float name='color0' value='0.1'/><float name='color1' value='0.2'/></texture></texture>");
    expect(c, 0.1f, 0.1f, 0.3f, 0.3f, 0.3f);
    expect(c, 0.6f, 0.1f, 0.6f, 0.6f, 0.6f);
    assert_true(fabsf(c->value.g - 0.45f) < 1e-6f);
    xml_fini(&t.plugins);
}

static void test_missing_file(void **state) {
    (void)state;
    struct xml_plugins plugins = {0};
    struct error error = {0};
    assert_null(xml_bsdf(&plugins,
                         "<bsdf type='diffuse'><texture type='bitmap' name='reflectance'>"
                         "<string name='filename' value='absent.png'/></texture></bsdf>",
                         &error));
    assert_int_equal(error.status, STATUS_IO);
    assert_non_null(strstr(error.text, "memory.xml:1:"));
    assert_non_null(strstr(error.text, "absent.png"));
}

// A tilted plane of heights bends the mirror direction by twice its slope's angle; so does the equivalent normal map.
static void test_bump_and_normal_maps(void **state) {
    (void)state;
    const float slope = 0.2f; // the image rises by 1 per u between its texel centres; scale and uv do the rest
    char ramp[80], xml[900];
    snprintf(ramp, sizeof ramp, "%s/ramp.exr", folder);
    struct image image;
    struct error error;
    assert_int_equal(image_init(&image, 64, 1, 3, &error), STATUS_OK);
    for (int i = 0; i < 64 * 3; ++i) image.pixels[i] = ((float)(i / 3) + 0.5f) / 64;
    assert_int_equal(image_save(&image, ramp, 1, &error), STATUS_OK);
    image_fini(&image);
    vec3 n = vec3_normalize((vec3){-slope, 0, 1});
    struct bsdf_point point = {{0.5f, 0.5f}, {{2, 0}, {0, 2}}};
    for (int kind = 0; kind < 2; ++kind) {
        struct xml_plugins plugins = {0};
        if (kind == 0) {
            snprintf(xml, sizeof xml,
                     "<bsdf type='mask'><float name='opacity' value='1'/><bsdf type='bumpmap'><texture type='bitmap' "
                     "name='any'><string name='filename' value='%s'/></texture><float name='scale' value='%g'/>"
                     "<bsdf type='conductor'/></bsdf></bsdf>",
                     ramp, (double)(slope / 2));
        } else {
            snprintf(
                xml, sizeof xml,
                "<bsdf type='normalmap'><rgb name='normalmap' value='%.8g %.8g %.8g'/><bsdf type='conductor'/></bsdf>",
                0.5 + 0.5 * n.x, 0.5, 0.5 + 0.5 * n.z);
        }
        const struct bsdf *b = xml_bsdf(&plugins, xml, &error);
        if (!b) xml_fail(&error);
        assert_int_equal(!!(b->flags & BSDF_BUMP), kind == 0);
        vec3 wi = vec3_normalize((vec3){0.3f, -0.2f, 1});
        struct bsdf_sample s;
        assert_true(bsdf_sample(b, &point, wi, (vec3){0.5f, 0.5f, 0.5f}, TRANSPORT_RADIANCE, &s));
        vec3 wanted = vec3_sub(vec3_scale(n, 2 * vec3_dot(n, wi)), wi);
        assert_true(vec3_length(vec3_sub(wanted, s.wo)) < 2e-3f);
        xml_fini(&plugins);
    }
    unlink(ramp);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_bilinear_repeat),
        cmocka_unit_test(test_wrap_and_filter),
        cmocka_unit_test(test_parameters_of_mitsuba_05),
        cmocka_unit_test(test_to_uv),
        cmocka_unit_test(test_raw),
        cmocka_unit_test(test_far_and_undefined_uv),
        cmocka_unit_test(test_checkerboard_and_scale),
        cmocka_unit_test(test_missing_file),
        cmocka_unit_test(test_bump_and_normal_maps),
    };
    return cmocka_run_group_tests(tests, setup, teardown);
}
