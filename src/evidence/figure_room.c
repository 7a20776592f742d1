// Figures that show one room or box each: they differ in data only.
#include "evidence/compare_room.h"
#include "evidence/figure_table.h"

static enum status make_room(struct figure_kit *kit, const struct figure *figure, struct sheet *sheet,
                             struct error *error) {
    figure_steps(kit, compare_room_steps(figure->data));
    return compare_room(kit, figure->data, sheet, error);
}

static const char CAPTION[] =
    "The baked lamp under the path tracer and its geometry under bidirectional path tracing, in equal "
    "CPU time, against a longer bidirectional reference. Errors count the pixels that do not look at "
    "the lamp.";

static const struct room_comparison living_room = {.room = "living_room",
                                                   .furnished = true,
                                                   .lamp = "vintage_lamp",
                                                   .width = 480,
                                                   .height = 360,
                                                   .crops = {{0.4f, 0.55f, 0.3f}, {0.6f, 0.4f, 0.3f}}};
const struct figure figure_living_room = {
    "10", "Figure 10: living room, vintage crystal", CAPTION, 300, make_room, &living_room};

static const struct room_comparison bedroom = {.room = "bedroom",
                                               .furnished = true,
                                               .lamp = "feather_lamp",
                                               .width = 480,
                                               .height = 360,
                                               .crops = {{0.3f, 0.5f, 0.3f}, {0.42f, 0.15f, 0.3f}}};
const struct figure figure_bedroom = {"11", "Figure 11: bedroom, white feather", CAPTION, 300, make_room, &bedroom};

static const struct room_comparison elevator_room = {.room = "elevator_room",
                                                     .furnished = true,
                                                     .lamp = "statler_lamp",
                                                     .width = 480,
                                                     .height = 360,
                                                     .crops = {{0.3f, 0.4f, 0.3f}, {0.2f, 0.55f, 0.3f}}};
const struct figure figure_elevator_room = {
    "12", "Figure 12: elevator lobby, Statler", CAPTION, 300, make_room, &elevator_room};

static const struct room_comparison diffuse_box = {.room = "diffuse_box",
                                                   .lamp = "blossom_lamp",
                                                   .width = 360,
                                                   .height = 360,
                                                   .crops = {{0.2f, 0.3f, 0.3f}, {0.5f, 0.72f, 0.28f}}};
const struct figure figure_diffuse_box = {
    "13", "Figure 13: diffuse box, cherry blossom", CAPTION, 300, make_room, &diffuse_box};

static const struct room_comparison specular_box = {.room = "specular_box",
                                                    .lamp = "blossom_lamp",
                                                    .width = 360,
                                                    .height = 360,
                                                    .crops = {{0.22f, 0.55f, 0.3f}, {0.7f, 0.3f, 0.3f}}};
const struct figure figure_specular_box = {
    "14", "Figure 14: specular box, cherry blossom", CAPTION, 300, make_room, &specular_box};

static const struct room_comparison equal_time = {.room = "demo_room",
                                                  .lamp = "demo_lamp",
                                                  .width = 480,
                                                  .height = 360,
                                                  .path_too = true,
                                                  .crops = {{0.33f, 0.55f, 0.3f}, {0.7f, 0.22f, 0.3f}}};
const struct figure figure_equal_time = {
    "16", "Figure 16: equal time, the demonstration room", CAPTION, 330, make_room, &equal_time};

static const struct room_comparison loft = {.room = "loft_apartment",
                                            .furnished = true,
                                            .lamp = "star_lamp",
                                            .width = 480,
                                            .height = 360,
                                            .crops = {{0.45f, 0.5f, 0.3f}, {0.68f, 0.2f, 0.3f}}};
const struct figure figure_loft = {"17", "Figure 17: loft apartment, Moravian star", CAPTION, 300, make_room, &loft};

static const struct room_comparison crystal_room = {.room = "crystal_room",
                                                    .lamp = "crystal_lamp",
                                                    .width = 480,
                                                    .height = 360,
                                                    .crops = {{0.4f, 0.55f, 0.3f}, {0.62f, 0.68f, 0.3f}}};
const struct figure figure_crystal_room = {
    "18", "Figure 18: crystal lamp over a polished floor", CAPTION, 300, make_room, &crystal_room};
