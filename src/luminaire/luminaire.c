// The finished luminaire: putting it together, and what its groups have in common.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "luminaire/hull_pack.h"
#include "luminaire/luminaire_private.h"

enum status luminaire_set_metadata(struct luminaire *luminaire, const char *const *keys, const char *const *values,
                                   size_t count, struct error *error) {
    luminaire->keys = calloc(count + 1, sizeof(char *));
    luminaire->values = calloc(count + 1, sizeof(char *));
    if (!luminaire->keys || !luminaire->values) return error_set(error, STATUS_MEMORY, "out of memory for metadata");
    luminaire->metadata_count = count;
    for (size_t i = 0; i < count; i++) {
        luminaire->keys[i] = strdup(keys[i]);
        luminaire->values[i] = strdup(values[i]);
        if (!luminaire->keys[i] || !luminaire->values[i])
            return error_set(error, STATUS_MEMORY, "out of memory for metadata");
    }
    return STATUS_OK;
}

static void set_first(struct luminaire *luminaire, struct light_field *field, struct sampling_density *density,
                      const float flux[3]) {
    struct emission *emission = &luminaire->emissions[0];
    *emission = (struct emission){.light = field, .density = density, .flux = {flux[0], flux[1], flux[2]}};
    luminaire->emission_count = 1;
    for (int c = 0; c < 3; c++) luminaire->factor[0][c] = 1;
    luminaire_derive(luminaire);
}

enum status luminaire_assemble(struct luminaire **luminaire, const struct proxy *proxy, struct light_field *field,
                               struct transparency *transparency, struct sampling_density *density, const float flux[3],
                               const char *const *keys, const char *const *values, size_t metadata_count,
                               struct error *error) {
    struct luminaire *l = *luminaire = calloc(1, sizeof *l);
    if (!l) {
        light_field_destroy(field);
        transparency_destroy(transparency);
        sampling_density_destroy(density);
        return error_set(error, STATUS_MEMORY, "out of memory for a luminaire");
    }
    l->transparency = transparency;
    set_first(l, field, density, flux);
    enum status status = proxy_shape_init(&l->shape, proxy, error);
    if (!status && !density)
        status = sampling_density_build(&l->emissions[0].density, proxy, NULL, 0, NULL, 0, 0, 1, error);
    if (!status) status = luminaire_set_metadata(l, keys, values, metadata_count, error);
    if (!status) status = field_net_finish(&field->net, error);
    if (!status && transparency) status = field_net_finish(&transparency->net, error);
    if (status) {
        luminaire_destroy(l);
        *luminaire = NULL;
        return status;
    }
    l->bytes = luminaire_measure(l);
    return STATUS_OK;
}

enum status luminaire_assemble_paper(struct luminaire **luminaire, const struct proxy *proxy, struct paper *paper,
                                     const float flux[3], const char *const *keys, const char *const *values,
                                     size_t metadata_count, struct error *error) {
    struct luminaire *l = *luminaire = calloc(1, sizeof *l);
    if (!l) {
        paper_destroy(paper);
        return error_set(error, STATUS_MEMORY, "out of memory for a luminaire");
    }
    l->paper = paper;
    set_first(l, NULL, NULL, flux);
    enum status status = proxy_shape_init(&l->shape, proxy, error);
    if (!status) status = luminaire_set_metadata(l, keys, values, metadata_count, error);
    if (status) {
        luminaire_destroy(l);
        *luminaire = NULL;
        return status;
    }
    l->bytes = luminaire_measure(l);
    return STATUS_OK;
}

void luminaire_destroy(struct luminaire *luminaire) {
    if (!luminaire) return;
    if (luminaire->borrowed) {
        free(luminaire);
        return;
    }
    proxy_shape_fini(&luminaire->shape);
    paper_destroy(luminaire->paper);
    transparency_destroy(luminaire->transparency);
    hull_destroy(luminaire->hull);
    for (int g = 0; g < luminaire->emission_count; g++) {
        light_field_destroy(luminaire->emissions[g].light);
        sampling_density_destroy(luminaire->emissions[g].density);
        view_field_destroy(luminaire->emissions[g].view);
    }
    for (size_t i = 0; i < luminaire->metadata_count; i++) {
        free(luminaire->keys[i]);
        free(luminaire->values[i]);
    }
    free(luminaire->keys);
    free(luminaire->values);
    free(luminaire);
}

void luminaire_bounds(const struct luminaire *luminaire, float center[3], float *radius) {
    memcpy(center, luminaire->shape.proxy.center, sizeof luminaire->shape.proxy.center);
    *radius = luminaire->shape.proxy.radius;
}

