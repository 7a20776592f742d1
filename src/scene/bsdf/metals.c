// Complex indices of refraction of named metals as linear Rec. 709 triples: the tabulated spectra that Mitsuba ships
// (Palik 1985, Handbook of Optical Constants of Solids, and the sopra data base), integrated against the CIE colour
// matching functions. The triples were read out of Mitsuba 3.9 in its RGB mode (the traversed parameters of
// `conductor`), so that both renderers show the same metal; tests/reference/bsdf.py reads them again.
#include <string.h>

#include "base/param.h"
#include "scene/bsdf/fresnel.h"

static const struct metal {
    const char *name;
    rgb eta, k;
} metals[] = {
    {"none", {0, 0, 0}, {1, 1, 1}}, // the perfect mirror
    {"a-C", {2.94405f, 2.22714f, 1.96816f}, {0.887465f, 0.799299f, 0.81529f}},
    {"Ag", {0.155276f, 0.116728f, 0.138388f}, {4.82835f, 3.12222f, 2.1469f}},
    {"Al", {1.6575f, 0.880405f, 0.521244f}, {9.22381f, 6.2695f, 4.837f}},
    {"Au", {0.143036f, 0.375307f, 1.44205f}, {3.983f, 2.38556f, 1.60336f}},
    {"Be", {4.18501f, 3.18503f, 2.78406f}, {3.83547f, 3.01012f, 2.86899f}},
    {"Cr", {4.36967f, 2.91651f, 1.6549f}, {5.20655f, 4.23131f, 3.7547f}},
    {"Cu", {0.201005f, 0.92375f, 1.10222f}, {3.91326f, 2.45305f, 2.14209f}},
    {"Cu2O", {3.55177f, 2.94987f, 2.75188f}, {0.114207f, 0.193897f, 0.606134f}},
    {"CuO", {3.24754f, 2.44781f, 2.21022f}, {0.52109f, 0.570031f, 0.722179f}},
    {"Hg", {2.39894f, 1.44003f, 0.90957f}, {6.32759f, 4.37192f, 3.42176f}},
    {"HgTe", {4.77904f, 3.2312f, 2.6599f}, {1.63161f, 1.58081f, 1.72929f}},
    {"Ir", {3.0863f, 2.08219f, 1.61791f}, {5.59215f, 4.06709f, 3.26731f}},
    {"K", {0.0640432f, 0.0464098f, 0.0381849f}, {2.1042f, 1.34894f, 0.913126f}},
    {"Li", {0.265791f, 0.195618f, 0.220949f}, {3.54015f, 2.31112f, 1.66861f}},
    {"Mo", {4.48397f, 3.52513f, 2.77631f}, {4.11144f, 3.42083f, 3.15061f}},
    {"Na", {0.0602694f, 0.0561409f, 0.0619884f}, {3.17927f, 2.11249f, 1.57904f}},
    {"Nb", {3.42007f, 2.79009f, 2.39563f}, {3.44139f, 2.73767f, 2.57975f}},
    {"Ni", {2.3673f, 1.66337f, 1.46708f}, {4.49881f, 3.05015f, 2.34544f}},
    {"Rh", {2.58579f, 1.86022f, 1.55426f}, {6.78226f, 4.70299f, 3.97607f}},
    {"Se", {5.72285f, 4.16574f, 4.08134f}, {0.871136f, 1.10516f, 1.56532f}},
    {"Ta", {2.06272f, 2.39294f, 2.62793f}, {2.40836f, 1.74149f, 1.94703f}},
    {"Te", {7.50891f, 4.29643f, 2.36999f}, {5.58393f, 4.94721f, 3.99759f}},
    {"TiC", {3.70053f, 2.83742f, 2.58229f}, {3.26564f, 2.35159f, 2.17279f}},
    {"TiN", {1.64845f, 1.15052f, 1.37982f}, {3.36833f, 1.9435f, 1.10207f}},
    {"VC", {3.65757f, 2.75274f, 2.53267f}, {3.0683f, 2.19869f, 1.96319f}},
    {"V", {4.27758f, 3.51295f, 2.76107f}, {3.4913f, 2.88945f, 3.11152f}},
    {"VN", {2.8656f, 2.11919f, 1.94009f}, {3.03224f, 2.05612f, 1.61631f}},
    {"W", {4.37082f, 3.30025f, 2.99841f}, {3.50064f, 2.60487f, 2.27323f}},
};
const char metal_suggestions[] =
    "none|a-C|Ag|Al|Au|Be|Cr|Cu|Cu2O|CuO|Hg|HgTe|Ir|K|Li|Mo|Na|Nb|Ni|Rh|Se|Ta|Te|TiC|TiN|VC|V|VN|W";

static enum status metal_find(const char *name, rgb *eta, rgb *k, const struct commit_context *context,
                              struct error *error) {
    const char *names[sizeof metals / sizeof *metals];
    char bare[32]; // Mitsuba tells sources of data (Ni_palik) and crystal axes (Te-e) apart; one is enough here
    size_t length = strcspn(name, "_");
    if (length > 2 && !strncmp(name + length - 2, "-e", 2)) length -= 2;
    if (length >= sizeof bare) length = sizeof bare - 1;
    memcpy(bare, name, length);
    bare[length] = 0;
    for (size_t i = 0; i < sizeof metals / sizeof *metals; ++i) {
        names[i] = metals[i].name;
        if (!param_name_equal(metals[i].name, bare)) continue;
        *eta = metals[i].eta;
        *k = metals[i].k;
        return STATUS_OK;
    }
    const char *nearest = nearest_name(name, names, sizeof metals / sizeof *metals);
    return error_at(error, context->object->place, "unknown metal \"%s\"%s%s%s; known are %s, or give eta and k", name,
                    nearest ? " (did you mean \"" : "", nearest ? nearest : "", nearest ? "\"?)" : "",
                    metal_suggestions);
}

enum status metal_resolve(rgb *eta, rgb *k, const char *material, const char *ext_eta,
                          const struct commit_context *context, struct error *error) {
    bool given = rgb_max(*eta) > 0 || rgb_max(*k) > 0;
    if (given && !param_name_equal(material, "none")) {
        return error_at(error, context->object->place,
                        "both a material (\"%s\") and eta, k are given; remove one of them", material);
    }
    if (!given) {
        enum status status = metal_find(material, eta, k, context, error);
        if (status != STATUS_OK) return status;
    }
    float outside;
    enum status status = ior_ratio_parse(&outside, ext_eta, "1", context, error);
    *eta = rgb_scale(*eta, 1.0f / outside);
    *k = rgb_scale(*k, 1.0f / outside);
    return status;
}
