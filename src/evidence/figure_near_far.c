// Figure 15: from the near to the far field. The lamp shrinks about its place, so that the same walls are farther from
// it.
#include "evidence/compare_room.h"
#include "evidence/figure_table.h"

static const char *const SIZES[] = {NULL, "0.5", "0.25"}; // NULL: the room's, 1; shared with figure 13
enum { SIZE_COUNT = sizeof SIZES / sizeof SIZES[0] };

static enum status make_near_far(struct figure_kit *kit, const struct figure *figure, struct sheet *sheet,
                                 struct error *error) {
    (void)figure;
    enum status status = STATUS_OK;
    for (int i = 0; i < SIZE_COUNT && !status; i++) {
        const struct room_comparison room = {
            .room = "diffuse_box", .lamp = "blossom_lamp", .size = SIZES[i], .width = 360, .height = 360};
        if (i == 0) figure_steps(kit, SIZE_COUNT * compare_room_steps(&room));
        sheet_text(sheet, "The lamp at %s of its size:", SIZES[i] ? SIZES[i] : "1");
        status = compare_room(kit, &room, sheet, error);
    }
    return status;
}

const struct figure figure_near_far = {
    "15",
    "Figure 15: from near to far field",
    "The diffuse box with the lamp at its size, at half and at a quarter: one baked file serves all distances.",
    600,
    make_near_far,
    NULL};
