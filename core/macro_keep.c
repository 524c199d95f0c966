/* Keeping the best and the front of a macro-geometry search (macro_keep.h): two sorted arrays. */
#include "core/macro_keep.h"

#include <assert.h>
#include <math.h>
#include <string.h>

double qg_macro_stress(const struct qg_macro_point *point) {
    return fmax(point->contact_stress, point->root_stress);
}

void qg_macro_tally_init(struct qg_macro_tally *tally, size_t keep) {
    assert(keep >= 1 && keep <= QG_MACRO_KEEP_MAX);
    memset(tally, 0, sizeof *tally);
    tally->keep = keep;
}

/* The order of all lists here. */
static bool comes_before(const struct qg_macro_point *a, const struct qg_macro_point *b) {
    return a->contact_ratio > b->contact_ratio || (a->contact_ratio == b->contact_ratio && a->sample < b->sample);
}

static bool dominates(const struct qg_macro_point *a, const struct qg_macro_point *b) {
    const double sa = qg_macro_stress(a), sb = qg_macro_stress(b);
    return a->contact_ratio >= b->contact_ratio && sa <= sb && (a->contact_ratio > b->contact_ratio || sa < sb);
}

static bool is_same_geometry(const struct qg_macro_point *a, const struct qg_macro_point *b) {
    for (int i = 0; i < QG_MACRO_PARAMETERS; i++)
        if (a->parameter[i] != b->parameter[i])
            return false;
    return true;
}

static bool has_geometry(const struct qg_macro_point *list, size_t n, const struct qg_macro_point *point) {
    for (size_t i = 0; i < n; i++)
        if (is_same_geometry(&list[i], point))
            return true;
    return false;
}

static void add_to_best(struct qg_macro_tally *t, const struct qg_macro_point *point) {
    size_t at = t->best_count;
    if (at == t->keep && !comes_before(point, &t->best[at - 1]))
        return;
    if (has_geometry(t->best, t->best_count, point))
        return;
    if (at < t->keep)
        t->best_count++;
    else
        at--;
    for (; at > 0 && comes_before(point, &t->best[at - 1]); at--)
        t->best[at] = t->best[at - 1];
    t->best[at] = *point;
}

/* Makes room on a full front. */
static void drop_from_front(struct qg_macro_tally *t) {
    size_t drop = 1;
    for (size_t i = 1; i + 1 < t->front_count; i++)
        if (t->front[i - 1].contact_ratio - t->front[i + 1].contact_ratio <
            t->front[drop - 1].contact_ratio - t->front[drop + 1].contact_ratio)
            drop = i;
    t->front_count--;
    memmove(t->front + drop, t->front + drop + 1, (t->front_count - drop) * sizeof *t->front);
    t->front_dropped++;
}

static void add_to_front(struct qg_macro_tally *t, const struct qg_macro_point *point) {
    size_t kept = 0, at = 0;
    for (size_t i = 0; i < t->front_count; i++)
        if (dominates(&t->front[i], point) || is_same_geometry(&t->front[i], point))
            return;
    for (size_t i = 0; i < t->front_count; i++)
        if (!dominates(point, &t->front[i]))
            t->front[kept++] = t->front[i];
    t->front_count = kept;
    if (t->front_count == QG_MACRO_FRONT_ROOM)
        drop_from_front(t);
    while (at < t->front_count && comes_before(&t->front[at], point))
        at++;
    memmove(t->front + at + 1, t->front + at, (t->front_count - at) * sizeof *t->front);
    t->front[at] = *point;
    t->front_count++;
}

void qg_macro_tally_add(struct qg_macro_tally *tally, const struct qg_macro_point *point) {
    tally->samples++;
    tally->passed++;
    add_to_best(tally, point);
    add_to_front(tally, point);
}

void qg_macro_tally_merge(struct qg_macro_tally *tally, const struct qg_macro_tally *later) {
    assert(tally->keep == later->keep);
    tally->samples += later->samples;
    tally->passed += later->passed;
    for (int i = 0; i < QG_MACRO_CONSTRAINTS; i++)
        tally->rejected[i] += later->rejected[i];
    for (size_t i = 0; i < later->best_count; i++)
        add_to_best(tally, &later->best[i]);
    for (size_t i = 0; i < later->front_count; i++)
        add_to_front(tally, &later->front[i]);
    tally->front_dropped += later->front_dropped;
}

static size_t place_of(const struct qg_macro_point *points, size_t n, uint64_t sample) {
    size_t i = 0;
    while (i < n && points[i].sample != sample)
        i++;
    return i;
}

size_t qg_macro_tally_choose(const struct qg_macro_tally *tally, struct qg_macro_point *out, bool *on_front,
                             bool *among_best) {
    const size_t front = tally->front_count < tally->keep ? tally->front_count : tally->keep;
    struct qg_macro_point chosen[2 * QG_MACRO_KEEP_MAX];
    size_t n = tally->best_count;
    memcpy(chosen, tally->best, n * sizeof *chosen);
    for (size_t i = 0; i < front; i++) {
        const size_t at = front == tally->front_count ? i : front == 1 ? 0 : i * (tally->front_count - 1) / (front - 1);
        if (place_of(chosen, n, tally->front[at].sample) == n)
            chosen[n++] = tally->front[at];
    }
    for (size_t i = 0; i < n; i++) { /* insertion sort */
        size_t at = i;
        for (; at > 0 && comes_before(&chosen[i], &out[at - 1]); at--)
            out[at] = out[at - 1];
        out[at] = chosen[i];
    }
    for (size_t i = 0; i < n; i++) {
        on_front[i] = place_of(tally->front, tally->front_count, out[i].sample) < tally->front_count;
        among_best[i] = place_of(tally->best, tally->best_count, out[i].sample) < tally->best_count;
    }
    return n;
}
