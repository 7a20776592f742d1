// The hull and the view field of small lamps: what it shows against the lamp's own geometry, closed forms of a bare
// emitter, the same numbers for any number of threads, the file.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "bake/hull_build.h"
#include "bake/hull_simplify.h"
#include "bake/lamp_proxy.h"
#include "bake/survey.h"
#include "bake/view_bake.h"
#include "math/warp.h"
#include "trace/hull_look.h"
#include "trace/line_view.h"

#define SPHERE(radius, rest)                                                                                           \
    "<shape type='sphere'><point name='center' x='0.2' y='0' z='0'/><float name='radius' value='" radius "'/>" rest    \
    "</shape>"
#define GLOW "<emitter type='area'><rgb name='radiance' value='10, 20, 5'/></emitter>"
#define PLATE                                                                                                          \
    "<shape type='cube'><transform name='to_world'><scale x='0.8' y='0.05' z='0.8'/><translate y='-0.7'/></transform>" \
    "<bsdf type='diffuse'><rgb name='reflectance' value='0.7'/></bsdf></shape>"

static const char lamp_text[] = "<scene version='3.0.0'>" SPHERE("0.2", GLOW) // in a clear shell, over a plate
    SPHERE("0.4", "<boolean name='flip_normals' value='true'/><bsdf type='dielectric'/>")
        SPHERE("0.5", "<bsdf type='dielectric'/>") PLATE "</scene>";

struct setting {
    struct scene scene;
    struct lamp lamp;
    struct arena arena;
    struct survey survey;
    struct aim aims[SURVEY_CLUSTERS];
};

static void set_up(struct setting *s, const char *text, int threads) {
    char path[] = "/tmp/sconce_view_XXXXXX";
    int descriptor = mkstemp(path);
    assert_true(descriptor >= 0);
    assert_int_equal(write(descriptor, text, strlen(text)), (ssize_t)strlen(text));
    close(descriptor);
    struct error error = {0};
    const struct run run = {.threads = threads, .seed = 1};
    struct scene_options options = {.lamp_only = true, .threads = threads};
    *s = (struct setting){.arena = {0}};
    assert_int_equal(scene_load(&s->scene, path, &options, &run, &error), STATUS_OK);
    unlink(path);
    s->lamp = (struct lamp){.scene = &s->scene, .seed = 1, .threads = threads, .aims = s->aims};
    assert_int_equal(lamp_proxy_fit(&s->lamp.proxy, &s->scene, BAKE_PROXY_SPHERE, NULL, &s->arena, &error), STATUS_OK);
    assert_int_equal(survey_clusters(&s->survey, &s->lamp, &error), STATUS_OK);
    for (size_t i = 0; i < s->survey.cluster_count; i++)
        s->aims[i] = (struct aim){s->survey.clusters[i].center, 1.05f * s->survey.clusters[i].radius};
    s->lamp.aim_count = s->survey.cluster_count;
}

static void tear_down(struct setting *s) {
    survey_fini(&s->survey);
    scene_fini(&s->scene);
    arena_fini(&s->arena);
}

static struct view_result bake(struct setting *s, enum data_source data, size_t chunks) {
    const struct run run = {.threads = s->lamp.threads, .seed = 1};
    struct view_plan plan = {.data = data, .chunks = chunks, .log2_entries = 12};
    struct view_result result = {NULL, NULL};
    struct hull_map map;
    struct error error = {0};
    assert_int_equal(hull_build(&result.hull, &map, &s->lamp, 4000, &error), STATUS_OK);
    assert_int_equal(view_bake(&result, &map, &s->lamp, &plan, &run, &error), STATUS_OK);
    hull_map_fini(&map);
    assert_non_null(result.hull);
    assert_int_equal(hull_check(result.hull, s->lamp.proxy.center, s->lamp.proxy.radius, &error), STATUS_OK);
    return result;
}

