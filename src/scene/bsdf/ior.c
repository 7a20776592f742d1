// Indices of refraction by name (sodium D line, 589.3 nm, at 20 C unless the name says else; CRC Handbook of Chemistry
// and Physics, and the glass makers' catalogues), under the names that Mitsuba scenes use.
#include <stdlib.h>
#include <string.h>

#include "base/param.h"
#include "scene/bsdf/fresnel.h"

static const struct {
    const char *name;
    float ior;
} media[] = {
    {"vacuum", 1.0f},      {"helium", 1.000036f},        {"hydrogen", 1.000132f},
    {"air", 1.000277f},    {"carbon dioxide", 1.00045f}, {"water", 1.3330f},
    {"acetone", 1.36f},    {"ethanol", 1.361f},          {"carbon tetrachloride", 1.461f},
    {"glycerol", 1.4729f}, {"benzene", 1.501f},          {"silicone oil", 1.52045f},
    {"bromine", 1.661f},   {"water ice", 1.31f},         {"fused quartz", 1.458f},
    {"pyrex", 1.470f},     {"acrylic glass", 1.49f},     {"polypropylene", 1.49f},
    {"bk7", 1.5046f},      {"sodium chloride", 1.544f},  {"amber", 1.55f},
    {"pet", 1.5750f},      {"diamond", 2.419f},
};
const char ior_suggestions[] =
    "vacuum|air|water|water ice|ethanol|glycerol|fused quartz|pyrex|acrylic glass|polypropylene|"
    "bk7|sodium chloride|amber|pet|diamond";

static bool ior_parse(float *ior, const char *text) {
    for (size_t i = 0; i < sizeof media / sizeof *media; ++i) {
        if (param_name_equal(media[i].name, text)) {
            *ior = media[i].ior;
            return true;
        }
    }
    char *end;
    *ior = strtof(text, &end);
    end += strspn(end, " \t\r\n");
    return end != text && *end == 0 && *ior > 0 && isfinite(*ior);
}

static enum status ior_error(const char *name, const char *text, const struct commit_context *context,
                             struct error *error) {
    const char *names[sizeof media / sizeof *media];
    for (size_t i = 0; i < sizeof media / sizeof *media; ++i) names[i] = media[i].name;
    const char *nearest = nearest_name(text, names, sizeof media / sizeof *media);
    return error_at(error, context->object->place,
                    "%s \"%s\" is neither a positive number nor the name of a medium%s%s%s; %s", name, text,
                    nearest ? " (did you mean \"" : "", nearest ? nearest : "", nearest ? "\"?)" : "",
                    "give the index of refraction, for example 1.5 or bk7");
}

enum status ior_ratio_parse(float *ratio, const char *int_ior, const char *ext_ior,
                            const struct commit_context *context, struct error *error) {
    float inside, outside;
    if (!ior_parse(&inside, int_ior)) return ior_error("int_ior", int_ior, context, error);
    if (!ior_parse(&outside, ext_ior)) return ior_error("ext_ior", ext_ior, context, error);
    *ratio = inside / outside;
    return STATUS_OK;
}
