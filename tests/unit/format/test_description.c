// The scene reader on small texts with known trees, and on wrong ones with known messages.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <cmocka.h>

#include "format/description.h"

static struct description parsed;
static struct error error;
static char messages[2000];

static void on_message(void *user, enum message_level level, const char *text) {
    (void)user, (void)level;
    strncat(messages, text, sizeof messages - strlen(messages) - 1);
}

static enum status parse_with(const char *text, const struct definition *definitions, size_t n) {
    const struct run run = {.threads = 1, .message = on_message};
    messages[0] = error.text[0] = 0;
    return description_parse(&parsed, "dir/s.xml", text, strlen(text), definitions, n, &run, &error);
}

static void expect_error(const char *text, const char *message) {
    assert_int_not_equal(parse_with(text, NULL, 0), STATUS_OK);
    if (!strstr(error.text, message)) fail_msg("wanted '%s', got '%s'", message, error.text);
}

static struct object *child(const struct object *object, size_t i) {
    assert_true(i < object->child_count);
    return object->children[i].object;
}

static void test_both_spellings_give_the_same(void **state) {
    (void)state;
    const char *const texts[] = {
        "<scene version=\"0.5.0\"><shape type=\"obj\">\n <float name=\"maxSmoothAngle\" value=\" 3.5e1 \"/>"
        "<transform name=\"toWorld\"><lookAt origin=\"1,2,3\" target=\"1 2 4\" up=\"0 1 "
        "0\"/></transform></shape></scene>",
        "<scene version=\"3.0.0\"><shape type=\"obj\">\n <float name=\"max_smooth_angle\" value=\"35\"/>"
        "<transform name=\"to_world\"><look_at origin=\"1,2,3\" target=\"1 2 4\"/></transform></shape></scene>"};
    for (int i = 0; i < 2; i++) {
        assert_int_equal(parse_with(texts[i], NULL, 0), STATUS_OK);
        const struct object *shape = child(parsed.root, 0);
        assert_string_equal(shape->tag, "shape");
        assert_int_equal(shape->place.line, 1);
        assert_int_equal(shape->place.column, 24);
        const struct property *angle = object_property(shape, "max_smooth_angle");
        assert_non_null(angle);
        assert_int_equal(angle->place.line, 2);
        assert_int_equal(angle->place.column, 2);
        assert_true(angle->number == 35);
        const struct property *to_world = object_property(shape, "to_world");
        vec3 p = transform_point(&to_world->transform, vec3_make(0, 0, 5));
        assert_float_equal(p.x, 1, 1e-6);
        assert_float_equal(p.y, 2, 1e-6);
        assert_float_equal(p.z, 8, 1e-6);
        description_fini(&parsed);
    }
}

static void test_transforms_apply_in_order(void **state) {
    (void)state;
    assert_int_equal(
        parse_with("<scene><shape type=\"s\"><transform name=\"t\"><scale value=\"2\"/><translate x=\"1\"/>"
                   "<rotate z=\"1\" angle=\"90\"/><matrix value=\"1 0 0 0  0 1 0 0  0 0 1 7  0 0 0 1\"/>"
                   "</transform></shape></scene>",
                   NULL, 0),
        STATUS_OK);
    vec3 p = transform_point(&object_property(child(parsed.root, 0), "t")->transform, vec3_make(1, 0, 0));
    assert_float_equal(p.x, 0, 1e-6); // (1,0,0) -> (2,0,0) -> (3,0,0) -> (0,3,0) -> (0,3,7)
    assert_float_equal(p.y, 3, 1e-6);
    assert_float_equal(p.z, 7, 1e-6);
    description_fini(&parsed);
}

static void test_names_and_defaults(void **state) {
    (void)state;
    const char *text = "<scene><default name=\"lamp\" value=\"a.xml\"/><default name=\"n\" value=\"4\"/>"
                       "<shape type=\"s\"><string name=\"f\" value=\"$lamp/$n.obj\"/></shape></scene>";
    assert_int_equal(parse_with(text, NULL, 0), STATUS_OK);
    assert_string_equal(object_property(child(parsed.root, 0), "f")->string, "a.xml/4.obj");
    description_fini(&parsed);
    const struct definition given[] = {{"lamp", "b"}, {"spare", "1"}};
    assert_int_equal(parse_with(text, given, 2), STATUS_OK);
    assert_string_equal(object_property(child(parsed.root, 0), "f")->string, "b/4.obj");
    assert_true(parsed.definition_used[0]);
    assert_false(parsed.definition_used[1]);
    description_fini(&parsed);
    expect_error("<scene>\n<default name=\"lamp\" value=\"\"/>\n  <shape type=\"$lmap\"/></scene>",
                 "dir/s.xml:3:3: $lmap has no value; did you mean $lamp?");
}

