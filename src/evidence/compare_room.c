// The reference is bdpt of the geometry for a long time; the others get a fraction of that time each. Errors are those
// of the pixels that do not look at the lamp, whose direct view is figure 4's subject.
#include "evidence/compare_room.h"

#include <math.h>
#include <stdio.h>

#include "evidence/kept_render.h"
#include "report/compare.h"
#include "report/picture.h"

static const double reference_s = 240, equal_s = 30; // CPU seconds at scale 1

static const struct sheet_column COLUMNS[] = {{"cpu_s", "CPU seconds", 1},
                                              {"samples", "samples per pixel", 0},
                                              {"rel_mse", "relMSE", 5},
                                              {"rel_mse_corrected", "less the reference's noise", 5},
                                              {"flip", "FLIP", 3},
                                              {"block_error", "worst of 16 blocks, %", 2},
                                              {0}};

struct contender {
    const char *name, *file;
    const char *integrator, *appearance;
    bool baked;
    struct kept_render render;
    struct comparison comparison;
};

enum { OURS, BDPT, PATH, CONTENDERS };

static enum status render_one(struct figure_kit *kit, const struct room_comparison *room,
                              const struct contender *contender, double seconds, struct kept_render *render,
                              struct error *error) {
    char scene[PATH_MAX], lamp[PATH_MAX], name[100];
    evidence_room(scene, &kit->data, room->room);
    if (contender->baked)
        evidence_baked(lamp, &kit->data, room->lamp);
    else
        evidence_lamp(lamp, &kit->data, room->lamp);
    snprintf(name, sizeof name, "%s%s%s_%s", room->room, room->size ? "_" : "", room->size ? room->size : "",
             contender->file);
    const struct render_request request = {.name = name,
                                           .room = scene,
                                           .lamp = lamp,
                                           .integrator = contender->integrator,
                                           .appearance = contender->appearance,
                                           .size = room->size,
                                           .furnished = room->furnished,
                                           .cpu_seconds = seconds * kit->scale,
                                           .width = figure_side(kit, room->width),
                                           .height = figure_side(kit, room->height),
                                           .lamp_seen = contender->baked};
    return kept_render(kit, &request, render, error);
}

static enum status show_crops(const struct room_comparison *room, const struct kept_render *reference,
                              const struct contender *contenders, int count, float exposure, struct sheet *sheet,
                              struct error *error) {
    enum status status = STATUS_OK;
    for (int c = 0; c < ROOM_CROPS && !status; c++) {
        const struct room_crop *crop = &room->crops[c];
        const struct image *whole = &reference->image;
        const int side = (int)(crop->side * (float)whole->height);
        const int x = (int)(crop->x * (float)whole->width), y = (int)(crop->y * (float)whole->height);
        if (side < 1) continue;
        if (c == 0) sheet_row(sheet);
        for (int i = -1; i < count && !status; i++) {
            struct image part = {0};
            status = image_crop(&part, i < 0 ? whole : &contenders[i].render.image, x, y, side, side, 1, error);
            if (!status)
                status = sheet_picture(sheet, &part, exposure, i < 0 ? "reference" : contenders[i].name, "crop", error);
            image_fini(&part);
        }
    }
    return status;
}

static enum status show(const struct room_comparison *room, const struct kept_render *reference,
                        struct contender *contenders, int count, struct sheet *sheet, struct error *error) {
    const float exposure = image_auto_exposure(&reference->image);
    char note[100];
    snprintf(note, sizeof note, "bdpt of the geometry, %.0f CPU s", reference->cpu_s);
    sheet_row(sheet);
    enum status status = sheet_picture(sheet, &reference->image, exposure, "reference", note, error);
    for (int i = 0; i < count && !status; i++) {
        struct contender *c = &contenders[i];
        status = compare_images(&c->render.image, &reference->image, &contenders[OURS].render.outside, &c->comparison,
                                error);
        snprintf(note, sizeof note, "%.1f CPU s, relMSE %.4f", c->render.cpu_s, c->comparison.metrics.rel_mse);
        if (!status) status = sheet_picture(sheet, &c->render.image, exposure, c->name, note, error);
    }
    if (!status) status = show_crops(room, reference, contenders, count, exposure, sheet, error);
    sheet_row(sheet);
    for (int i = 0; i < count && !status; i++) {
        struct image difference = {0};
        status = image_difference(&difference, &contenders[i].render.image, &reference->image, error);
        if (!status)
            status = sheet_picture(sheet, &difference, DIFFERENCE_GAIN * exposure, contenders[i].name,
                                   "difference, 16 times", error);
        image_fini(&difference);
    }
    sheet_table(sheet, COLUMNS);
    for (int i = 0; i < count && !status; i++) {
        const struct contender *c = &contenders[i];
        const struct metrics *m = &c->comparison.metrics;
        sheet_line(sheet, c->name,
                   (double[]){c->render.cpu_s, c->render.samples, m->rel_mse, c->comparison.rel_mse_corrected, m->flip,
                              100 * m->block_error_max});
    }
    sheet_line(sheet, "reference",
               (double[]){reference->cpu_s, reference->samples, (double)NAN, (double)NAN, (double)NAN, (double)NAN});
    return status;
}

int compare_room_steps(const struct room_comparison *room) { return 1 + (room->path_too ? CONTENDERS : PATH); }

enum status compare_room(struct figure_kit *kit, const struct room_comparison *room, struct sheet *sheet,
                         struct error *error) {
    struct contender contenders[CONTENDERS] = {
        [OURS] =
            {.name = "baked lamp, path", .file = "ours", .integrator = "path", .appearance = "surface", .baked = true},
        [BDPT] = {.name = "geometry, bdpt", .file = "bdpt", .integrator = "bdpt"},
        [PATH] = {.name = "geometry, path", .file = "path", .integrator = "path"}};
    const struct contender long_run = {.file = "reference", .integrator = "bdpt"};
    const int count = compare_room_steps(room) - 1;
    struct kept_render reference = {0};
    char baked[PATH_MAX];
    enum status status = evidence_baked_check(baked, &kit->data, room->lamp, error);
    if (!status) status = render_one(kit, room, &long_run, reference_s, &reference, error);
    for (int i = 0; i < count && !status; i++)
        status = render_one(kit, room, &contenders[i], equal_s, &contenders[i].render, error);
    if (!status) status = show(room, &reference, contenders, count, sheet, error);
    for (int i = 0; i < count; i++) kept_render_fini(&contenders[i].render);
    kept_render_fini(&reference);
    return status;
}
