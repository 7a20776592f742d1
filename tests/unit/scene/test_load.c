// Whole scene files: what ends up in the scene, and what the messages say.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <cmocka.h>

#include "luminaire/build.h"
#include "scene/help.h"
#include "scene/scene.h"

static struct scene scene;
static struct error error;
static char messages[8000], folder[] = "/tmp/test_load_XXXXXX";

static void on_message(void *user, enum message_level level, const char *text) {
    (void)user, (void)level;
    strncat(messages, text, sizeof messages - strlen(messages) - 2);
    strcat(messages, "\n");
}

static const char *in_folder(const char *name) {
    static char path[200];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    return path;
}

static void write_file(const char *name, const char *text) {
    FILE *file = fopen(in_folder(name), "w");
    assert_non_null(file);
    fputs(text, file);
    fclose(file);
}

static enum status load_path(const char *path, struct scene_options options) {
    const struct run run = {.threads = 1, .message = on_message};
    messages[0] = error.text[0] = 0;
    options.threads = 1;
    return scene_load(&scene, path, &options, &run, &error);
}

static enum status load_text(const char *inside, struct scene_options options) {
    static char text[4000];
    snprintf(text, sizeof text, "<scene version=\"0.6.0\">\n%s</scene>", inside);
    write_file("s.xml", text);
    return load_path(in_folder("s.xml"), options);
}

static void expect_ok(enum status status) {
    if (status) fail_msg("%s", error.text);
}

static void expect_error(const char *inside, const char *message) {
    assert_int_not_equal(load_text(inside, (struct scene_options){0}), STATUS_OK);
    if (!strstr(error.text, message)) fail_msg("wanted '%s', got '%s'", message, error.text);
}

#define SPHERE "<shape type=\"sphere\"/>"

static void test_settings(void **state) {
    (void)state;
    expect_ok(load_text(
        "<integrator type=\"bdpt\"><integer name=\"maxDepth\" value=\"7\"/><integer name=\"rrDepth\" value=\"3\"/>"
        "<boolean name=\"strictNormals\" value=\"true\"/><boolean name=\"hideEmitters\" value=\"true\"/></integrator>"
        "<sensor type=\"perspective\"><float name=\"fov\" value=\"70\"/><float name=\"nearClip\" value=\"0.5\"/>"
        "<transform name=\"toWorld\"><translate z=\"-5\"/></transform>"
        "<sampler type=\"ldsampler\"><integer name=\"sampleCount\" value=\"12\"/></sampler>"
        "<film type=\"hdrfilm\"><integer name=\"width\" value=\"40\"/><integer name=\"height\" value=\"30\"/>"
        "<integer name=\"cropOffsetX\" value=\"8\"/><integer name=\"cropWidth\" value=\"16\"/>"
        "<string name=\"pixelFormat\" value=\"rgba\"/><boolean name=\"banner\" value=\"false\"/>"
        "<rfilter type=\"gaussian\"><float name=\"stddev\" value=\"0.25\"/></rfilter></film></sensor>" SPHERE,
        (struct scene_options){0}));
    assert_int_equal(scene.integrator, INTEGRATOR_BDPT);
    assert_int_equal(scene.max_depth, 7);
    assert_int_equal(scene.rr_depth, 3);
    assert_true(scene.hide_emitters);
    const struct sensor *s = scene.sensor;
    assert_int_equal(s->width * 1000 + s->height, 40030);
    assert_int_equal(s->crop_x * 1000 + s->crop_width, 8016);
    assert_int_equal(s->crop_y * 1000 + s->crop_height, 30);
    assert_int_equal(s->sample_count, 12);
    assert_true(s->filter == 2 && s->filter_stddev == 0.25f && s->filter_radius == 1);
    assert_true(s->near_clip == 0.5f && s->to_world.m[2][3] == -5);
    assert_string_equal(messages, "");
    scene_fini(&scene);
}

static void test_defaults_and_unknown_integrator(void **state) {
    (void)state;
    expect_ok(load_text("<integrator type=\"photonmapper\"><integer name=\"directSamples\" value=\"128\"/><integer "
                        "name=\"maxDepth\" value=\"9\"/>"
                        "</integrator><sensor type=\"perspective\"><float name=\"fov\" value=\"70\"/></sensor>" SPHERE,
                        (struct scene_options){0}));
    assert_int_equal(scene.integrator, INTEGRATOR_PATH);
    assert_int_equal(scene.max_depth, 9);
    assert_int_equal(scene.rr_depth, 5);
    assert_non_null(strstr(messages, "'photonmapper' is not known"));
    assert_true(scene.sensor->width == 768 && scene.sensor->height == 576 && scene.sensor->filter_radius == 2);
    scene_fini(&scene);
}