static void test_references(void **state) {
    (void)state;
    assert_int_equal(parse_with("<scene><shape type=\"a\"><ref name=\"slot\" id=\"v\"/></shape><bsdf type=\"twosided\">"
                                "<bsdf type=\"diffuse\" id=\"white\"/></bsdf><alias id=\"white\" as=\"v\"/></scene>",
                                NULL, 0),
                     STATUS_OK);
    const struct object *shape = child(parsed.root, 0);
    assert_ptr_equal(child(shape, 0), child(child(parsed.root, 1), 0));
    assert_string_equal(shape->children[0].name, "slot");
    assert_null(child(shape, 0)->instance);
    description_fini(&parsed);
    expect_error("<scene><shape type=\"a\"><ref id=\"wihte\"/></shape><bsdf type=\"b\" id=\"white\"/></scene>",
                 "s.xml:1:24: nothing has the id 'wihte'; did you mean 'white'?");
    expect_error("<scene><bsdf type=\"a\" id=\"x\"><ref id=\"y\"/></bsdf><bsdf type=\"b\" id=\"y\"><ref "
                 "id=\"x\"/></bsdf></scene>",
                 "inside that object itself");
    expect_error("<scene><bsdf type=\"a\" id=\"x\"/>\n<bsdf type=\"b\" id=\"x\"/></scene>",
                 "s.xml:2:1: the id 'x' is taken at dir/s.xml:1:8");
    expect_error(
        "<scene><alias id=\"x\" as=\"y\"/><alias id=\"y\" as=\"x\"/><shape type=\"a\"><ref id=\"x\"/></shape></scene>",
        "leads back to itself");
}

static void test_deep_references_are_refused(void **state) { // no recursion as deep as the file likes
    (void)state;
    static char text[300000];
    size_t n = (size_t)sprintf(text, "<scene>");
    for (int i = 5000; i > 0; i--)
        n += (size_t)sprintf(text + n, "<bsdf type=\"a\" id=\"b%d\"><ref id=\"b%d\"/></bsdf>", i, i - 1);
    sprintf(text + n, "<bsdf type=\"a\" id=\"b0\"/></scene>");
    expect_error(text, "more than 64 deep");
}

static void test_colours(void **state) {
    (void)state;
    assert_int_equal(
        parse_with("<scene><bsdf type=\"b\"><rgb name=\"a\" value=\"0.1, 0.2, 0.3\"/><rgb name=\"b\" value=\"0.5\"/>"
                   "<srgb name=\"c\" value=\"#ff8000\"/><spectrum name=\"d\" value=\"0.25\"/>"
                   "<spectrum name=\"e\" value=\"400 : 0.5, 700:0.5\"/></bsdf></scene>",
                   NULL, 0),
        STATUS_OK);
    const struct object *b = child(parsed.root, 0);
    assert_float_equal(object_property(b, "a")->color.g, 0.2, 1e-7);
    assert_float_equal(object_property(b, "b")->color.b, 0.5, 1e-7);
    assert_float_equal(object_property(b, "c")->color.r, 1, 1e-6);
    assert_float_equal(object_property(b, "c")->color.g, 0.2158605, 1e-6); // IEC 61966-2-1 of 128/255
    assert_float_equal(object_property(b, "d")->color.r, 0.25, 1e-7);
    assert_int_equal(object_property(b, "e")->pair_count, 2);
    assert_float_equal(object_property(b, "e")->color.r, 0.5, 0.005);
    description_fini(&parsed);
}

