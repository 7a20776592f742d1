// The room's light that a baked lamp stops and scatters, against closed forms. This program has its own luminaire in
// place of a baked one: it emits nothing, and what it lets through and scatters is the same on all lines.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "render_image.h"
#define STAND_IN_SCATTERS
#include "luminaire_stand_in.h"

extern const struct integrator_type path_integrator;

struct luminaire {
    float through, back, onward;
};
static struct luminaire the_luminaire;
static struct luminaire *stand_in(void) { return &the_luminaire; }

void luminaire_flux(const struct luminaire *luminaire, float flux[3]) {
    (void)luminaire;
    flux[0] = flux[1] = flux[2] = 1;
}

void luminaire_eval(const struct luminaire *luminaire, size_t n, const float (*point)[3], const float (*w)[3],
                    float (*radiance)[3]) {
    (void)luminaire, (void)point, (void)w;
    memset(radiance, 0, n * sizeof *radiance);
}

void luminaire_transmittance(const struct luminaire *luminaire, size_t n, const float (*point)[3], const float (*w)[3],
                             float (*transmittance)[3]) {
    for (size_t i = 0; i < n; i++)
        for (int c = 0; c < 3; c++) transmittance[i][c] = line_distance(point[i], w[i]) < 1 ? luminaire->through : 1;
}

void luminaire_scattering(const struct luminaire *luminaire, float back[3], float onward[3]) {
    for (int c = 0; c < 3; c++) {
        back[c] = luminaire->back;
        onward[c] = luminaire->onward;
    }
}

#define CAMERA(fov)                                                                                                    \
    "<integrator type='path'/><sensor type='perspective'><float name='fov' value='" fov "'/><transform "               \
    "name='to_world'><lookat origin='0,-5,0' target='0,0,0' up='0,0,1'/></transform><film type='hdrfilm'><integer "    \
    "name='width' value='16'/><integer name='height' value='16'/><rfilter type='box'/></film></sensor>"
#define LAMP "<shape type='luminaire'><string name='filename' value='any.safetensors'/></shape>"
#define SKY "<emitter type='constant'><rgb name='radiance' value='1'/></emitter>"
// Of radius 2, facing the lamp from `y`.
#define DISK(turn, y)                                                                                                  \
    "<shape type='disk'><transform name='to_world'><scale value='2'/><rotate x='1' angle='" turn "'/><translate y='" y \
    "'/></transform><bsdf type='diffuse'><rgb name='reflectance' value='0'/></bsdf>"                                   \
    "<emitter type='area'><rgb name='radiance' value='4'/></emitter></shape>"

static void check(const char *body, struct luminaire luminaire, double expected) {
    struct rendering r = {0};
    struct error error = {0};
    char xml[3000];
    the_luminaire = luminaire;
    snprintf(xml, sizeof xml, "<scene version='3.0.0'>%s</scene>", body);
    if (render_text(xml, &path_integrator, 256, 1, 3, &r, &error) != STATUS_OK) fail_msg("%s", error.text);
    image_fini(&r.image);
    for (int c = 0; c < 3; c++)
        if (fabs(r.mean[c] - expected) > 4.5 * r.error[c] + 1e-3 * expected || r.error[c] > 0.02 * expected + 1e-3)
            fail_msg("%g +- %g, expected %g", r.mean[c], r.error[c], expected);
}

// What scatters all that it stops is not seen in even light.
static void test_furnace(void **unused) {
    (void)unused;
    check(CAMERA("40") LAMP SKY, (struct luminaire){0.25f, 0.5f, 0.5f}, 1);
    check(CAMERA("40") LAMP SKY, (struct luminaire){0, 0.9f, 0.1f}, 1);
}

static void test_shares(void **unused) {
    (void)unused;
    check(CAMERA("4") LAMP SKY, (struct luminaire){0.25f, 0.3f, 0.2f}, 0.25 + 0.75 * 0.5);
    check(CAMERA("4") LAMP SKY, (struct luminaire){0.25f, 0, 0}, 0.25);
}

// A disk over its axis lights with the form factor r^2 / (r^2 + d^2).
static void test_sides(void **unused) {
    (void)unused;
    const double form = 4.0 / (4 + 9), farther = 4.0 / (4 + 36); // the second one is behind the camera
    check(CAMERA("0.5") LAMP DISK("90", "3"), (struct luminaire){0, 0, 0.8f}, 0.8 * 4 * form);
    check(CAMERA("0.5") LAMP DISK("90", "3"), (struct luminaire){0, 0.8f, 0}, 0);
    check(CAMERA("0.5") LAMP DISK("-90", "-6"), (struct luminaire){0, 0.8f, 0}, 0.8 * 4 * farther);
    check(CAMERA("0.5") LAMP DISK("-90", "-6"), (struct luminaire){0, 0, 0.8f}, 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_furnace), cmocka_unit_test(test_shares),
                                       cmocka_unit_test(test_sides)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
