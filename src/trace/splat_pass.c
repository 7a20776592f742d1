// Waves of blocks: traced in parallel, then their splats are added in block order, which bounds the memory of the
// lists.
#include "trace/splat_pass.h"

#include "base/parallel.h"

struct wave {
    struct splat_pass *splat_pass;
    struct film *film;
    const struct run *run;
    uint64_t pass;
    size_t first, pixel_count;
};

static void trace_block(void *user, size_t index, int worker) {
    const struct wave *wave = user;
    struct splat_pass *sp = wave->splat_pass;
    struct splat_list *list = &sp->lists[index];
    splat_list_clear(list);
    if (run_cancelled(wave->run)) return;
    size_t begin = (wave->first + index) * SPLAT_BLOCK, end = begin + SPLAT_BLOCK;
    if (end > wave->pixel_count) end = wave->pixel_count;
    for (size_t i = begin; i < end; i++) {
        int x = sp->sensor->crop_x + (int)(i % (size_t)wave->film->width),
            y = sp->sensor->crop_y + (int)(i / (size_t)wave->film->width);
        rgb value = sp->trace(sp->user, x, y, wave->pass, wave->run, worker, list);
        if (!rgb_is_finite(value)) {
            list->dropped++;
            continue;
        }
        float *pixel = wave->film->pass + 3 * i;
        pixel[0] += value.r;
        pixel[1] += value.g;
        pixel[2] += value.b;
    }
}

enum status splat_pass_run(struct splat_pass *sp, struct film *film, uint64_t pass, const struct run *run,
                           struct error *error) {
    size_t pixel_count = (size_t)film->width * (size_t)film->height, dropped = 0;
    size_t blocks = (pixel_count + SPLAT_BLOCK - 1) / SPLAT_BLOCK;
    int threads = run->threads < sp->workers ? run->threads : sp->workers;
    // As many light paths as pixels in the crop share the flux of the whole film.
    float scale = (float)((double)sp->sensor->width * sp->sensor->height / (double)pixel_count);
    for (size_t first = 0; first < blocks; first += SPLAT_WAVE) {
        size_t count = blocks - first < SPLAT_WAVE ? blocks - first : SPLAT_WAVE;
        struct wave wave = {sp, film, run, pass, first, pixel_count};
        parallel_for(threads, count, trace_block, &wave);
        if (run_cancelled(run)) return error_set(error, STATUS_CANCELLED, "cancelled");
        splat_merge(sp->lists, count, scale, film->pass, pixel_count, threads);
        for (size_t i = 0; i < count; i++) {
            if (sp->lists[i].out_of_memory)
                return error_set(error, STATUS_MEMORY, "out of memory for the light paths' splats");
            dropped += sp->lists[i].dropped;
        }
    }
    if (dropped && !sp->dropped_told) {
        sp->dropped_told = true;
        run_warn(run,
                 "%zu contributions were not finite and were left out in pass %llu (further ones are not reported)",
                 dropped, (unsigned long long)pass);
    }
    return STATUS_OK;
}

void splat_pass_fini(struct splat_pass *sp) {
    for (size_t i = 0; i < SPLAT_WAVE; i++) splat_list_fini(&sp->lists[i]);
}
