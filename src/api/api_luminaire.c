// The public luminaire: src/luminaire/luminaire.h under its public name.
#include "api/api_run.h"
#include "luminaire/group_setting.h"

// struct sconce_luminaire is struct luminaire seen from outside; it is never defined.
static const struct luminaire *inner(const struct sconce_luminaire *luminaire) {
    return (const struct luminaire *)luminaire;
}

enum sconce_status sconce_luminaire_open(struct sconce_luminaire **luminaire, const char *path,
                                         struct sconce_error *error) {
    struct luminaire *loaded = NULL;
    struct error inner_error = {0};
    enum status status = luminaire_load(&loaded, path, &inner_error);
    *luminaire = (struct sconce_luminaire *)loaded;
    return api_status(status, &inner_error, error);
}

void sconce_luminaire_close(struct sconce_luminaire *luminaire) { luminaire_destroy((struct luminaire *)luminaire); }

void sconce_luminaire_bounds(const struct sconce_luminaire *luminaire, float center[3], float *radius) {
    luminaire_bounds(inner(luminaire), center, radius);
}

bool sconce_luminaire_span(const struct sconce_luminaire *luminaire, const float origin[3], const float direction[3],
                           float *t_near, float *t_far) {
    return luminaire_span(inner(luminaire), origin, direction, t_near, t_far);
}

void sconce_luminaire_eval(const struct sconce_luminaire *luminaire, size_t n, const float (*point)[3],
                           const float (*w)[3], float (*radiance)[3]) {
    luminaire_eval(inner(luminaire), n, point, w, radiance);
}

void sconce_luminaire_transmittance(const struct sconce_luminaire *luminaire, size_t n, const float (*point)[3],
                                    const float (*w)[3], float (*transmittance)[3]) {
    luminaire_transmittance(inner(luminaire), n, point, w, transmittance);
}

void sconce_luminaire_sample(const struct sconce_luminaire *luminaire, size_t n, const float (*s)[3],
                             const float (*u)[3], float (*direction)[3], float *pdf_sa) {
    luminaire_sample(inner(luminaire), n, s, u, direction, pdf_sa);
}

void sconce_luminaire_pdf(const struct sconce_luminaire *luminaire, size_t n, const float (*s)[3],
                          const float (*direction)[3], float *pdf_sa) {
    luminaire_pdf(inner(luminaire), n, s, direction, pdf_sa);
}

void sconce_luminaire_scattering(const struct sconce_luminaire *luminaire, float back[3], float onward[3]) {
    luminaire_scattering(inner(luminaire), back, onward);
}

void sconce_luminaire_flux(const struct sconce_luminaire *luminaire, float flux[3]) {
    luminaire_flux(inner(luminaire), flux);
}

const char *sconce_luminaire_group(const struct sconce_luminaire *luminaire, size_t index, float flux[3]) {
    return index < luminaire_group_count(inner(luminaire)) ? luminaire_group(inner(luminaire), index, flux) : NULL;
}

enum sconce_status sconce_luminaire_dim(struct sconce_luminaire **dimmed, const struct sconce_luminaire *original,
                                        const char *settings, struct sconce_error *error) {
    float factors[LUMINAIRE_MAX_GROUPS][3];
    struct luminaire *copy = NULL;
    struct error inner_error = {0};
    enum status status = luminaire_group_factors(inner(original), settings, 1, factors, &inner_error);
    if (!status) status = luminaire_dim(&copy, inner(original), (const float(*)[3])factors, &inner_error);
    *dimmed = (struct sconce_luminaire *)copy;
    return api_status(status, &inner_error, error);
}

const char *sconce_luminaire_metadata(const struct sconce_luminaire *luminaire, const char *key) {
    return luminaire_metadata(inner(luminaire), key);
}
