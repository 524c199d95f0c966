/* The progress bar.
 *
 * Time left: steps cost about the same once the finite elements are done, so it is the time per step since then, times the
 * steps that remain. It is said only when a second has passed and a step was done.
 */
#include "cli/progress.h"

#include <assert.h>
#include <math.h>
#include <time.h>

#include "schema/result.h"

enum { BAR_WIDTH = 24 };

double qg_monotonic_seconds(void *self) {
    struct timespec now;
    (void)self;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

void qg_bar_init(struct qg_bar *bar, FILE *out) {
    const double now = qg_monotonic_seconds(NULL);
    *bar = (struct qg_bar){.out = out, .start = now, .steady = now, .drawn = -INFINITY};
}

/* "3:05" or "1:02:05". */
static void print_duration(FILE *out, double seconds) {
    const long s = lround(seconds);
    if (s >= 3600)
        fprintf(out, "%ld:%02ld:%02ld", s / 3600, s / 60 % 60, s % 60);
    else
        fprintf(out, "%ld:%02ld", s / 60, s % 60);
}

static void draw(const struct qg_bar *bar, const struct qg_progress *progress, enum qg_objective objective) {
    static const char full[] = "########################", none[] = "........................";
    const double share = progress->total ? (double)progress->done / (double)progress->total : 0;
    const int filled = (int)(share * BAR_WIDTH);
    fprintf(bar->out, "\r\033[K%-11s [%.*s%.*s] %3d %%", qg_phase_name(progress->phase), filled, full,
            BAR_WIDTH - filled, none, (int)(100 * share));
    const double elapsed = bar->drawn - bar->steady;
    if (elapsed > 1 && progress->done > bar->steady_done && progress->total >= progress->done) {
        fputs("  left ", bar->out);
        print_duration(bar->out, elapsed * (double)(progress->total - progress->done) /
                                     (double)(progress->done - bar->steady_done));
    }
    if (progress->has_best)
        fprintf(bar->out, "  best %.4g%s", qg_objective_at_the_edge(objective, progress->best),
                objective == QG_OBJECTIVE_F_PPS ? " um" : "");
    fflush(bar->out);
}

void qg_bar_update(struct qg_bar *bar, const struct qg_progress *progress, enum qg_objective objective) {
    static_assert(BAR_WIDTH == 24, "as long as the strings in draw");
    if (!bar->out)
        return;
    const double now = qg_monotonic_seconds(NULL);
    if (progress->phase <= QG_PHASE_REFERENCE) {
        bar->steady = now;
        bar->steady_done = progress->done;
    }
    if (bar->shown && now - bar->drawn < 0.1)
        return;
    bar->drawn = now;
    bar->shown = true;
    draw(bar, progress, objective);
}

void qg_bar_finish(struct qg_bar *bar) {
    if (bar->out && bar->shown)
        fputs("\r\033[K", bar->out);
    bar->shown = false;
}
