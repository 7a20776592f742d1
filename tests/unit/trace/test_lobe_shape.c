// How broadly a BSDF scatters: by its roughness, and where textures change that, by its narrowest place.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "../../bsdf_from_xml.h"
#include "trace/lobe_shape.h"

#define PRINCIPLED(metal) "<bsdf type='principled'><float name='roughness' value='0.3'/>" metal "</bsdf>"
// Squares of metal.
#define SPOTS                                                                                                          \
    "<texture type='checkerboard' name='metallic'><float name='color0' value='0'/><float name='color1' value='1'/>"    \
    "<transform name='to_uv'><scale x='3' y='3'/></transform></texture>"

static struct lobe_shape measure(const char *xml) {
    struct xml_plugins plugins = {0};
    struct error error;
    const struct bsdf *bsdf = xml_bsdf(&plugins, xml, &error);
    if (!bsdf) xml_fail(&error);
    const struct lobe_shape shape = lobe_shape_measure(bsdf);
    xml_fini(&plugins);
    return shape;
}

static void test_roughness(void **state) {
    (void)state;
    assert_float_equal(measure("<bsdf type='diffuse'/>").broadness, 1, 0.05);
    const float rough = measure("<bsdf type='roughconductor'><float name='alpha' value='0.5'/></bsdf>").broadness;
    const float smooth = measure("<bsdf type='roughconductor'><float name='alpha' value='0.1'/></bsdf>").broadness;
    assert_true(smooth > 0 && smooth < 0.3f * rough && rough < 1);
    assert_float_equal(measure("<bsdf type='dielectric'/>").smooth, 0, 0);
    const float coated = measure("<bsdf type='plastic'/>").smooth;
    assert_true(coated > 0.5f && coated < 1);
}

static void test_textures(void **state) {
    (void)state;
    const float matt = measure(PRINCIPLED("")).broadness,
                metal = measure(PRINCIPLED("<float name='metallic' value='1'/>")).broadness;
    const float spots = measure(PRINCIPLED(SPOTS)).broadness;
    assert_true(metal < 0.5f * matt);
    assert_float_equal(spots, metal, 1e-6);
    const char *colored = "<bsdf type='diffuse'><texture type='checkerboard' name='reflectance'/></bsdf>";
    assert_float_equal(measure(colored).broadness, 1, 0.05);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_roughness), cmocka_unit_test(test_textures)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