static void test_shapes_and_references(void **state) {
    (void)state;
    expect_ok(load_text(
        "<bsdf type=\"twosided\"><bsdf type=\"diffuse\" id=\"white\"/></bsdf><medium type=\"homogeneous\" id=\"tint\">"
        "<rgb name=\"sigmaA\" value=\"1 2 3\"/><float name=\"scale\" value=\"2\"/></medium>"
        "<shape type=\"sphere\" id=\"a\"><ref id=\"white\"/><ref name=\"interior\" id=\"tint\"/></shape>"
        "<shape type=\"rectangle\"><ref id=\"white\"/><emitter type=\"area\"><rgb name=\"radiance\" "
        "value=\"3\"/></emitter></shape>"
        "<shape type=\"sphere\"/><shape type=\"disk\"/><shape type=\"disk\"><emitter type=\"area\"/></shape>",
        (struct scene_options){0}));
    assert_int_equal(scene.shape_count, 5);
    assert_int_equal(scene.emitter_count, 2);
    assert_true(bsdf_albedo(scene.shapes[3]->bsdf, (vec2){0, 0}).g == 0.5f);
    assert_true(bsdf_albedo(scene.shapes[4]->bsdf, (vec2){0, 0}).g == 0); // what shines is black by default
    assert_string_equal(scene.shapes[0]->id, "a");
    assert_string_equal(scene.shapes[0]->bsdf->type->name, "diffuse");
    assert_ptr_equal(scene.shapes[0]->bsdf, scene.shapes[1]->bsdf);
    assert_ptr_equal(scene.shapes[2]->bsdf, scene.shapes[3]->bsdf); // the default
    assert_true(scene.shapes[0]->has_interior && scene.shapes[0]->sigma_a.b == 6);
    assert_ptr_equal(scene.emitters[0]->shape, scene.shapes[1]);
    assert_ptr_equal(scene.shapes[1]->emitter, scene.emitters[0]);
    for (uint32_t i = 0; i < 4; i++) assert_true(scene.shapes[i]->index == i && scene.shapes[i]->luminaire == -1);
    scene_fini(&scene);
}

static void test_lamp_as_geometry(void **state) {
    (void)state;
    write_file(
        "lamp.xml",
        "<scene version=\"3.0.0\"><sensor type=\"perspective\"/><emitter type=\"constant\"/><shape type=\"sphere\">"
        "<transform name=\"to_world\"><translate x=\"1\"/></transform><medium name=\"interior\" type=\"homogeneous\">"
        "<float name=\"sigma_a\" value=\"6\"/></medium><emitter type=\"area\"><rgb name=\"radiance\" "
        "value=\"4\"/></emitter></shape></scene>");
    const struct definition definition = {"lamp", "lamp.xml"};
    expect_ok(load_text("<default name=\"lamp\" value=\"absent.safetensors\"/><shape type=\"luminaire\"><string "
                        "name=\"filename\" value=\"$lamp\"/>"
                        "<rgb name=\"dim\" value=\"0.5 1 1\"/><transform name=\"toWorld\"><scale "
                        "value=\"2\"/><translate y=\"10\"/></transform></shape>",
                        (struct scene_options){.definitions = &definition, .definition_count = 1}));
    assert_int_equal(scene.shape_count, 1);
    assert_int_equal(scene.emitter_count, 1);
    assert_int_equal(scene.luminaire_count, 0);
    vec3 p = transform_point(&scene.shapes[0]->to_world, vec3_make(0, 0, 0));
    assert_true(p.x == 2 && p.y == 10 && p.z == 0);
    assert_float_equal(scene.shapes[0]->sigma_a.r, 3, 1e-6); // twice as large: half as dense
    assert_float_equal(scene.emitters[0]->power.r / scene.emitters[0]->power.g, 0.5, 1e-5);
    assert_null(scene.sensor);
    assert_non_null(strstr(messages, "left aside"));
    scene_fini(&scene);
}