static void test_typed_spectra(void **state) {
    (void)state;
    const char *text = "<scene><shape type=\"s\">"
                       "<spectrum name=\"a\" type=\"d65\"><float name=\"scale\" value=\"6\"/></spectrum>"
                       "<spectrum name=\"b\" type=\"uniform\"><float name=\"value\" value=\"0.7\"/></spectrum>"
                       "<spectrum name=\"c\" type=\"irregular\"><string name=\"wavelengths\" value=\"400, 700\"/>"
                       "<string name=\"values\" value=\"1, 2\"/></spectrum>"
                       "<rgb name=\"d\" type=\"srgb\"><rgb name=\"color\" value=\"1 2 3\"/></rgb>"
                       "<spectrum name=\"e\" value=\"1, 2, 3\"/><blackbody name=\"f\" temperature=\"3000K\"/>"
                       "<spectrum name=\"g\" type=\"blackbody\"><float name=\"temperature\" value=\"3000\"/></spectrum>"
                       "<transform name=\"h\" id=\"place\"/></shape></scene>";
    assert_int_equal(parse_with(text, NULL, 0), STATUS_OK);
    const struct object *s = child(parsed.root, 0);
    assert_true(object_property(s, "a")->type == PROPERTY_RGB && object_property(s, "a")->color.g == 6);
    assert_true(object_property(s, "b")->color.b == 0.7f);
    const struct property *pairs = object_property(s, "c");
    assert_true(pairs->pair_count == 2 && pairs->wavelengths_nm[1] == 700 && pairs->values[1] == 2);
    assert_true(object_property(s, "d")->color.b == 3 && object_property(s, "e")->color.b == 3);
    assert_true(object_property(s, "f")->color.r == object_property(s, "g")->color.r);
    description_fini(&parsed);
    expect_error("<scene><shape type=\"s\"><spectrum name=\"a\" type=\"d56\"/></shape></scene>", "did you mean 'd65'?");
    expect_error(
        "<scene><shape type=\"s\"><spectrum name=\"a\" type=\"d65\"><shape type=\"s\"/></spectrum></shape></scene>",
        "no meaning inside a <spectrum>");
    expect_error("<scene><shape type=\"s\"><spectrum name=\"a\" type=\"irregular\"><string name=\"values\" "
                 "value=\"1 2\"/></spectrum></shape></scene>",
                 "needs the parameter 'wavelengths'");
}

static void test_errors_say_where_and_what(void **state) {
    (void)state;
    expect_error("<scene>\n <shpae type=\"a\"/></scene>",
                 "dir/s.xml:2:2: unknown element <shpae>; did you mean <shape>?");
    expect_error("<scene><shape/></scene>", "<shape> needs the attribute type");
    expect_error("<shape type=\"a\"/>", "outermost element must be <scene>");
    expect_error("<scene><shape type=\"a\"></scene>", "s.xml:1:26: malformed XML: mismatched tag");
    expect_error("", "malformed XML");
    expect_error("<scene><float name=\"a\" value=\"nan\"/></scene>", "not a finite number");
    expect_error("<scene><float name=\"a\" value=\"0x10\"/></scene>", "not a finite number");
    expect_error("<scene><float name=\"a\" value=\"1e39\"/></scene>", "not a finite number");
    expect_error("<scene><float name=\"a\" value=\"1.5 m\"/></scene>", "not a finite number");
    expect_error("<scene><integer name=\"a\" value=\"1.5\"/></scene>", "not a whole number");
    expect_error("<scene><integer name=\"a\" value=\"3000000000\"/></scene>", "not a whole number");
    expect_error("<scene><boolean name=\"a\" value=\"yes\"/></scene>", "write true or false");
    expect_error("<scene><rgb name=\"a\" value=\"1 2\"/></scene>", "has 2 numbers");
    expect_error("<scene><rgb name=\"a\" value=\"1 2 inf\"/></scene>", "not a list of finite numbers");
    expect_error("<scene><float name=\"a\" vaule=\"1\"/></scene>", "no attribute 'vaule'; did you mean 'value'?");
    expect_error("<scene><float name=\"a\"/></scene>", "needs the attribute value");
    expect_error("<scene><float name=\"maxDepth\" value=\"1\"/><integer name=\"max_depth\" value=\"1\"/></scene>",
                 "given already");
    expect_error("<scene><spectrum name=\"a\" value=\"500:1, 400:2\"/></scene>", "must ascend");
    expect_error("<scene><spectrum name=\"a\" value=\"500:1, 600\"/></scene>", "pair 2");
    expect_error("<scene><shape type=\"a\"><transform name=\"t\"><scale x=\"0\"/></transform></shape></scene>",
                 "must not be 0");
    expect_error("<scene><shape type=\"a\"><transform name=\"t\"><matrix value=\"1 2 3\"/></transform></shape></scene>",
                 "has 3 numbers");
    expect_error("<scene>loose</scene>", "text 'loose'");
    expect_error("<scene><include filename=\"absent.xml\"/></scene>", "'dir/absent.xml' cannot be read");
}