static struct luminaire *make_luminaire(struct setting *s, struct view_result *view) {
    struct light_field *field;
    struct luminaire *luminaire;
    struct error error = {0};
    struct light_field_options options = {
        .proxy = s->lamp.proxy, .use_grid4 = true, .radiance_unit = 1, .log2_entries = 10, .steps = 1};
    const float flux[3] = {1, 1, 1};
    assert_int_equal(light_field_create(&field, &options, &error), STATUS_OK);
    assert_int_equal(luminaire_assemble(&luminaire, &s->lamp.proxy, field, NULL, NULL, flux, NULL, NULL, 0, &error),
                     STATUS_OK);
    assert_int_equal(luminaire_set_view(luminaire, view->hull, view->field, &error), STATUS_OK);
    *view = (struct view_result){NULL, NULL};
    return luminaire;
}

static void release(struct view_result *view) {
    hull_destroy(view->hull);
    view_field_destroy(view->field);
}

static struct ray uniform_line(const struct proxy *proxy, struct sampler *sampler) {
    vec3 w = warp_uniform_sphere(sampler_2d(sampler)), center = {proxy->center[0], proxy->center[1], proxy->center[2]};
    vec2 disk = warp_concentric_disk(sampler_2d(sampler));
    struct frame frame = frame_from_normal(w);
    vec3 start = frame_world_from_local(&frame, (vec3){disk.x, disk.y, 1.001f});
    return (struct ray){vec3_mad(start, proxy->radius, center), vec3_neg(w), 0, INFINITY};
}

// Silhouettes, and what the hull shows in total and part by part, by uniform lines.
static void shows_the_lamp(void **state) {
    (void)state;
    struct setting s;
    set_up(&s, lamp_text, 2);
    const bool glass[4] = {false, true, true, false};
    for (int data = DATA_CAMERA; data <= DATA_PARTICLES; data++) {
        struct view_result view = bake(&s, (enum data_source)data, 24);
        struct luminaire *luminaire = make_luminaire(&s, &view);
        const struct hull *mesh = luminaire_hull(luminaire);
        struct scene hull;
        struct error error = {0};
        assert_int_equal(scene_init_hull(&hull, luminaire, 1, &error), STATUS_OK);
        enum { LINES = 200000 };
        size_t differ = 0;
        double shown[2] = {0, 0}, traced[2] = {0, 0}, squares[2] = {0, 0}; // of the emitter, of the plate
        for (size_t i = 0; i < LINES; i++) {
            struct sampler sampler = sampler_make(5, 0, i), again;
            struct ray ray = uniform_line(&s.lamp.proxy, &sampler);
            struct surface surface, first;
            bool met = scene_intersect(&s.scene, &ray, -1, &surface);
            differ += met != scene_intersect_hulls(&hull, &ray, -1, &first);
            again = sampler;
            struct line_view line;
            if (trace_line_view(&s.scene, glass, &ray, &sampler, &line)) {
                struct line_hit hit;
                trace_line_radiance(&s.scene, &line.ray, &sampler, s.aims, s.lamp.aim_count, 50, &hit);
                int plate = line.surface.shape->index == 3;
                double y = (double)hit.radiance.g;
                traced[plate] += y / LINES;
                squares[plate] += y * y / LINES;
            }
            struct hull_glimpse seen[4]; // of every other line both ways of the glass
            const size_t ways = hull_trace(&hull, mesh, &ray, &again, i & 1 ? 2 : 0, seen);
            for (size_t k = 0; k < ways; k++) {
                float l[1][3];
                luminaire_view(luminaire, 1, &seen[k].at, l);
                shown[seen[k].at.point[1] < -0.6f] += (double)(l[0][1] * seen[k].weight) / LINES;
            }
        }
        for (int k = 0; k < 2; k++) {
            double noise = sqrt(squares[k] / LINES) / traced[k];
            printf("data %d, %s: shown / traced - 1 = %.3f (noise %.3f)\n", data, k ? "plate" : "emitter",
                   shown[k] / traced[k] - 1, noise);
            assert_true(fabs(shown[k] / traced[k] - 1) < 0.04 + 3 * noise);
        }
        printf("silhouettes differ on %.3f %% of the lines\n", 100.0 * (double)differ / LINES);
        assert_true(differ < LINES / 100); // the spheres' 24 sides
        scene_fini(&hull);
        luminaire_destroy(luminaire);
    }
    tear_down(&s);
}

