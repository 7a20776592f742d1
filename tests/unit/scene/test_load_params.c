// Declared parameters against a table of the test's own: every type, default, range and message.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <cmocka.h>

#include "scene/params.h"

struct plugin {
    bool flag;
    int count, choice, other_choice;
    float size, required;
    const char *text, *optional;
    rgb color, light;
    vec3 point;
    struct transform matrix;
    const struct texture *texture, *none;
};

static const struct param table[] = {
    {"flag", PARAM_BOOL, offsetof(struct plugin, flag), "true", .help = ""},
    {"count", PARAM_INT, offsetof(struct plugin, count), "3", .min = 1, .max = 10},
    {"choice", PARAM_CHOICE, offsetof(struct plugin, choice), "ggx", .choices = "beckmann|ggx|phong"},
    {"other_choice", PARAM_CHOICE, offsetof(struct plugin, other_choice), "a", .choices = "a|b"},
    {"size", PARAM_FLOAT, offsetof(struct plugin, size), "0.25", .min = 0, .max = 90, .unit = "degrees",
     .alias = "extent"},
    {"text", PARAM_STRING, offsetof(struct plugin, text), "bk7", .help = ""},
    {"optional", PARAM_STRING, offsetof(struct plugin, optional), "", .help = ""},
    {"color", PARAM_RGB, offsetof(struct plugin, color), "0.1 0.2 0.3", .max = 1},
    {"light", PARAM_RGB, offsetof(struct plugin, light), "2", .help = ""},
    {"point", PARAM_VEC3, offsetof(struct plugin, point), "1 2 3", .help = ""},
    {"matrix", PARAM_TRANSFORM, offsetof(struct plugin, matrix), "", .help = ""},
    {"texture", PARAM_TEXTURE, offsetof(struct plugin, texture), "0.5", .max = 1},
    {"none", PARAM_TEXTURE, offsetof(struct plugin, none), "", .help = ""},
    {"required", PARAM_FLOAT, offsetof(struct plugin, required), NULL, .help = "the one that must be there"},
    PARAM_END,
};

static struct error error;
static struct description parsed;
static struct plugin plugin;
static const struct texture marker = {.value = {7, 7, 7}};

static enum status make_texture(void *user, struct object *object, const struct texture **texture, struct error *e) {
    (void)user, (void)object, (void)e;
    *texture = &marker;
    return STATUS_OK;
}

static enum status read_inside(const char *tag, const char *inside) {
    char text[1000];
    snprintf(text, sizeof text, "<scene><%s type=\"gadget\">\n%s</%s></scene>", tag, inside, tag);
    plugin = (struct plugin){0};
    error.text[0] = 0;
    enum status status = description_parse(&parsed, "s.xml", text, strlen(text), NULL, 0, NULL, &error);
    assert_int_equal(status, STATUS_OK);
    struct object *object = parsed.root->children[0].object;
    struct commit_context context = {&parsed.arena, NULL, object, false};
    const struct texture_maker maker = {make_texture, NULL};
    const struct param *const tables[] = {table};
    status = params_read(&plugin, table, NULL, object, &context, &maker, &error);
    return status ? status : params_check_used(object, tables, 1, &error);
}

static void test_defaults(void **state) {
    (void)state;
    assert_int_equal(read_inside("bsdf", "<integer name=\"required\" value=\"4\"/>"), STATUS_OK);
    assert_true(plugin.flag);
    assert_int_equal(plugin.count, 3);
    assert_int_equal(plugin.choice, 1);
    assert_true(plugin.size == 0.25f && plugin.required == 4);
    assert_string_equal(plugin.text, "bk7");
    assert_null(plugin.optional);
    assert_true(plugin.color.g == 0.2f && plugin.light.b == 2 && plugin.point.z == 3);
    assert_true(plugin.matrix.m[2][2] == 1 && plugin.matrix.inverse[3][3] == 1);
    assert_true(plugin.texture && !plugin.texture->type && plugin.texture->value.r == 0.5f);
    assert_null(plugin.none);
    description_fini(&parsed);
}