int luminaire_span(const struct luminaire *luminaire, const float origin[3], const float direction[3], float *t_near,
                   float *t_far) {
    return proxy_shape_span(&luminaire->shape, origin, direction, t_near, t_far);
}

// The networks know the bounding sphere; what misses the proxy itself is set to `value`.
static void mask_misses(const struct luminaire *luminaire, size_t n, const float (*point)[3], const float (*w)[3],
                        float value, float (*result)[3]) {
    float t_near, t_far;
    for (size_t i = 0; i < n; i++)
        if (!proxy_shape_span(&luminaire->shape, point[i], w[i], &t_near, &t_far))
            for (int c = 0; c < 3; c++) result[i][c] = value;
}

void luminaire_eval(const struct luminaire *luminaire, size_t n, const float (*point)[3], const float (*w)[3],
                    float (*radiance)[3]) {
    luminaire_eval_met(luminaire, n, point, w, radiance);
    if (luminaire->shape.proxy.kind != PROXY_SPHERE) mask_misses(luminaire, n, point, w, 0, radiance);
}

void luminaire_transmittance_met(const struct luminaire *luminaire, size_t n, const float (*point)[3],
                                 const float (*w)[3], float (*transmittance)[3]) {
    if (luminaire->paper)
        paper_transmittance(luminaire->paper, n, point, w, transmittance);
    else if (luminaire->transparency)
        transparency_eval(luminaire->transparency, n, point, w, transmittance);
    else
        memset(transmittance, 0, n * sizeof *transmittance);
}

void luminaire_transmittance(const struct luminaire *luminaire, size_t n, const float (*point)[3], const float (*w)[3],
                             float (*transmittance)[3]) {
    luminaire_transmittance_met(luminaire, n, point, w, transmittance);
    const bool network = luminaire->paper || luminaire->transparency;
    if (luminaire->shape.proxy.kind != PROXY_SPHERE || !network) mask_misses(luminaire, n, point, w, 1, transmittance);
}

int luminaire_seen(const struct luminaire *luminaire, const float point[3], const float w[3]) {
    return !luminaire->transparency || transparency_sees(luminaire->transparency, point, w);
}

enum status luminaire_set_view(struct luminaire *luminaire, struct hull *hull, struct view_field *view,
                               struct error *error) {
    hull_destroy(luminaire->hull);
    view_field_destroy(luminaire->emissions[0].view);
    luminaire->hull = hull;
    luminaire->emissions[0].view = view;
    enum status status = hull_check(hull, luminaire->shape.proxy.center, luminaire->shape.proxy.radius, error);
    if (!status && !hull->packed) status = hull_pack(hull, error);
    if (!status) status = view_field_finish(view, error);
    luminaire->bytes = luminaire_measure(luminaire);
    return status;
}

const struct hull *luminaire_hull(const struct luminaire *luminaire) { return luminaire->hull; }

void luminaire_scattering(const struct luminaire *luminaire, float back[3], float onward[3]) {
    memcpy(back, luminaire->scattering[0], sizeof luminaire->scattering[0]);
    memcpy(onward, luminaire->scattering[1], sizeof luminaire->scattering[1]);
}

enum status luminaire_set_scattering(struct luminaire *luminaire, const float back[3], const float onward[3],
                                     struct error *error) {
    for (int c = 0; c < 3; c++)
        if (!(back[c] >= 0) || !(onward[c] >= 0) || !(back[c] + onward[c] <= 1))
            return error_set(error, STATUS_INVALID, "a lamp cannot scatter less light than none, or more than all");
    memcpy(luminaire->scattering[0], back, sizeof luminaire->scattering[0]);
    memcpy(luminaire->scattering[1], onward, sizeof luminaire->scattering[1]);
    return STATUS_OK;
}

void luminaire_flux(const struct luminaire *luminaire, float flux[3]) {
    memcpy(flux, luminaire->flux, sizeof luminaire->flux);
}

const char *luminaire_metadata(const struct luminaire *luminaire, const char *key) {
    for (size_t i = 0; i < luminaire->metadata_count; i++)
        if (strcmp(luminaire->keys[i], key) == 0) return luminaire->values[i];
    return NULL;
}

const char *luminaire_metadata_key(const struct luminaire *luminaire, size_t index) {
    return index < luminaire->metadata_count ? luminaire->keys[index] : NULL;
}

size_t luminaire_bytes(const struct luminaire *luminaire) { return luminaire->bytes; }
