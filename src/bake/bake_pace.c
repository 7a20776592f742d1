// How much work a lamp gets. A quality is a fixed amount of it, but particles cost seven times as much in a lamp of a
// million triangles as in one of thirty thousand: above an ordinary cost there are fewer of everything. The cost is a
// model of rays and triangles, not a time, so that the same seed gives the same file. With --seconds it is the time.
#include "bake/bake_job.h"

enum { PILOT = 1 << 14, LEAST_FIELD_LINES = 2000000, MOST_FIELD_LINES = 16000000 };
enum { LEAST_DENSITY_LINES = 4000000 }; // fewer show less than the lamp's exits do
static const double ray_us = 0.55, ray_triangles = 1e5; // of one core; above so many triangles as their square root
static const double learn_us = 4.6, ordinary_us = 10, least_pace = 0.2; // of an exit: to learn from it; in all
static const double survey_time_share = 0.1, evaluation_time_share = 0.1; // of a bake with --seconds
static const double line_us = 1.3; // an untraced line and its query, on one core

static size_t slower(size_t count, double pace) { return count ? (size_t)fmax(1, (double)count * pace) : 0; }

static double ray_cost_us(const struct scene *scene) {
    double triangles = 0;
    for (size_t i = 0; i < scene->shape_count; i++) triangles += (double)scene->shapes[i]->mesh.triangle_count;
    return ray_us * sqrt(fmax(1, triangles / ray_triangles));
}

enum status bake_pace(struct bake_job *job, struct error *error) {
    struct bake_plan *plan = &job->plan;
    struct exit_list exits;
    double start = clock_wall_s();
    enum status status = gather_exits(&exits, &job->lamp, STREAM_SURVEY, 0, PILOT, false, job->run, error);
    if (status != STATUS_OK) return status;
    const double exit_us = (double)exits.rays / fmax(1, (double)exits.count) * ray_cost_us(&job->scene);
    exit_list_fini(&exits);
    job->particle_s = (clock_wall_s() - start) / PILOT;
    struct evaluation_effort *effort = &plan->evaluation;
    const double seconds = job->budget_s;
    if (seconds > 0) {
        const double survey = survey_time_share * seconds / job->particle_s;
        const double particles = evaluation_time_share * seconds / job->particle_s;
        const double lines = 0.5 * evaluation_time_share * seconds / (1e-6 * line_us);
        job->field_lines = (size_t)fmin(LEAST_FIELD_LINES, fmax(lines, PILOT));
        job->most_field_lines = job->field_lines;
        job->density_lines = lines < LEAST_DENSITY_LINES ? 0 : (size_t)fmin((double)plan->density_lines, lines);
        plan->survey_particles = (size_t)fmin((double)plan->survey_particles, fmax(survey, PILOT));
        effort->particles = (size_t)fmin((double)effort->particles, fmax(particles, PILOT));
        effort->lines = (size_t)fmin((double)effort->lines, fmax(lines, PILOT));
        return STATUS_OK;
    }
    const double pace = fmax(least_pace, fmin(1, ordinary_us / (exit_us + learn_us)));
    if (pace < 1)
        run_note(job->run, "light that gets out costs %.0f us to trace: %.0f %% of the usual work", exit_us,
                 100 * pace);
    plan->survey_particles = slower(plan->survey_particles, pace);
    plan->light_chunks = slower(plan->light_chunks, pace);
    plan->view.chunks = slower(plan->view.chunks, pace);
    effort->particles = slower(effort->particles, pace);
    job->field_lines = plan->survey_particles > LEAST_FIELD_LINES ? plan->survey_particles : LEAST_FIELD_LINES;
    job->most_field_lines = MOST_FIELD_LINES;
    job->density_lines = plan->density_lines;
    return STATUS_OK;
}