// The smallest baked lamp: what its light field holds does not matter here.
static void write_baked(const char *name, const char *source) {
    static struct line_sample samples[256];
    static struct line_exit exits[256];
    const struct proxy proxy = {.kind = PROXY_SPHERE, .radius = 1.5f};
    const struct light_field_options options = {
        .proxy = proxy, .anchor_radius = 0.1f, .radiance_unit = 1, .use_grid4 = true, .log2_entries = 14, .steps = 1};
    for (int i = 0; i < 256; i++) {
        float angle = 0.1f * (float)i;
        samples[i] = (struct line_sample){{cosf(angle), sinf(angle), 0}, {cosf(angle), sinf(angle), 0}, 1, {1, 1, 1}};
        exits[i] =
            (struct line_exit){{1.5f * cosf(angle), 1.5f * sinf(angle), 0}, {cosf(angle), sinf(angle), 0}, {1, 1, 1}};
    }
    struct light_field *field;
    struct sampling_density *density;
    struct luminaire *luminaire;
    expect_ok(light_field_create(&field, &options, &error));
    light_field_train(field, samples, 256, 1, NULL);
    expect_ok(sampling_density_build(&density, &proxy, NULL, 0, exits, 256, 1, 1, &error));
    const char *const key = "bake.source";
    expect_ok(luminaire_assemble(&luminaire, &proxy, field, NULL, density, (const float[3]){1, 1, 1}, &key, &source, 1,
                                 &error));
    expect_ok(luminaire_save(luminaire, in_folder(name), &error));
    luminaire_destroy(luminaire);
}

static void test_baked_lamp(void **state) {
    (void)state;
    write_baked("lamp.safetensors", "lamp.xml");
    write_file(
        "lamp.xml",
        "<scene version=\"3.0.0\"><shape type=\"sphere\"><bsdf type=\"dielectric\"/></shape><shape type=\"disk\"/>"
        "<shape type=\"rectangle\"><emitter type=\"area\"/></shape></scene>");
    static const struct {
        const char *parameters;
        size_t shapes, emitters;
        enum keep_geometry keep;
        enum appearance appearance;
    } cases[] = {
        {"", 0, 0, KEEP_NONE, APPEARANCE_NEURAL},
        {"<string name=\"keep\" value=\"opaque\"/>", 1, 0, KEEP_OPAQUE, APPEARANCE_NEURAL},
        {"<string name=\"keep\" value=\"all\"/>", 3, 1, KEEP_ALL, APPEARANCE_NEURAL},
        {"<string name=\"appearance\" value=\"geometry\"/>", 3, 1, KEEP_NONE, APPEARANCE_GEOMETRY},
        {"<string name=\"keep\" value=\"opaque\"/><string name=\"geometry\" value=\"lamp.xml\"/>", 1, 0, KEEP_OPAQUE,
         APPEARANCE_NEURAL},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char text[1000];
        snprintf(text, sizeof text,
                 "<shape type=\"luminaire\"><string name=\"filename\" value=\"lamp.safetensors\"/></shape>"
                 "<shape type=\"luminaire\"><string name=\"filename\" value=\"lamp.safetensors\"/>%s<transform "
                 "name=\"toWorld\">"
                 "<scale value=\"2\"/><rotate y=\"1\" angle=\"90\"/><translate x=\"9\"/></transform></shape>",
                 cases[i].parameters);
        expect_ok(load_text(text, (struct scene_options){0}));
        assert_int_equal(scene.luminaire_count, 2);
        assert_ptr_equal(scene.luminaires[0].luminaire, scene.luminaires[1].luminaire);
        const struct luminaire_instance *instance = &scene.luminaires[1];
        assert_float_equal(instance->scale, 2, 1e-5);
        assert_int_equal(instance->keep, cases[i].keep);
        assert_int_equal(instance->appearance, cases[i].appearance);
        assert_int_equal(scene.shape_count, cases[i].shapes);
        assert_int_equal(scene.emitter_count, cases[i].emitters);
        for (size_t k = 0; k < scene.shape_count; k++) {
            assert_int_equal(scene.shapes[k]->luminaire, 1);
            assert_true(scene.shapes[k]->to_world.m[0][3] == 9);
        }
        scene_fini(&scene);
    }
    unlink(in_folder("lamp.xml"));
    assert_int_equal(load_text("<shape type=\"luminaire\"><string name=\"filename\" "
                               "value=\"lamp.safetensors\"/><string name=\"keep\" value=\"all\"/></shape>",
                               (struct scene_options){0}),
                     STATUS_IO);
    unlink(in_folder("lamp.safetensors"));
}