static void write_file(const char *path, const char *text) {
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    fputs(text, file);
    fclose(file);
}

static void test_includes(void **state) {
    (void)state;
    char folder[] = "/tmp/test_description_XXXXXX", path[3][100];
    assert_non_null(mkdtemp(folder));
    const char *const names[] = {"a.xml", "b.xml", "c.spd"};
    for (int i = 0; i < 3; i++) snprintf(path[i], sizeof path[i], "%s/%s", folder, names[i]);
    write_file(path[0], "<scene><default name=\"k\" value=\"3\"/><include filename=\"b.xml\"/><shape type=\"s\"><ref "
                        "id=\"m\"/></shape></scene>");
    write_file(path[1], "<scene>\n<bsdf type=\"d\" id=\"m\"><integer name=\"n\" value=\"$k\"/><spectrum name=\"r\" "
                        "filename=\"c.spd\"/></bsdf></scene>");
    write_file(path[2], "# two points\n400 0.5\n700 0.5 # end\n");
    assert_int_equal(description_load(&parsed, path[0], NULL, 0, NULL, &error), STATUS_OK);
    const struct object *bsdf = child(parsed.root, 0);
    assert_string_equal(bsdf->place.file, path[1]);
    assert_int_equal(bsdf->place.line, 2);
    assert_true(object_property(bsdf, "n")->number == 3);
    assert_int_equal(object_property(bsdf, "r")->pair_count, 2);
    assert_ptr_equal(child(child(parsed.root, 1), 0), bsdf);
    description_fini(&parsed);
    write_file(path[1], "<scene>\n<include filename=\"a.xml\"/></scene>");
    assert_int_equal(description_load(&parsed, path[0], NULL, 0, NULL, &error), STATUS_INVALID);
    assert_non_null(strstr(error.text, "b.xml:2:1: "));
    assert_non_null(strstr(error.text, "includes itself"));
    for (int i = 0; i < 3; i++) unlink(path[i]);
    rmdir(folder);
}

static void test_nearest_name(void **state) {
    (void)state;
    const char *const names[] = {"radius", "center", "to_world"};
    assert_string_equal(nearest_name("raduis", names, 3), "radius");
    assert_string_equal(nearest_name("ToWrld", names, 3), "to_world");
    assert_null(nearest_name("filename", names, 3));
    assert_null(nearest_name("x", names, 3));
}

static void test_published_scene(void **state) {
    (void)state;
    const char *path = SOURCE_DIR "/../shared/scenes/zhu2021/flower/cbox_flower_lum.xml";
    if (access(path, R_OK)) {
        print_message("skipped: %s is not here\n", path);
        skip();
    }
    assert_int_equal(description_load(&parsed, path, NULL, 0, NULL, &error), STATUS_OK);
    size_t shapes = 0;
    for (size_t i = 0; i < parsed.root->child_count; i++) shapes += !strcmp(child(parsed.root, i)->tag, "shape");
    assert_int_equal(shapes, 10);
    description_fini(&parsed);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_both_spellings_give_the_same),
        cmocka_unit_test(test_transforms_apply_in_order),
        cmocka_unit_test(test_names_and_defaults),
        cmocka_unit_test(test_references),
        cmocka_unit_test(test_deep_references_are_refused),
        cmocka_unit_test(test_colours),
        cmocka_unit_test(test_typed_spectra),
        cmocka_unit_test(test_errors_say_where_and_what),
        cmocka_unit_test(test_includes),
        cmocka_unit_test(test_nearest_name),
        cmocka_unit_test(test_published_scene),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
