// What a baked lamp without its geometry does to the room's light that it stops: diffuse scattering at the middle of
// the line's chord, as if a sheet stood there across it. Its shares are the lamp's (luminaire_scattering).
#include "math/warp.h"
#include "scene/load_private.h"

struct lamp_scatter {
    struct bsdf base;
    rgb back, onward;
};

static rgb scatter_eval(const struct bsdf *bsdf, const struct bsdf_point *point, vec3 wi, vec3 wo,
                        enum transport transport) {
    (void)point, (void)transport;
    const struct lamp_scatter *self = (const struct lamp_scatter *)bsdf;
    return rgb_scale(wi.z * wo.z > 0 ? self->back : self->onward, fabsf(wo.z) * INV_PI_F);
}

static float back_share(const struct lamp_scatter *self) {
    return rgb_mean(self->back) / (rgb_mean(self->back) + rgb_mean(self->onward));
}

static float scatter_pdf(const struct bsdf *bsdf, const struct bsdf_point *point, vec3 wi, vec3 wo,
                         enum transport transport) {
    (void)point, (void)transport;
    const float back = back_share((const struct lamp_scatter *)bsdf);
    return (wi.z * wo.z > 0 ? back : 1 - back) * fabsf(wo.z) * INV_PI_F;
}

static bool scatter_sample(const struct bsdf *bsdf, const struct bsdf_point *point, vec3 wi, vec3 u,
                           enum transport transport, struct bsdf_sample *sample) {
    (void)point, (void)transport;
    const struct lamp_scatter *self = (const struct lamp_scatter *)bsdf;
    const float share = back_share(self);
    const bool back = u.z < share;
    vec3 wo = warp_cosine_hemisphere((vec2){u.x, u.y});
    const float pdf = (back ? share : 1 - share) * wo.z * INV_PI_F;
    if ((wi.z < 0) == back) wo.z = -wo.z;
    *sample =
        (struct bsdf_sample){.wo = wo,
                             .weight = rgb_scale(back ? self->back : self->onward, 1 / (back ? share : 1 - share)),
                             .pdf = pdf,
                             .eta = 1};
    return pdf > 0;
}

static rgb scatter_albedo(const struct bsdf *bsdf, vec2 uv) {
    (void)uv;
    const struct lamp_scatter *self = (const struct lamp_scatter *)bsdf;
    return rgb_add(self->back, self->onward);
}

static const struct bsdf_type scatter_type = {.name = "lamp",
                                              .help = "a baked lamp",
                                              .eval = scatter_eval,
                                              .pdf = scatter_pdf,
                                              .sample = scatter_sample,
                                              .albedo = scatter_albedo};
static const struct shape_type sheet_type = {.name = "lamp"};

enum status load_lamp_scatter(struct loader *loader, struct luminaire_instance *instance, int index) {
    float back[3], onward[3];
    luminaire_scattering(instance->file, back, onward);
    const struct lamp_scatter shares = {.base = {&scatter_type, BSDF_SMOOTH | BSDF_TRANSMISSION},
                                        .back = {back[0], back[1], back[2]},
                                        .onward = {onward[0], onward[1], onward[2]}};
    if (rgb_is_black(rgb_add(shares.back, shares.onward))) return STATUS_OK;
    struct lamp_scatter *bsdf = load_alloc(loader, sizeof *bsdf);
    struct shape *sheet = load_alloc(loader, sizeof *sheet);
    if (!bsdf || !sheet) return STATUS_MEMORY;
    *bsdf = shares;
    *sheet = (struct shape){
        .type = &sheet_type, .id = "", .place = instance->place, .bsdf = &bsdf->base, .luminaire = index};
    instance->sheet = sheet;
    return STATUS_OK;
}

void luminaire_sheet_hit(const struct luminaire_instance *instance, const struct ray *ray, float t,
                         struct surface *surface) {
    const vec3 n = vec3_neg(ray->direction);
    *surface = (struct surface){.t = t,
                                .p = vec3_mad(ray->direction, t, ray->origin),
                                .ng = n,
                                .shading = frame_from_normal(n),
                                .shape = instance->sheet};
}