static void test_lamp_only(void **state) {
    (void)state;
    expect_ok(load_text(
        "<sensor type=\"perspective\"/><emitter type=\"envmap\"><string name=\"filename\" "
        "value=\"absent.exr\"/></emitter>"
        "<shape type=\"sphere\"><emitter type=\"area\"><rgb name=\"radiance\" value=\"1\"/></emitter></shape>",
        (struct scene_options){.lamp_only = true}));
    assert_null(scene.sensor);
    assert_null(scene.environment);
    assert_int_equal(scene.emitter_count, 1);
    scene_fini(&scene);
}

static void test_missing_files(void **state) {
    (void)state;
    const char *text = "<shape type=\"obj\"><string name=\"filename\" value=\"absent.obj\"/></shape>" SPHERE;
    assert_int_equal(load_text(text, (struct scene_options){0}), STATUS_IO);
    assert_non_null(strstr(error.text, "s.xml:2:1: "));
    assert_non_null(strstr(error.text, "absent.obj"));
    expect_ok(load_text(text, (struct scene_options){.skip_missing = true}));
    assert_non_null(strstr(messages, "absent.obj"));
    assert_int_equal(scene.shape_count, 1);
    scene_fini(&scene);
    assert_int_equal(
        load_text("<shape type=\"luminaire\"><string name=\"filename\" value=\"absent.safetensors\"/></shape>",
                  (struct scene_options){0}),
        STATUS_IO);
    assert_int_equal(load_path("/nowhere/s.xml", (struct scene_options){0}), STATUS_IO);
}

