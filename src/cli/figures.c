// The figures of a baked lamp, as a table or as JSON.
#include <stdio.h>

#include "cli.h"

void json_print(json_t *json) {
    json_dumpf(json, stdout, JSON_REAL_PRECISION(9) | JSON_ENCODE_ANY);
    putchar('\n');
    json_decref(json);
}

static json_t *json_triple(const float v[3]) { return json_pack("[fff]", (double)v[0], (double)v[1], (double)v[2]); }

static void print_json(const struct sconce_figures *f) {
    json_t *irradiance = json_array();
    for (int i = 0; i < f->distance_count; i++)
        json_array_append_new(irradiance, json_pack("{s:f, s:f, s:f, s:f}", "radii", (double)f->distance_radii[i],
                                                    "error", (double)f->irradiance_error[i], "reference_noise",
                                                    (double)f->irradiance_noise[i], "black", 1.0));
    json_t *json = json_pack(
        "{s:o, s:o, s:o, s:o, s:f, s:f, s:f, s:f, s:f, s:f, s:f, s:I, s:f}", "flux", json_triple(f->flux), "flux_error",
        json_triple(f->flux_error), "flux_noise", json_triple(f->flux_noise), "irradiance", irradiance,
        "light_field_error", (double)f->light_field_error, "light_field_error_black",
        (double)f->light_field_error_black, "transparency_error", (double)f->transparency_error,
        "transparency_error_black", (double)f->transparency_error_black, "transparency_noise",
        (double)f->transparency_noise, "sample_variance", (double)f->sample_variance, "sample_variance_uniform",
        (double)f->sample_variance_uniform, "bytes", (json_int_t)f->bytes, "seconds", f->seconds);
    if (f->wall_measured)
        json_object_set_new(json, "wall",
                            json_pack("{s:f, s:f, s:f, s:f}", "relmse", (double)f->wall_relmse, "relmse_noise",
                                      (double)f->wall_relmse_noise, "flip", (double)f->wall_flip, "flip_noise",
                                      (double)f->wall_flip_noise));
    if (f->view_measured)
        json_object_set_new(json, "view",
                            json_pack("{s:i, s:f, s:f, s:f, s:f}", "samples", f->view_samples, "gain_db",
                                      (double)f->view_gain_db, "flip", (double)f->view_flip, "flip_black",
                                      (double)f->view_flip_black, "flip_noise", (double)f->view_flip_noise));
    if (f->surface_measured)
        json_object_set_new(
            json, "surface",
            json_pack("{s:f, s:f}", "gain_db", (double)f->surface_gain_db, "flip", (double)f->surface_flip));
    json_print(json);
}

void figures_print(const struct sconce_figures *f, bool json) {
    if (json) {
        print_json(f);
        return;
    }
    printf("  flux                %-10.4g %-10.4g %-10.4g\n", (double)f->flux[0], (double)f->flux[1],
           (double)f->flux[2]);
    printf("  flux error          %+-10.2f %+-10.2f %+-10.2f %%   (a black lamp: -100 %%)\n",
           100 * (double)f->flux_error[0], 100 * (double)f->flux_error[1], 100 * (double)f->flux_error[2]);
    for (int i = 0; i < f->distance_count; i++)
        printf("  irradiance error    %.2f %% at %g radii (reference noise %.2f %%; black 100 %%)\n",
               100 * (double)f->irradiance_error[i], (double)f->distance_radii[i],
               100 * (double)f->irradiance_noise[i]);
    printf("  light field error   %.4f (black %.4f)\n", (double)f->light_field_error,
           (double)f->light_field_error_black);
    printf("  transparency error  %.4f (opaque %.4f; reference noise %.4f)\n", (double)f->transparency_error,
           (double)f->transparency_error_black, (double)f->transparency_noise);
    if (f->wall_measured)
        printf("  wall at 2 radii     relMSE %.4f less noise of %.4f; FLIP %.3f (noise alone: %.3f)\n",
               (double)f->wall_relmse, (double)f->wall_relmse_noise, (double)f->wall_flip, (double)f->wall_flip_noise);
    if (f->view_measured)
        printf(
            "  direct view         %.1f dB above black; FLIP %.3f (black %.3f; noise alone: %.3f); %d lines a pixel\n",
            (double)f->view_gain_db, (double)f->view_flip, (double)f->view_flip_black, (double)f->view_flip_noise,
            f->view_samples);
    if (f->surface_measured)
        printf("  the same by hull    %.1f dB above black; FLIP %.3f\n", (double)f->surface_gain_db,
               (double)f->surface_flip);
    printf("  one light sample    relative variance %.2f (a uniform one: %.2f)\n", (double)f->sample_variance,
           (double)f->sample_variance_uniform);
    printf("  %.2f MB, %.1f s\n", 1e-6 * (double)f->bytes, f->seconds);
}
