// Ablations that bake: the demonstration lamp as a draft, each time with one thing changed. The scale has no part in
// them.
#include <math.h>

#include "evidence/figure_table.h"
#include "evidence/kept_bake.h"

struct variant {
    const char *name, *file;
    enum bake_size size;
    void (*change)(struct bake_plan *plan, double amount);
    double amount;
};

// Light fields alone are compared: no hull, and next to no transparency.
static void light_only(struct bake_plan *plan) {
    plan->view.chunks = 0;
    plan->transparency_chunks = 1;
}

static void change_steps(struct bake_plan *plan, double amount) {
    light_only(plan);
    plan->light_chunks = (size_t)fmax(1, round((double)plan->light_chunks * amount));
}

static void change_loss(struct bake_plan *plan, double amount) {
    light_only(plan);
    plan->camera_only = true; // the logarithm cannot learn from particles
    plan->loss = amount > 0 ? LIGHT_LOSS_LOGARITHM : LIGHT_LOSS_LIKELIHOOD;
}

static const struct variant SIZES[] = {{"small", "size_small", BAKE_SIZE_SMALL, NULL, 1},
                                       {"default", "size_default", BAKE_SIZE_DEFAULT, NULL, 1},
                                       {"large", "size_large", BAKE_SIZE_LARGE, NULL, 1},
                                       {0}};
static const struct variant SAMPLES[] = {{"1/16", "steps_16th", BAKE_SIZE_DEFAULT, change_steps, 1.0 / 16},
                                         {"1/4", "steps_quarter", BAKE_SIZE_DEFAULT, change_steps, 0.25},
                                         {"1 (a draft)", "steps_draft", BAKE_SIZE_DEFAULT, change_steps, 1},
                                         {"4", "steps_4", BAKE_SIZE_DEFAULT, change_steps, 4},
                                         {"16", "steps_16", BAKE_SIZE_DEFAULT, change_steps, 16},
                                         {0}};
static const struct variant LOSSES[] = {{"ours", "loss_ours", BAKE_SIZE_DEFAULT, change_loss, 0},
                                        {"of log(1 + x)", "loss_logarithm", BAKE_SIZE_DEFAULT, change_loss, 1},
                                        {0}};

static enum status make_bakes(struct figure_kit *kit, const struct figure *figure, struct sheet *sheet,
                              struct error *error) {
    const struct variant *variants = figure->data;
    enum status status = STATUS_OK;
    int count = 0;
    while (variants[count].name) count++;
    figure_steps(kit, count);
    sheet_table(sheet, bake_columns);
    for (int i = 0; i < count && !status; i++) {
        double values[BAKE_MEASURES];
        const struct bake_request request = {.name = variants[i].file,
                                             .lamp = "demo_lamp",
                                             .size = variants[i].size,
                                             .change = variants[i].change,
                                             .amount = variants[i].amount};
        status = kept_bake(kit, &request, values, error);
        if (!status) sheet_line(sheet, variants[i].name, values);
    }
    return status;
}

const struct figure figure_ablation_samples = {
    "ablation_samples",
    "Ablation: the number of training samples",
    "The paper's future work asks for fewer images. Drafts of the demonstration lamp with a part or a multiple of the "
    "traced lines, each seen once; no hull, so the transparency is not trained.",
    200,
    make_bakes,
    SAMPLES};
const struct figure figure_ablation_loss = {"ablation_loss",
                                            "Ablation: the loss",
                                            "Drafts of the demonstration lamp from camera lines alone, one path each: "
                                            "our loss, whose minimum noise does not move, "
                                            "against the paper's squared error of log(1 + x), which makes noisy lamps "
                                            "dark. The scale that sets the flux right in "
                                            "the end is told beside; the errors come after it.",
                                            100,
                                            make_bakes,
                                            LOSSES};
const struct figure figure_ablation_size = {
    "ablation_size",
    "Ablation: the size of the file",
    "Drafts of the demonstration lamp in the three sizes of sconce bake --size.",
    150,
    make_bakes,
    SIZES};