// Of a box nothing is lost.
static void a_box_keeps_its_silhouette(void **state) {
    (void)state;
    struct setting s;
    set_up(&s,
           "<scene version='3.0.0'><shape type='cube'><transform name='to_world'><rotate x='1' y='2' angle='33'/>"
           "<scale x='1' y='0.3' z='2'/></transform>" GLOW "</shape></scene>",
           2);
    struct view_result view = bake(&s, DATA_CAMERA, 12);
    assert_int_equal(view.hull->part_count, 1);
    assert_int_equal(view.hull->triangle_count, 12);
    struct luminaire *luminaire = make_luminaire(&s, &view);
    struct scene hull;
    struct error error = {0};
    assert_int_equal(scene_init_hull(&hull, luminaire, 1, &error), STATUS_OK);
    size_t differ = 0, met = 0;
    double error_sum = 0;
    for (size_t i = 0; i < 100000; i++) {
        struct sampler sampler = sampler_make(6, 0, i);
        struct ray ray = uniform_line(&s.lamp.proxy, &sampler);
        struct surface surface;
        struct hull_glimpse seen;
        bool hit = scene_intersect(&s.scene, &ray, -1, &surface);
        bool shows = hull_trace(&hull, luminaire_hull(luminaire), &ray, &sampler, 0, &seen);
        differ += hit != shows;
        met += hit;
        if (!shows) continue;
        float l[1][3];
        luminaire_view(luminaire, 1, &seen.at, l);
        for (int c = 0; c < 3; c++) error_sum += fabs((double)l[0][c] / (c == 0 ? 10 : c == 1 ? 20 : 5) - 1) / 3;
    }
    printf("box: %zu of %zu lines differ, radiance within %.3f\n", differ, met, error_sum / (double)met);
    assert_true(differ <= 3); // lines that graze an edge
    assert_true(error_sum < 0.03 * (double)met);
    scene_fini(&hull);
    luminaire_destroy(luminaire);
    tear_down(&s);
}

// Glints are where facets turn to: those of a bead of a few millimetres in a lamp of two metres stay within 2e-4
// radians of the bead's own (1e-2 with positions of 16 bits).
static void small_facets_keep_their_normals(void **state) {
    (void)state;
    struct setting s;
    set_up(&s,
           "<scene version='3.0.0'>" SPHERE("1", GLOW) "<shape type='cube'><transform name='to_world'>"
                                                       "<rotate x='1' y='2' z='3' angle='40'/><scale "
                                                       "value='0.003'/><translate x='1.1' y='0.4' z='0.2'/></transform>"
                                                       "<bsdf type='dielectric'/></shape></scene>",
           1);
    struct view_result view = bake(&s, DATA_CAMERA, 1);
    const vec3 axis = vec3_normalize((vec3){1, 2, 3});
    const struct hull *hull = view.hull;
    size_t facets = 0;
    for (size_t k = 0; k < hull->part_count; k++)
        for (size_t t = 0; hull->parts[k].kind == HULL_GLASS && t < hull->parts[k].count; t++) {
            const vec3 normal = hull_face_normal(hull, hull->parts[k].first + t);
            float nearest = INFINITY; // angle to one of the cube's, turned back (Rodrigues)
            const float turn = -40 * PI_F / 180;
            const vec3 back = vec3_mad(axis, vec3_dot(axis, normal) * (1 - cosf(turn)),
                                       vec3_mad(vec3_cross(axis, normal), sinf(turn), vec3_scale(normal, cosf(turn))));
            const float n[3] = {back.x, back.y, back.z};
            for (int c = 0; c < 3; c++) nearest = fminf(nearest, hypotf(n[(c + 1) % 3], n[(c + 2) % 3]));
            assert_true(nearest < 2e-4f);
            facets++;
        }
    assert_int_equal(facets, 12);
    release(&view);
    tear_down(&s);
}

