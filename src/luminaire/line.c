#include "luminaire/line.h"

#include <math.h>

void line_block_load(struct line_block *block, const float center[3], float radius, int count, const float (*point)[3],
                     const float (*w)[3]) {
    float inverse = 1 / radius, p[3][NET_LANES];
    for (int l = 0; l < NET_LANES; l++) {
        int from = l < count ? l : count - 1;
        for (int a = 0; a < 3; a++) {
            p[a][l] = (point[from][a] - center[a]) * inverse;
            block->w[a][l] = w[from][a];
        }
    }
    for (int l = 0; l < NET_LANES; l++) {
        float wx = block->w[0][l], wy = block->w[1][l], wz = block->w[2][l];
        float along = p[0][l] * wx + p[1][l] * wy + p[2][l] * wz;
        float x = p[0][l] - along * wx, y = p[1][l] - along * wy, z = p[2][l] - along * wz;
        float d2 = x * x + y * y + z * z, inside = d2 <= 1 ? 1.0f : 0.0f;
        float shrink = d2 > 1 ? 1 / sqrtf(d2 > 1 ? d2 : 1) : 1;
        x *= shrink, y *= shrink, z *= shrink;
        float half = sqrtf(d2 < 1 ? 1 - d2 : 0);
        block->q[0][l] = x, block->q[1][l] = y, block->q[2][l] = z;
        block->u[0][l] = x + half * wx, block->u[1][l] = y + half * wy, block->u[2][l] = z + half * wz;
        block->e[0][l] = x - half * wx, block->e[1][l] = y - half * wy, block->e[2][l] = z - half * wz;
        block->half_chord[l] = half;
        block->hit[l] = inside;
    }
}