static void test_given(void **state) {
    (void)state;
    assert_int_equal(
        read_inside("bsdf",
                    "<boolean name=\"flag\" value=\"false\"/><integer name=\"count\" value=\"10\"/>"
                    "<string name=\"otherChoice\" value=\"B\"/><float name=\"extent\" value=\"90\"/>"
                    "<float name=\"required\" value=\"-1\"/><float name=\"text\" value=\"1.5\"/>"
                    "<rgb name=\"color\" value=\"1 0 0.5\"/><float name=\"light\" value=\"8\"/>"
                    "<vector name=\"point\" y=\"5\"/><transform name=\"matrix\"><scale value=\"3\"/></transform>"
                    "<texture type=\"bitmap\" name=\"texture\"/>"),
        STATUS_OK);
    assert_false(plugin.flag);
    assert_int_equal(plugin.count, 10);
    assert_int_equal(plugin.other_choice, 1);
    assert_true(plugin.size == 90 && plugin.required == -1 && plugin.color.b == 0.5f && plugin.light.g == 8);
    assert_string_equal(plugin.text, "1.5");
    assert_true(plugin.point.x == 0 && plugin.point.y == 5 && plugin.matrix.m[1][1] == 3);
    assert_ptr_equal(plugin.texture, &marker);
    description_fini(&parsed);
}

static void test_spectra_depend_on_the_tag(void **state) { // Mitsuba 3.9.1, scalar_rgb: a constant emitter's 5 is warm
    (void)state;
    const char *text = "<float name=\"required\" value=\"1\"/><spectrum name=\"light\" value=\"5\"/>";
    assert_int_equal(read_inside("emitter", text), STATUS_OK);
    assert_float_equal(plugin.light.r, 6.02397, 1e-4);
    assert_float_equal(plugin.light.b, 4.54458, 1e-4);
    description_fini(&parsed);
    assert_int_equal(read_inside("bsdf", text), STATUS_OK);
    assert_float_equal(plugin.light.r, 5, 0);
    description_fini(&parsed);
    // A measured reflectance whose colour leaves [0,1] is clamped, an rgb that does is an error.
    assert_int_equal(
        read_inside("bsdf", "<float name=\"required\" value=\"1\"/><spectrum name=\"color\" value=\"580:1,780:1\"/>"),
        STATUS_OK);
    assert_true(plugin.color.r == 1 && plugin.color.b == 0);
    description_fini(&parsed);
}

static void test_errors(void **state) {
    (void)state;
    static const struct {
        const char *inside, *message;
    } cases[] = {
        {"", "s.xml:1:8: bsdf 'gadget' needs the parameter 'required': the one that must be there"},
        {"<float name=\"size\" value=\"91\"/>",
         "s.xml:2:1: 'size' is 91 degrees; it must lie between 0 and 90 degrees"},
        {"<integer name=\"count\" value=\"0\"/>", "'count' is 0; it must lie between 1 and 10"},
        {"<float name=\"count\" value=\"2\"/>", "'count' of bsdf 'gadget' must be an <integer>"},
        {"<string name=\"flag\" value=\"true\"/>", "must be a <boolean>"},
        {"<boolean name=\"color\" value=\"true\"/>", "must be an <rgb>, <spectrum> or <float>"},
        {"<rgb name=\"color\" value=\"0 0 1.5\"/>", "'color' is 1.5; it must lie between 0 and 1"},
        {"<float name=\"texture\" value=\"-0.5\"/>", "'texture' is -0.5; it must lie between 0 and 1"},
        {"<string name=\"choice\" value=\"gxg\"/>", "'choice' is 'gxg'; it must be one of beckmann|ggx|phong"},
        {"<float name=\"required\" value=\"1\"/><integer name=\"cuont\" value=\"2\"/>",
         "s.xml:2:35: no parameter 'cuont' in bsdf 'gadget'; did you mean 'count'?"},
        {"<float name=\"required\" value=\"1\"/><texture type=\"t\" name=\"texutre\"/>",
         "no parameter 'texutre' in bsdf 'gadget'; did you mean 'texture'? Or see `sconce help bsdf gadget`"},
        {"<float name=\"texture\" value=\"1\"/><texture type=\"t\" name=\"texture\"/>", "given already"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        assert_int_equal(read_inside("bsdf", cases[i].inside), STATUS_INVALID);
        if (!strstr(error.text, cases[i].message)) fail_msg("wanted '%s', got '%s'", cases[i].message, error.text);
        description_fini(&parsed);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_defaults),
        cmocka_unit_test(test_given),
        cmocka_unit_test(test_spectra_depend_on_the_tag),
        cmocka_unit_test(test_errors),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
