// Clusters: the records' bounding volume is cut in two at its middle, by where the light is, again and again: always
// the part that has most light, spread widest and least even.
#include "trace/guide.h"

enum { LEAST_RECORDS = 8 }; // of a cluster
static const float least_cap = 1e-3f; // 1 - cos of the least lobe: narrower ones would not be exact in single precision
static const float least_distance2 = 1e-30f;
static const float inside = 2; // sharpness times 1 - cos at the edge of the ball: two thirds of the lobe are within
static const float even_share = 0.1f; // added to each record's share, of the mean, so that dark places have an extent

struct node {
    size_t first, count;
    vec3 mean, spread; // of the positions, spread: variance
    double share, relative; // relative: E L^2 / (E L)^2 of the radiances
    bool whole; // cannot be split
};

static float component(vec3 v, int axis) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }

// Moments by shares: where light comes from counts, not where paths happened to go.
static struct node node_make(const struct guide_record *records, size_t first, size_t count, double even) {
    struct node node = {.first = first, .count = count};
    double sum[3] = {0}, squares[3] = {0}, radiance = 0, radiance2 = 0;
    for (size_t i = first; i < first + count; i++) {
        const double weight = (double)records[i].share + even;
        for (int a = 0; a < 3; a++) {
            const double x = (double)component(records[i].p, a);
            sum[a] += weight * x;
            squares[a] += weight * x * x;
        }
        node.share += weight;
        radiance += (double)records[i].radiance;
        radiance2 += (double)records[i].radiance * (double)records[i].radiance;
    }
    node.relative = radiance > 0 ? radiance2 * (double)count / (radiance * radiance) : 1;
    float mean[3], spread[3];
    for (int a = 0; a < 3; a++) {
        mean[a] = (float)(sum[a] / node.share);
        spread[a] = (float)fmax(squares[a] / node.share - (sum[a] / node.share) * (sum[a] / node.share), 0);
    }
    node.mean = vec3_make(mean[0], mean[1], mean[2]);
    node.spread = vec3_make(spread[0], spread[1], spread[2]);
    return node;
}

static float node_radius2(const struct node *node) { // of an even disk with these moments
    return 2 * (node->spread.x + node->spread.y + node->spread.z);
}

static size_t partition(struct guide_record *records, const struct node *node, int axis) {
    size_t low = node->first;
    for (size_t i = node->first; i < node->first + node->count; i++) {
        if (!(component(records[i].p, axis) < component(node->mean, axis))) continue;
        struct guide_record swap = records[i];
        records[i] = records[low];
        records[low++] = swap;
    }
    return low - node->first;
}

static bool node_split(struct guide_record *records, struct node *node, struct node *other, double even) {
    int axis = 0;
    for (int a = 1; a < 3; a++)
        if (component(node->spread, a) > component(node->spread, axis)) axis = a;
    const size_t low = partition(records, node, axis);
    if (low < LEAST_RECORDS || node->count - low < LEAST_RECORDS) return false;
    *other = node_make(records, node->first + low, node->count - low, even);
    *node = node_make(records, node->first, low, even);
    return true;
}

static size_t nodes_find(struct node *nodes, struct guide_record *records, size_t count, double even) {
    size_t found = 1;
    nodes[0] = node_make(records, 0, count, even);
    while (found < GUIDE_CLUSTERS) {
        struct node *worst = NULL;
        double most = 0;
        for (size_t i = 0; i < found; i++) {
            const double error = nodes[i].share * sqrt((double)node_radius2(&nodes[i]) * nodes[i].relative);
            if (nodes[i].whole || !(error > most)) continue;
            most = error;
            worst = &nodes[i];
        }
        if (!worst) break;
        if (node_split(records, worst, &nodes[found], even))
            found++;
        else
            worst->whole = true;
    }
    return found;
}

// The mean without the brightest: one of a thousand may be an outlier.
static float mean_radiance(const struct guide_record *records, size_t count) {
    double sum = 0;
    float most = 0;
    for (size_t i = 0; i < count; i++) {
        sum += (double)records[i].radiance;
        most = maxf(most, records[i].radiance);
    }
    return count < 2 ? 0 : (float)(fmax(sum - (double)most, 0) / (double)(count - 1));
}

static void cluster_set(struct guide *guide, size_t k, const struct node *node, const struct guide_record *records) {
    vec3 n = {0, 0, 0};
    for (size_t i = 0; i < node->count; i++) n = vec3_add(n, records[i].n);
    n = vec3_scale(n, 1 / (float)node->count);
    guide->x[k] = node->mean.x, guide->y[k] = node->mean.y, guide->z[k] = node->mean.z;
    guide->nx[k] = n.x, guide->ny[k] = n.y, guide->nz[k] = n.z;
    guide->all_round[k] = 0.5f * maxf(1 - vec3_length(n), 0);
    guide->radius[k] = sqrtf(node_radius2(node));
    guide->radiance[k] = mean_radiance(records, node->count);
}

