// sconce compare: an image against its reference.
#include <math.h>
#include <stdio.h>

#include "cli.h"

struct compare_input {
    struct common common;
    const char *image, *reference, *mask;
};

static const struct argp_option OPTIONS[] = {
    {"mask", 'm', "FILE", 0, "compare only pixels where this image is > 0.5", 1}, {0}};

static error_t parse(int key, char *argument, struct argp_state *state) {
    struct compare_input *input = state->input;
    switch (key) {
    case ARGP_KEY_INIT:
        state->child_inputs[0] = &input->common;
        return 0;
    case 'm':
        input->mask = argument;
        return 0;
    case ARGP_KEY_ARG:
        if (!input->image)
            input->image = argument;
        else
            input->reference =
                option_last_positional(state, argument, (char *)(uintptr_t)input->reference, "reference");
        return 0;
    case ARGP_KEY_END:
        if (!input->reference) argp_error(state, "two images are needed: the picture and its reference");
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

static int run(int argc, char **argv) {
    static const struct argp argp = {
        OPTIONS, parse, "IMAGE.exr REFERENCE.exr", "How far an image is from its reference.", common_children, 0, 0};
    struct compare_input input = {0};
    common_init(&input.common);
    if (argp_parse(&argp, argc, argv, 0, 0, &input)) return EXIT_USAGE;
    struct sconce_comparison c;
    struct sconce_error error;
    if (sconce_compare(input.image, input.reference, input.mask, &c, &error)) return common_fail(&input.common, &error);
    if (input.common.json) {
        json_t *json =
            json_pack("{s:f, s:f, s:f, s:[fff], s:f, s:f, s:I}", "mse", c.mse, "rel_mse", c.rel_mse, "flip", c.flip,
                      "mean_ratio", c.mean_ratio[0], c.mean_ratio[1], c.mean_ratio[2], "block_error_max",
                      c.block_error_max, "block_error_mean", c.block_error_mean, "pixels", (json_int_t)c.pixel_count);
        // Figures that do not exist (equal images have no PSNR) have no key.
        if (!isnan(c.rel_mse_corrected)) json_object_set_new(json, "rel_mse_corrected", json_real(c.rel_mse_corrected));
        if (isfinite(c.psnr_db)) json_object_set_new(json, "psnr_db", json_real(c.psnr_db));
        if (isfinite(c.psnr_log_db)) json_object_set_new(json, "psnr_log_db", json_real(c.psnr_log_db));
        json_print(json);
    } else {
        printf("relMSE           %.6f   mean of (a - r)^2 / (r^2 + 0.001)\n", c.rel_mse);
        if (!isnan(c.rel_mse_corrected)) printf("  less the reference's noise %.6f\n", c.rel_mse_corrected);
        printf("MSE              %.6g\nPSNR             %.2f dB (of log(1 + x): %.2f dB)\nFLIP             %.4f\n",
               c.mse, c.psnr_db, c.psnr_log_db, c.flip);
        printf("ratio of means   %.4f %.4f %.4f\n", c.mean_ratio[0], c.mean_ratio[1], c.mean_ratio[2]);
        printf("16 blocks' means off by %.2f %% on average, %.2f %% at most\npixels           %zu\n",
               100 * c.block_error_mean, 100 * c.block_error_max, c.pixel_count);
    }
    common_fini(&input.common);
    return EXIT_FINE;
}

const struct command command_compare = {"compare", "A.exr REFERENCE.exr [--mask M]",
                                        "measures a picture against its reference", run};