static void test_errors(void **state) {
    (void)state;
    static const struct {
        const char *inside, *message;
    } cases[] = {
        {"<shape type=\"sphere\"><float name=\"raduis\" value=\"2\"/></shape>",
         "s.xml:2:22: no parameter 'raduis' in shape 'sphere'; did you mean 'radius'? Or see `sconce help shape "
         "sphere`"},
        {"<shape type=\"shpere\"/>", "unknown shape 'shpere'; did you mean 'sphere'?"},
        {"<bsdf type=\"difuse\"/>", "unknown bsdf 'difuse'; did you mean 'diffuse'?"},
        {"<shape type=\"sphere\"><bsdf type=\"diffuse\"/><bsdf type=\"diffuse\"/></shape>",
         "a second <bsdf> in one shape"},
        {"<shape type=\"sphere\"><sampler type=\"independent\"/></shape>",
         "a <sampler> has no meaning in shape 'sphere'"},
        {"<bsdf type=\"twosided\"/>", "needs 1 nested bsdf"},
        {"<bsdf type=\"diffuse\"><bsdf type=\"diffuse\"/></bsdf>", "takes no nested bsdfs"},
        {"<emitter type=\"area\"/>", "must stand inside a shape"},
        {"<emitter type=\"constant\"/><emitter type=\"constant\"/>" SPHERE, "has an environment already"},
        {"<shape type=\"sphere\"><medium name=\"interior\" type=\"homogeneous\"><rgb name=\"sigmaA\" value=\"1\"/><rgb "
         "name=\"sigmaS\" value=\"1\"/></medium></shape>",
         "the medium scatters"},
        {"<shape type=\"sphere\"><medium name=\"interior\" type=\"heterogeneous\"/></shape>", "is not supported"},
        {"<shape type=\"luminaire\"><string name=\"filename\" value=\"s.xml\"/></shape>", "does '/tmp/test_load_"},
        {"<shape type=\"luminaire\"><string name=\"filename\" value=\"s.obj\"/></shape>",
         "neither a lamp's scene (.xml) nor a baked lamp"},
        {"<shape type=\"luminaire\"><string name=\"filename\" value=\"l.safetensors\"/><transform "
         "name=\"toWorld\"><scale x=\"2\"/></transform></shape>",
         "may only rotate"},
        {"<sensor type=\"perspective\"><film type=\"hdrfilm\"><integer name=\"cropOffsetX\" "
         "value=\"768\"/></film></sensor>",
         "does not lie within the image"},
        {"<sensor type=\"perspective\"><film type=\"hdrfilm\"><integer name=\"widht\" value=\"768\"/></film></sensor>",
         "no parameter 'widht' in film 'hdrfilm'; did you mean 'width'?"},
        {"<subsurface type=\"dipole\"/>", "<subsurface> is not supported"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) expect_error(cases[i].inside, cases[i].message);
}

static void test_help(void **state) {
    (void)state;
    struct arena arena = {0};
    const char *all = help_text(&arena, NULL, NULL), *page = help_text(&arena, "bsdf", "diffuse"),
               *wrong = help_text(&arena, "bsdf", "difuse");
    assert_non_null(strstr(all, "luminaire"));
    assert_non_null(strstr(all, "perspective"));
    assert_non_null(strstr(page, "reflectance"));
    assert_non_null(strstr(help_text(&arena, "shape", "sphere"), "to_world"));
    assert_non_null(strstr(help_text(&arena, "bsdf", "twosided"), "nested bsdfs: 1 to 2"));
    assert_non_null(strstr(wrong, "did you mean 'diffuse'?"));
    assert_true(help_knows("bsdf", "diffuse") && help_knows("shape", NULL) && help_knows(NULL, NULL));
    assert_false(help_knows("bsdf", "difuse") || help_knows("bsfd", NULL));
    arena_fini(&arena);
}

static void test_published_scenes(void **state) {
    (void)state;
    static const char *const names[] = {"cbox_flower_lum.xml", "diffuse_cbox_flower_lum.xml", "flower_lum_only.xml"};
    static const size_t shapes[] = {10, 11, 5};
    for (int i = 0; i < 3; i++) {
        char path[400];
        snprintf(path, sizeof path, SOURCE_DIR "/../shared/scenes/zhu2021/flower/%s", names[i]);
        if (access(path, R_OK)) {
            print_message("skipped: %s is not here\n", path);
            skip();
        }
        expect_ok(load_path(path, (struct scene_options){.lamp_only = i == 2, .skip_missing = true}));
        assert_int_equal(scene.shape_count, shapes[i]);
        assert_int_equal(scene.emitter_count, 1);
        scene_fini(&scene);
    }
}

static int make_folder(void **state) {
    (void)state;
    return mkdtemp(folder) ? 0 : 1;
}

static int remove_folder(void **state) {
    (void)state;
    unlink(in_folder("s.xml"));
    unlink(in_folder("lamp.xml"));
    return rmdir(folder);
}

static void instances_place_groups(void **state) {
    (void)state;
    static const char group[] = "<shape type='shapegroup' id='g'><shape type='sphere' id='a'><float name='radius' "
                                "value='0.5'/></shape><shape type='cube'/></shape>";
    char text[2000];
    snprintf(text, sizeof text,
             "%s<shape type='instance'><ref id='g'/><transform name='toWorld'><scale value='2'/><translate x='10'/>"
             "</transform></shape><shape type='instance'><ref id='g'/></shape><shape type='merge'><shape "
             "type='sphere'/></shape>",
             group);
    expect_ok(load_text(text, (struct scene_options){0}));
    assert_int_equal(scene.shape_count, 5);
    struct surface surface;
    const struct ray ray = {{10, 0, 5}, {0, 0, -1}, 0, INFINITY};
    assert_true(scene_intersect(&scene, &ray, -1, &surface));
    assert_float_equal(surface.t, 3, 1e-4f); // the cube of side 4
    scene_fini(&scene);
    expect_ok(load_text(group, (struct scene_options){0})); // by itself it is nowhere
    assert_int_equal(scene.shape_count, 0);
    scene_fini(&scene);
    expect_error("<shape type='instance'/>", "s.xml:2:1: an instance holds one shapegroup");
    expect_error("<shape type='instance'><shape type='sphere'/></shape>", "an instance holds one shapegroup");
    snprintf(text, sizeof text,
             "%s<shape type='instance'><shape type='shapegroup'><shape type='instance'><ref id='g'/></shape></shape>"
             "</shape>",
             group);
    expect_error(text, "cannot stand within a shapegroup");
    write_file("lamp.xml", "<scene version='0.6.0'><shape type='shapegroup' id='s'><shape type='sphere'/></shape>"
                           "<shape type='instance'><ref id='s'/></shape></scene>");
    expect_ok(load_text("<shape type='instance'><shape type='shapegroup'><shape type='luminaire'><string "
                        "name='filename' value='lamp.xml'/></shape></shape></shape>",
                        (struct scene_options){0}));
    assert_int_equal(scene.shape_count, 1);
    scene_fini(&scene);
    expect_error("<shape type='merge'><float name='radius' value='1'/></shape>", "radius");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(instances_place_groups),
        cmocka_unit_test(test_settings),
        cmocka_unit_test(test_defaults_and_unknown_integrator),
        cmocka_unit_test(test_baked_lamp),
        cmocka_unit_test(test_lamp_only),
        cmocka_unit_test(test_shapes_and_references),
        cmocka_unit_test(test_missing_files),
        cmocka_unit_test(test_lamp_as_geometry),
        cmocka_unit_test(test_errors),
        cmocka_unit_test(test_help),
        cmocka_unit_test(test_published_scenes),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