// A box whose file gives the normals of its faces, and a ball: normals are the surfaces' own, also where faces meet.
static void normals_are_the_surfaces_own(void **state) {
    (void)state;
    char path[] = "/tmp/sconce_box_XXXXXX.obj", text[800];
    FILE *file = fdopen(mkstemps(path, 4), "w");
    for (int v = 0; v < 8; v++)
        fprintf(file, "v %g %g %g\n", v & 1 ? 0.5 : -0.5, v & 2 ? 0.3 : -0.3, v & 4 ? -0.6 : -0.9);
    fprintf(file, "vn -1 0 0\nvn 1 0 0\nvn 0 -1 0\nvn 0 1 0\nvn 0 0 -1\nvn 0 0 1\n");
    static const int faces[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
    for (int f = 0; f < 6; f++)
        for (int k = 0; k < 2; k++)
            fprintf(file, "f %d//%d %d//%d %d//%d\n", faces[f][0] + 1, f + 1, faces[f][k + 1] + 1, f + 1,
                    faces[f][k + 2] + 1, f + 1);
    fclose(file);
    snprintf(text, sizeof text,
             "<scene version='3.0.0'>%s<shape type='obj'><string name='filename' value='%s'/>"
             "<bsdf type='diffuse'/></shape></scene>",
             SPHERE("0.2", GLOW), path);
    struct setting s;
    set_up(&s, text, 2);
    unlink(path);
    struct hull *hull;
    struct hull_map map;
    struct error error = {0};
    assert_int_equal(hull_build(&hull, &map, &s.lamp, 4000, &error), STATUS_OK);
    assert_int_equal(hull->part_count, 2);
    float worst[2] = {0, 0};
    for (size_t k = 0; k < 2; k++) {
        const struct hull_part *part = &hull->parts[k];
        const bool is_box = part->count == 12;
        assert_true(part->smooth);
        for (size_t c = 3 * (size_t)part->first; c < 3 * (size_t)(part->first + part->count); c++) {
            const size_t v = hull->triangles[c / 3][c % 3];
            const vec3 n = hull_normal(hull, v), p = hull_vertex(hull, v);
            const vec3 own = is_box ? hull_face_normal(hull, c / 3) : vec3_normalize(vec3_sub(p, (vec3){0.2f, 0, 0}));
            worst[is_box] = fmaxf(worst[is_box], vec3_length(vec3_sub(n, own)));
        }
    }
    printf("normals: off by %.4f at most on the ball, %.4f on the box\n", (double)worst[0], (double)worst[1]);
    assert_true(worst[0] < 0.01f && worst[1] < 1e-3f); // the ball's are asked for beside the vertices
    hull_destroy(hull);
    hull_map_fini(&map);
    tear_down(&s);
}

static void same_for_any_threads_and_from_file(void **state) {
    (void)state;
    struct view_result views[2];
    for (int i = 0; i < 2; i++) {
        struct setting s;
        set_up(&s, lamp_text, 1 + i);
        views[i] = bake(&s, DATA_BOTH, 2);
        tear_down(&s);
    }
    const struct hull *a = views[0].hull, *b = views[1].hull;
    assert_int_equal(a->triangle_count, b->triangle_count);
    assert_memory_equal(a->vertices, b->vertices, a->vertex_count * sizeof *a->vertices);
    assert_memory_equal(a->triangles, b->triangles, a->triangle_count * sizeof *a->triangles);
    const struct trainer *t = views[0].field->trainer, *u = views[1].field->trainer;
    assert_memory_equal(t->table, u->table, t->layout.entry_count * 2 * sizeof(float));
    assert_memory_equal(t->mlp, u->mlp, t->mlp_count * sizeof(float));
    release(&views[1]);

    struct setting s;
    struct luminaire *luminaire, *read;
    struct error error = {0};
    set_up(&s, lamp_text, 1);
    luminaire = make_luminaire(&s, &views[0]);
    char path[] = "/tmp/sconce_view_XXXXXX";
    close(mkstemp(path));
    assert_int_equal(luminaire_save(luminaire, path, &error), STATUS_OK);
    assert_int_equal(luminaire_load(&read, path, &error), STATUS_OK);
    unlink(path);
    assert_int_equal(luminaire_hull(read)->part_count, luminaire_hull(luminaire)->part_count);
    for (size_t i = 0; i < luminaire_hull(luminaire)->vertex_count; i++) {
        const vec3 kept = hull_vertex(luminaire_hull(luminaire), i), found = hull_vertex(luminaire_hull(read), i);
        assert_memory_equal(&kept, &found, sizeof kept);
    }
    struct view_point points[40];
    float l[40][3], m[40][3];
    for (int i = 0; i < 40; i++)
        points[i] = (struct view_point){.point = {0.02f * i, -0.65f, 0.3f}, .normal = {0, 1, 0}, .w = {0.6f, 0.8f, 0}};
    luminaire_view(luminaire, 40, points, l);
    luminaire_view(read, 40, points, m);
    assert_memory_equal(l, m, sizeof l);
    luminaire_destroy(read);
    luminaire_destroy(luminaire);
    tear_down(&s);
}

static void bad_hulls_are_refused(void **state) {
    (void)state;
    struct hull *hull;
    struct error error = {0};
    const float center[3] = {0, 0, 0};
    assert_int_equal(hull_allocate(&hull, 3, 1, &error), STATUS_OK);
    hull->part_count = 1;
    hull->parts[0] = (struct hull_part){.kind = HULL_OPAQUE, .count = 1};
    for (int k = 0; k < 3; k++) hull->triangles[0][k] = (uint16_t)k, hull->step[k] = 1e-8f;
    assert_int_equal(hull_check(hull, center, 1, &error), STATUS_OK);
    hull->triangles[0][1] = 3;
    assert_int_equal(hull_check(hull, center, 1, &error), STATUS_INVALID);
    hull->triangles[0][1] = 1;
    hull->parts[0].count = 2;
    assert_int_equal(hull_check(hull, center, 1, &error), STATUS_INVALID);
    hull->parts[0] = (struct hull_part){.kind = HULL_GLASS, .count = 1, .eta = 0};
    assert_int_equal(hull_check(hull, center, 1, &error), STATUS_INVALID);
    hull->parts[0] = (struct hull_part){.kind = HULL_OPAQUE, .count = 1};
    hull->step[0] = 1;
    assert_int_equal(hull_check(hull, center, 1, &error), STATUS_INVALID);
    hull_destroy(hull);
}

// A tessellated sphere: within the tolerance of its points, closed as before, down to the number asked for.
static void simplifying_keeps_a_sphere(void **state) {
    (void)state;
    enum { ROWS = 40, COLUMNS = 80 };
    struct loose_mesh mesh = {.positions = malloc(ROWS * COLUMNS * 6 * sizeof(vec3)),
                              .vertex_part = calloc(ROWS * COLUMNS * 6, sizeof(uint32_t)),
                              .triangles = malloc(ROWS * COLUMNS * 2 * sizeof(uint32_t[3]))};
    for (int y = 0; y < ROWS; y++)
        for (int x = 0; x < COLUMNS; x++)
            for (int k = 0; k < 6; k++) {
                static const int dx[6] = {0, 0, 1, 1, 1, 0}, dy[6] = {0, 1, 1, 1, 0, 0};
                float theta = PI_F * (float)(y + dy[k]) / ROWS,
                      phi = 2 * PI_F * (float)((x + dx[k]) % COLUMNS) / COLUMNS;
                bool pole = y + dy[k] == 0 || y + dy[k] == ROWS;
                vec3 p = pole ? vec3_make(0, 0, y + dy[k] ? -1.0f : 1.0f)
                              : vec3_make(sinf(theta) * cosf(phi), sinf(theta) * sinf(phi), cosf(theta));
                uint32_t at = (uint32_t)mesh.vertex_count++;
                mesh.positions[at] = p;
                if (k % 3 == 2) {
                    uint32_t *v = mesh.triangles[mesh.triangle_count++];
                    v[0] = at - 2, v[1] = at - 1, v[2] = at;
                }
            }
    struct error error = {0};
    const float stiffness[1] = {1};
    assert_int_equal(loose_mesh_join(&mesh, &error), STATUS_OK);
    const struct mesh_limit most = {.vertices = HULL_MAX_VERTICES, .triangles = 1000};
    assert_int_equal(loose_mesh_simplify(&mesh, stiffness, 1e-4f, &most, &error), STATUS_OK);
    assert_true(mesh.triangle_count <= 1000 && mesh.triangle_count >= 990);
    assert_int_equal(mesh.vertex_count, mesh.triangle_count / 2 + 2); // Euler: closed, of genus 0
    double volume = 0;
    for (size_t t = 0; t < mesh.triangle_count; t++) {
        const uint32_t *v = mesh.triangles[t];
        vec3 a = mesh.positions[v[0]], b = mesh.positions[v[1]], c = mesh.positions[v[2]];
        volume += (double)vec3_dot(a, vec3_cross(b, c)) / 6;
        vec3 middle = vec3_scale(vec3_add(a, vec3_add(b, c)), 1.0f / 3);
        assert_true(fabsf(vec3_length(middle) - 1) < 0.02f);
    }
    printf("sphere of %zu triangles: volume %.4f of a ball's\n", mesh.triangle_count, volume / (4 * M_PI / 3));
    assert_true(fabs(fabs(volume) / (4 * M_PI / 3) - 1) < 0.02);
    loose_mesh_fini(&mesh);
}

// Feathers: many pieces of a few triangles each, of which whole ones go. What is left fills the limit of vertices.
static void simplifying_counts_what_is_left(void **state) {
    (void)state;
    enum { STRIPS = 3000, LENGTH = 6 };
    struct loose_mesh mesh = {.positions = malloc(STRIPS * LENGTH * sizeof(vec3)),
                              .vertex_part = calloc(STRIPS * LENGTH, sizeof(uint32_t)),
                              .triangles = malloc(STRIPS * (LENGTH - 2) * sizeof(uint32_t[3]))};
    for (uint32_t i = 0; i < STRIPS; i++) {
        struct sampler s = sampler_make(4, 0, i);
        const vec3 at = vec3_scale(warp_uniform_sphere(sampler_2d(&s)), 10),
                   along = warp_uniform_sphere(sampler_2d(&s));
        const struct frame frame = frame_from_normal(along);
        for (int k = 0; k < LENGTH; k++) // bent, so that every collapse does harm
            mesh.positions[mesh.vertex_count++] =
                vec3_mad(along, 0.1f * (float)k, vec3_mad(k & 1 ? frame.s : frame.t, 0.1f + 0.05f * (float)k, at));
        for (uint32_t k = 0; k + 2 < LENGTH; k++)
            for (uint32_t c = 0; c < 3; c++) {
                if (c == 0) mesh.triangle_count++;
                mesh.triangles[mesh.triangle_count - 1][c] = LENGTH * i + k + (k & 1 ? 2 - c : c);
            }
    }
    struct error error = {0};
    const float stiffness[1] = {1};
    const struct mesh_limit most = {.vertices = 2000, .triangles = 100000};
    assert_int_equal(loose_mesh_simplify(&mesh, stiffness, 1e-5f, &most, &error), STATUS_OK);
    printf("strips: %zu triangles, %zu vertices of at most %zu\n", mesh.triangle_count, mesh.vertex_count,
           most.vertices);
    assert_true(mesh.vertex_count <= most.vertices && mesh.vertex_count > most.vertices - 10);
    loose_mesh_fini(&mesh);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(shows_the_lamp),
                                       cmocka_unit_test(a_box_keeps_its_silhouette),
                                       cmocka_unit_test(small_facets_keep_their_normals),
                                       cmocka_unit_test(normals_are_the_surfaces_own),
                                       cmocka_unit_test(same_for_any_threads_and_from_file),
                                       cmocka_unit_test(bad_hulls_are_refused),
                                       cmocka_unit_test(simplifying_keeps_a_sphere),
                                       cmocka_unit_test(simplifying_counts_what_is_left)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
