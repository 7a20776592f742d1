// Figure 8: what becomes of the light behind the lamp: stopped, let through or not, dimmed by colour, and with the
// lamp's opaque parts kept as geometry.
#include <stdio.h>

#include "evidence/compare_room.h"
#include "evidence/figure_table.h"
#include "report/compare.h"
#include "report/picture.h"

static const struct room_comparison room = {
    .room = "living_room", .furnished = true, .lamp = "vintage_lamp", .width = 480, .height = 360};
static const struct room_crop lamp_crop = {0.33f, 0.04f, 0.42f};

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

static enum status show_crop(struct sheet *sheet, const struct image *image, float gain, const char *name,
                             const char *note, struct error *error) {
    struct image crop = {0};
    const int side = (int)(lamp_crop.side * (float)image->height);
    enum status status = image_crop(&crop, image, (int)(lamp_crop.x * (float)image->width),
                                    (int)(lamp_crop.y * (float)image->height), side, side, 1, error);
    if (!status) status = sheet_picture(sheet, &crop, gain, name, note, error);
    image_fini(&crop);
    return status;
}

static enum status render_ways(struct figure_kit *kit, const char *lamp, struct kept_render *renders,
                               struct error *error) {
    char scene[PATH_MAX];
    evidence_room(scene, &kit->data, room.room);
    enum status status = STATUS_OK;
    for (int i = 0; i < WAY_COUNT && !status; i++) {
        const struct render_request request = {.name = WAYS[i].file,
                                               .room = scene,
                                               .lamp = lamp,
                                               .furnished = room.furnished,
                                               .integrator = "path",
                                               .appearance = "neural",
                                               .keep = WAYS[i].keep,
                                               .mask = WAYS[i].mask,
                                               .cpu_seconds = ROOM_EQUAL_S * kit->scale,
                                               .width = figure_side(kit, room.width),
                                               .height = figure_side(kit, room.height),
                                               .lamp_seen = true};
        status = kept_render(kit, &request, &renders[i], error);
    }
    return status;
}

static enum status show(const struct kept_render *reference, struct kept_render *renders, struct sheet *sheet,
                        struct error *error) {
    const float exposure = image_auto_exposure(&reference->image);
    struct image *outside = &renders[0].outside;
    struct comparison comparisons[WAY_COUNT];
    enum status status = STATUS_OK;
    for (int i = 0; i < outside->width * outside->height; i++) // here the lamp itself counts
        outside->pixels[i * outside->channels] = 1 - outside->pixels[i * outside->channels];
    for (int i = 0; i < WAY_COUNT && !status; i++)
        status = compare_images(&renders[i].image, &reference->image, outside, &comparisons[i], error);
    sheet_row(sheet);
    if (!status) status = show_crop(sheet, &reference->image, exposure, "reference", "bdpt of the geometry", error);
    for (int i = 0; i < WAY_COUNT && !status; i++) {
        char note[40];
        snprintf(note, sizeof note, "FLIP %.3f", comparisons[i].metrics.flip);
        status = show_crop(sheet, &renders[i].image, exposure, WAYS[i].name, note, error);
    }
    sheet_row(sheet);
    for (int i = 0; i < WAY_COUNT && !status; i++) {
        struct image difference = {0};
        status = image_difference(&difference, &renders[i].image, &reference->image, error);
        if (!status)
            status =
                show_crop(sheet, &difference, DIFFERENCE_GAIN * exposure, WAYS[i].name, "difference, 16 times", error);
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
    char lamp[PATH_MAX];
    enum status status = figure_baked(lamp, kit, room.lamp, error);
    if (!status) status = compare_room_reference(kit, &room, &reference, error);
    if (!status) status = render_ways(kit, lamp, renders, error);
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
