// How a renderer uses a baked lamp: the irradiance at a point that faces it, by light samples; GROUPS, as in
// "all=0.5" or "bulb=2700K", dims and tints it.
// cc irradiance.c $(pkg-config --cflags --libs sconce) -lm
#include <math.h>
#include <sconce/sconce.h>
#include <stdio.h>
#include <stdlib.h>

enum { BATCH = 256, BATCHES = 64 };

int main(int argc, char **argv) {
    if (argc != 5 && argc != 6) return fprintf(stderr, "usage: %s LAMP.safetensors X Y Z [GROUPS]\n", argv[0]), 2;
    struct sconce_luminaire *baked, *lamp;
    struct sconce_error error;
    if (sconce_luminaire_open(&baked, argv[1], &error)) return fprintf(stderr, "%s\n", error.text), 1;
    if (sconce_luminaire_dim(&lamp, baked, argc == 6 ? argv[5] : "", &error))
        return fprintf(stderr, "%s\n", error.text), 1;

    const float point[3] = {strtof(argv[2], NULL), strtof(argv[3], NULL), strtof(argv[4], NULL)};
    float center[3], radius, normal[3], length = 0;
    sconce_luminaire_bounds(lamp, center, &radius);
    for (int i = 0; i < 3; i++) length += (center[i] - point[i]) * (center[i] - point[i]);
    for (int i = 0; i < 3; i++) normal[i] = (center[i] - point[i]) / sqrtf(length);

    double irradiance[3] = {0};
    srand(1);
    for (int batch = 0; batch < BATCHES; batch++) {
        float s[BATCH][3], u[BATCH][3], direction[BATCH][3], w[BATCH][3], radiance[BATCH][3], pdf_sa[BATCH];
        for (int i = 0; i < BATCH; i++)
            for (int c = 0; c < 3; c++) {
                s[i][c] = point[c];
                u[i][c] = (float)rand() / ((float)RAND_MAX + 128.0f);
            }
        sconce_luminaire_sample(lamp, BATCH, s, u, direction, pdf_sa);
        for (int i = 0; i < BATCH; i++)
            for (int c = 0; c < 3; c++) w[i][c] = -direction[i][c];
        sconce_luminaire_eval(lamp, BATCH, s, w, radiance);
        for (int i = 0; i < BATCH; i++) {
            float cosine = direction[i][0] * normal[0] + direction[i][1] * normal[1] + direction[i][2] * normal[2];
            if (cosine > 0)
                for (int c = 0; c < 3; c++)
                    irradiance[c] += (double)(radiance[i][c] * cosine / pdf_sa[i]) / (BATCH * BATCHES);
        }
    }
    printf("%g %g %g\n", irradiance[0], irradiance[1], irradiance[2]);
    sconce_luminaire_close(lamp);
    sconce_luminaire_close(baked);
    return 0;
}
