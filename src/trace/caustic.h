// Caustics of baked lamps, for the path tracer: light that leaves a lamp and meets a mirror or smooth glass first. A
// path from the camera finds it only when scattering happens to hit the lamp's few bright millimetres, which makes
// fireflies. So paths are split in two classes, each with its own technique; none is counted twice or lost:
//   - caustic: the vertex next to the lamp scattered by a delta, the vertex next to the camera by no delta, and the
//     latter is not on a lamp that shows its real geometry. Particles from the lamps find exactly these;
//   - all others: path tracing.
// Which class a path is in is known from either end alone: from the events at its first and its last vertex.
// In an unbiased rendering (residual.h) particles start at the lamps' emitters, and paths count as caustic too whose
// last line is not near, or which have no vertex in the room.
#pragma once

#include "trace/film.h"
#include "base/run.h"
#include "scene/scene.h"

struct caustic;
struct residual;
struct shared_light;
// *caustic is NULL where no particle could find anything: then path tracing has to count all paths. `residual`: NULL,
// or of an unbiased rendering; it has to outlive *caustic.
enum status caustic_create(struct caustic **caustic, const struct scene *scene, const struct residual *residual,
                           const struct run *run, struct error *error);
void caustic_destroy(struct caustic *caustic); // NULL is allowed
// Adds one pass of caustics to film->pass; the same for any number of threads. `shared`: NULL, or what learns of them
// too. *dropped grows by the contributions that were not finite.
enum status caustic_render(struct caustic *caustic, struct film *film, struct shared_light *shared, uint64_t pass,
                           const struct run *run, size_t *dropped, struct error *error);
