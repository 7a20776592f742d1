// Figure 8: what becomes of the light behind the lamp: stopped, let through or not, dimmed by colour, and with the
// lamp's opaque parts kept as geometry.
#include <stdio.h>

#include "evidence/figure_table.h"
#include "evidence/kept_render.h"
#include "report/compare.h"
#include "report/picture.h"

enum { WIDTH = 1280, HEIGHT = 960 }; // of the whole picture at scale 1
static const struct room_crop lamp_crop = {0.33f, 0.04f, 0.42f};
static const double reference_s = 120, way_s = 30; // CPU seconds at scale 1

static const struct sheet_column COLUMNS[] = {{"cpu_s", "CPU seconds", 1},
                                              {"samples", "samples per pixel", 0},
                                              {"rel_mse", "relMSE at the lamp", 4},
                                              {"flip", "FLIP at the lamp", 3},
                                              {0}};

static const struct {
    const char *name, *file, *keep;
    enum lamp_mask mask;
} WAYS[] = {{"no transparency", "mask_none", "none", LAMP_MASK_NONE},
            {"binary", "mask_binary", "none", LAMP_MASK_BINARY},
            {"RGB", "mask_rgb", "none", LAMP_MASK_RGB},
            {"RGB, opaque parts kept", "mask_kept", "opaque", LAMP_MASK_RGB}};
enum { WAY_COUNT = sizeof WAYS / sizeof WAYS[0] };

static enum status render_lamp(struct figure_kit *kit, struct render_request request, struct kept_render *render,
                               struct error *error) {
    char scene[PATH_MAX];
    evidence_room(scene, &kit->data, "living_room");
    request.room = scene;
    request.furnished = true;
    request.crop = lamp_crop;
    request.width = figure_side(kit, WIDTH);
    request.height = figure_side(kit, HEIGHT);
    request.cpu_seconds *= kit->scale;
    return kept_render(kit, &request, render, error);
}

static enum status render_all(struct figure_kit *kit, struct kept_render *reference, struct kept_render *renders,
                              struct error *error) {
    char lamp[PATH_MAX], baked[PATH_MAX];
    evidence_lamp(lamp, &kit->data, "vintage_lamp");
    enum status status = evidence_baked_check(baked, &kit->data, "vintage_lamp", error);
    const struct render_request request = {
        .name = "mask_reference", .lamp = lamp, .integrator = "bdpt", .cpu_seconds = reference_s};
    if (!status) status = render_lamp(kit, request, reference, error);
    for (int i = 0; i < WAY_COUNT && !status; i++) {
        const struct render_request way = {.name = WAYS[i].file,
                                           .lamp = baked,
                                           .integrator = "path",
                                           .appearance = "neural",
                                           .keep = WAYS[i].keep,
                                           .mask = WAYS[i].mask,
                                           .cpu_seconds = way_s,
                                           .lamp_seen = true};
        status = render_lamp(kit, way, &renders[i], error);
    }
    return status;
}

static enum status show_row(struct sheet *sheet, const struct kept_render *reference, const struct kept_render *renders,
                            const struct comparison *comparisons, float exposure, const char *what,
                            struct error *error) {
    sheet_row(sheet);
    enum status status = sheet_picture(sheet, &reference->image, exposure, "reference", what, error);
    for (int i = 0; i < WAY_COUNT && !status; i++) {
        char note[40];
        snprintf(note, sizeof note, "FLIP %.3f", comparisons[i].metrics.flip);
        status = sheet_picture(sheet, &renders[i].image, exposure, WAYS[i].name, note, error);
    }
    return status;
}

// The room's exposure shows what is seen through the lamp, a sixteenth of it the lamp itself.
static enum status show(const struct kept_render *reference, struct kept_render *renders, struct sheet *sheet,
                        struct error *error) {
    struct image *outside = &renders[0].outside;
    struct comparison comparisons[WAY_COUNT];
    struct image room = {0};
    enum status status = STATUS_OK;
    // The left edge of the picture has nothing of the lamp.
    status = image_crop(&room, &reference->image, 0, 0, reference->image.width / 5, reference->image.height, 1, error);
    const float exposure = status ? 1 : image_auto_exposure(&room);
    image_fini(&room);
    for (int i = 0; i < outside->width * outside->height; i++) // here the lamp itself counts
        outside->pixels[i * outside->channels] = 1 - outside->pixels[i * outside->channels];
    for (int i = 0; i < WAY_COUNT && !status; i++)
        status = compare_images(&renders[i].image, &reference->image, outside, &comparisons[i], error);
    if (!status) status = show_row(sheet, reference, renders, comparisons, exposure, "bdpt of the geometry", error);
    if (!status) status = show_row(sheet, reference, renders, comparisons, exposure / 16, "16 times darker", error);
    sheet_row(sheet);
    for (int i = 0; i < WAY_COUNT && !status; i++) {
        struct image difference = {0};
        status = image_difference(&difference, &renders[i].image, &reference->image, error);
        if (!status) status = sheet_picture(sheet, &difference, exposure, WAYS[i].name, "difference", error);
        image_fini(&difference);
    }
    sheet_table(sheet, COLUMNS);
    for (int i = 0; i < WAY_COUNT && !status; i++)
        sheet_line(sheet, WAYS[i].name,
                   (double[]){renders[i].cpu_s, renders[i].samples, comparisons[i].metrics.rel_mse,
                              comparisons[i].metrics.flip});
    return status;
}

static enum status make_masks(struct figure_kit *kit, const struct figure *figure, struct sheet *sheet,
                              struct error *error) {
    (void)figure;
    struct kept_render reference = {0}, renders[WAY_COUNT] = {0};
    figure_steps(kit, 1 + WAY_COUNT);
    enum status status = render_all(kit, &reference, renders, error);
    if (!status) status = show(&reference, renders, sheet, error);
    for (int i = 0; i < WAY_COUNT; i++) kept_render_fini(&renders[i]);
    kept_render_fini(&reference);
    return status;
}

const struct figure figure_masks = {"8",
                                    "Figure 8: what is seen through the lamp",
                                    "The light behind the lamp stopped; let through where at least half of it gets "
                                    "through; dimmed by the baked transparency per "
                                    "colour; the same with the lamp's opaque parts kept as geometry, which the room "
                                    "lights (keep opaque). Appearance neural, so "
                                    "that only the transparency differs.",
                                    360,
                                    make_masks,
                                    NULL};
