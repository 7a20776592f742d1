// The proxy of the file, the clusters of the geometry.
#include "evidence/studied_lamp.h"

#include <string.h>

static enum status find_aims(struct studied_lamp *studied, struct error *error) {
    struct emission_cluster clusters[EMISSION_CLUSTERS];
    size_t count;
    enum status status =
        emission_clusters_find(clusters, &count, &studied->scene, -1, studied->lamp.proxy.radius, error);
    for (size_t i = 0; i < count && !status; i++)
        studied->aims[i] = (struct aim){clusters[i].center, 1.05f * clusters[i].radius};
    studied->lamp.aims = studied->aims;
    studied->lamp.aim_count = status ? 0 : count;
    return status;
}

enum status studied_lamp_open(struct studied_lamp *studied, const struct figure_kit *kit, const char *name,
                              struct error *error) {
    char lamp[PATH_MAX], baked[PATH_MAX];
    memset(studied, 0, sizeof *studied);
    evidence_lamp(lamp, &kit->data, name);
    evidence_baked(baked, &kit->data, name);
    struct scene_options options = {.lamp_only = true, .threads = kit->run.threads};
    enum status status = luminaire_load(&studied->luminaire, baked, error);
    if (status) return status;
    status = scene_load(&studied->scene, lamp, &options, &kit->run, error);
    if (!status) {
        struct lamp *l = &studied->lamp;
        *l = (struct lamp){.scene = &studied->scene,
                           .proxy = {.kind = PROXY_SPHERE},
                           .seed = kit->run.seed,
                           .threads = kit->run.threads};
        luminaire_bounds(studied->luminaire, l->proxy.center, &l->proxy.radius);
        status = proxy_shape_init(&l->shape, &l->proxy, error);
    }
    if (!status) status = find_aims(studied, error);
    studied->has_hull = !status && luminaire_hull(studied->luminaire);
    if (studied->has_hull) status = scene_init_hull(&studied->hull, studied->luminaire, kit->run.threads, error);
    if (status) studied_lamp_close(studied);
    return status;
}

void studied_lamp_close(struct studied_lamp *studied) {
    scene_fini(&studied->hull);
    scene_fini(&studied->scene);
    proxy_shape_fini(&studied->lamp.shape);
    luminaire_destroy(studied->luminaire);
}