void guide_learn(struct guide *guide, struct guide_record *records, size_t count) {
    *guide = (struct guide){0};
    double share = 0, radiance = 0, radiance2 = 0;
    for (size_t i = 0; i < count; i++) share += (double)records[i].share;
    if (!(share > 0) || count < LEAST_RECORDS) return;
    struct node nodes[GUIDE_CLUSTERS];
    const size_t clusters = nodes_find(nodes, records, count, (double)even_share * share / (double)count);
    for (size_t k = 0; k < clusters; k++) {
        cluster_set(guide, k, &nodes[k], records + nodes[k].first);
        const double each = (double)guide->radiance[k], weight = (double)nodes[k].count / (double)count;
        radiance += weight * each;
        radiance2 += weight * each * each;
    }
    if (radiance > 0) guide->contrast = (float)(radiance2 / (radiance * radiance));
}

// Per lobe: the radiance, times how much of the ball's cross-section faces the point, times the cosine at the point,
// taken towards the upper edge of the ball, times the solid angle of the ball.
bool guide_look(const struct guide *guide, vec3 p, vec3 n, struct guide_view *view) {
    float sum = 0;
#pragma omp simd reduction(+ : sum)
    for (size_t k = 0; k < GUIDE_CLUSTERS; k++) {
        const float x = guide->x[k] - p.x, y = guide->y[k] - p.y, z = guide->z[k] - p.z, r = guide->radius[k];
        const float d2 = x * x + y * y + z * z + least_distance2, inverse = 1 / sqrtf(d2);
        const float slant = 1 / sqrtf(d2 + r * r), sine = r * slant;
        const float cap = maxf(1 - d2 * inverse * slant, least_cap);
        view->x[k] = x * inverse, view->y[k] = y * inverse, view->z[k] = z * inverse;
        const float away = -(guide->nx[k] * view->x[k] + guide->ny[k] * view->y[k] + guide->nz[k] * view->z[k]);
        const float cosine = n.x * view->x[k] + n.y * view->y[k] + n.z * view->z[k];
        const float facing = maxf(away, 0) + guide->all_round[k], above = maxf(cosine + sine, 0);
        view->sharpness[k] = inside / cap;
        view->weight[k] = guide->radiance[k] * facing * above * cap;
        sum += view->weight[k];
    }
    view->sum = sum;
    return sum > 0 && isfinite(sum);
}

// First one of the lanes that the weights are added in, then one of its lobes.
static size_t choose(const struct guide_view *view, float u) {
    float lanes[GUIDE_LANES] = {0};
    for (size_t k = 0; k < GUIDE_CLUSTERS; k += GUIDE_LANES)
        for (size_t lane = 0; lane < GUIDE_LANES; lane++) lanes[lane] += view->weight[k + lane];
    float rest = u * view->sum;
    size_t lane = 0, last = 0;
    for (size_t i = 0; i < GUIDE_LANES; i++) {
        if (!(lanes[i] > 0)) continue;
        lane = i;
        if (rest < lanes[i]) break;
        rest -= lanes[i];
    }
    for (size_t k = lane; k < GUIDE_CLUSTERS; k += GUIDE_LANES) {
        if (!(view->weight[k] > 0)) continue;
        last = k;
        if (rest < view->weight[k]) break;
        rest -= view->weight[k];
    }
    return last;
}

vec3 guide_sample(const struct guide_view *view, float u_lobe, vec2 u_direction) {
    const size_t k = choose(view, u_lobe);
    // The share of the lobe within 1 - cos = t is (1 + 2 s) t / (2 (1 + s t)).
    const float s = view->sharpness[k], u = u_direction.x;
    const float t = minf(2 * u / (1 + 2 * s * (1 - u)), 2), sine = sqrtf(maxf(t * (2 - t), 0));
    const float phi = 2 * PI_F * u_direction.y;
    const struct frame frame = frame_from_normal(vec3_make(view->x[k], view->y[k], view->z[k]));
    return vec3_normalize(frame_world_from_local(&frame, vec3_make(sine * cosf(phi), sine * sinf(phi), 1 - t)));
}

float guide_pdf(const struct guide *guide, const struct guide_view *view, vec3 direction, float *radiance) {
    float sum = 0, most = 0;
#pragma omp simd reduction(+ : sum) reduction(max : most)
    for (size_t k = 0; k < GUIDE_CLUSTERS; k++) {
        const float s = view->sharpness[k];
        const float t = 1 - (direction.x * view->x[k] + direction.y * view->y[k] + direction.z * view->z[k]);
        const float inverse = 1 / (1 + s * t);
        sum += view->weight[k] * (1 + 2 * s) * inverse * inverse;
        most = maxf(most, s * t <= inside ? guide->radiance[k] : 0);
    }
    *radiance = most;
    return sum / (4 * PI_F * view->sum);
}
