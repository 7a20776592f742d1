// The proxy: the closed convex surface (or given mesh) that stands for the lamp, just outside everything that belongs
// to it.
#pragma once

#include "bake/bake.h"
#include "luminaire/build.h"
#include "scene/scene.h"

// Fits the kind asked for; BAKE_PROXY_AUTO takes the one with the smallest mean cross-section (a quarter of its area,
// Cauchy), a sphere where others gain less than 15 %. BAKE_PROXY_MESH: the file is loaded into `arena` and must be
// closed and hold the whole lamp.
enum status lamp_proxy_fit(struct proxy *proxy, const struct scene *scene, enum bake_proxy kind, const char *path,
                           struct arena *arena, struct error *error);
const char *proxy_kind_name(enum proxy_kind kind);
