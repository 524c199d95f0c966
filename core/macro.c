/* The question of a macro-geometry search (macro.h): defaults, checks, rating. The sampling is macro_sample.c. */
#include "core/macro.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>

#include "core/iso6336.h"

const char *qg_macro_constraint_name(enum qg_macro_constraint constraint) {
#define WORD(name, word, text) word,
    static const char *const words[] = {QG_MACRO_TABLE(WORD)};
#undef WORD
    assert((unsigned)constraint < QG_MACRO_CONSTRAINTS);
    return words[constraint];
}

const char *qg_macro_constraint_text(enum qg_macro_constraint constraint) {
#define TEXT(name, word, text) text,
    static const char *const texts[] = {QG_MACRO_TABLE(TEXT)};
#undef TEXT
    assert((unsigned)constraint < QG_MACRO_CONSTRAINTS);
    return texts[constraint];
}

/* ---- defaults --------------------------------------------------------------------------------------------------- */

static void complete(struct qg_interval *interval, double low, double high) {
    if (isnan(interval->low))
        *interval = (struct qg_interval){low, high};
}

void qg_macro_complete(struct qg_macro *macro, const struct qg_gear_pair *initial, double backlash0) {
    struct qg_macro_ranges *r = &macro->ranges;
    const double m = initial->rack.module, angle = initial->rack.pressure_angle * (180 / M_PI);
    complete(&r->module, 0.5 * m, 1.2 * m);
    complete(&r->pressure_angle_deg, fmax(10, angle - 6), fmin(35, angle + 6));
    for (int i = 0; i < 2; i++) {
        const struct qg_gear *gear = &initial->gears[i];
        complete(&r->gears[i].teeth, fmax(5, ceil(0.6 * gear->teeth)), floor(1.8 * gear->teeth));
        complete(&r->gears[i].profile_shift, -m, m);
        complete(&r->gears[i].outside_radius, gear->outside_radius - m / 2, gear->outside_radius + m / 2);
        complete(&r->gears[i].root_radius, gear->root_radius - m / 4, gear->root_radius + 3 * m / 4);
    }
    complete(&macro->limits.backlash, 0.8 * backlash0, 1.2 * backlash0);
}

/* ---- checks ----------------------------------------------------------------------------------------------------- */

bool qg_macro_ratio_is_kept(double z1, double z2, const struct qg_gear_pair *initial, double ratio_percent) {
    const double z10 = initial->gears[QG_PINION].teeth, z20 = initial->gears[QG_GEAR].teeth;
    return fabs(z2 * z10 - z1 * z20) <= ratio_percent / 100 * (z1 * z20);
}

static void check_interval(const struct qg_interval *interval, const char *where, struct qg_notes *notes) {
    if (!(interval->low <= interval->high))
        qg_notes_add(notes, where, "found [%g, %g], allowed: a lower limit not above the upper one", interval->low,
                     interval->high);
}

static void check_gear(const struct qg_macro *macro, const struct qg_gear_pair *initial, int i,
                       struct qg_notes *notes) {
    const char *name = i == QG_PINION ? "pinion" : "gear";
    const struct {
        const char *member;
        const struct qg_interval *interval;
    } intervals[] = {{"teeth", &macro->ranges.gears[i].teeth},
                     {"profile_shift", &macro->ranges.gears[i].profile_shift},
                     {"outside_radius", &macro->ranges.gears[i].outside_radius},
                     {"root_radius", &macro->ranges.gears[i].root_radius}};
    char where[64];
    for (size_t k = 0; k < sizeof intervals / sizeof *intervals; k++) {
        snprintf(where, sizeof where, "macro.ranges.%s.%s", name, intervals[k].member);
        check_interval(intervals[k].interval, where, notes);
    }
    const double bore = initial->gears[i].bore_diameter / 2, module = macro->ranges.module.low;
    snprintf(where, sizeof where, "macro.ranges.%s.root_radius", name);
    if (macro->ranges.gears[i].root_radius.high < bore + module / 2)
        qg_notes_add(notes, where,
                     "found at most %.4f mm, allowed: a range that reaches beyond %.4f mm, the bore and half the "
                     "smallest module",
                     macro->ranges.gears[i].root_radius.high, bore + module / 2);
}

/* Whether any two tooth numbers keep the ratio; else the nearest two are told. */
static void check_ratio(const struct qg_macro *macro, const struct qg_gear_pair *initial, struct qg_notes *notes) {
    const struct qg_interval *t1 = &macro->ranges.gears[QG_PINION].teeth, *t2 = &macro->ranges.gears[QG_GEAR].teeth;
    const double u0 = (double)initial->gears[QG_GEAR].teeth / initial->gears[QG_PINION].teeth;
    double nearest = INFINITY, at[2] = {0, 0};
    for (double z1 = t1->low; z1 <= t1->high; z1++)
        for (double z2 = t2->low; z2 <= t2->high; z2++) {
            if (qg_macro_ratio_is_kept(z1, z2, initial, macro->limits.ratio_percent))
                return;
            const double off = fabs(z2 / z1 / u0 - 1);
            if (off < nearest) {
                nearest = off;
                at[0] = z1;
                at[1] = z2;
            }
        }
    if (isfinite(nearest)) /* else the ranges themselves are refused */
        qg_notes_add(notes, "macro.ranges",
                     "no tooth numbers within the ranges keep the ratio %.6g to %g %%; the nearest are %g/%g, off by "
                     "%.3g %%",
                     u0, macro->limits.ratio_percent, at[0], at[1], 100 * nearest);
}

enum qg_status qg_macro_check(const struct qg_macro *macro, const struct qg_gear_pair *initial,
                              const struct qg_pair_geometry *geometry, struct qg_notes *notes) {
    struct qg_notes own = {0};
    if (!notes)
        notes = &own;
    const size_t before = notes->count + notes->lost;
    check_interval(&macro->ranges.module, "macro.ranges.module", notes);
    check_interval(&macro->ranges.pressure_angle_deg, "macro.ranges.pressure_angle", notes);
    for (int i = 0; i < 2; i++)
        check_gear(macro, initial, i, notes);
    check_ratio(macro, initial, notes);
    check_interval(&macro->limits.backlash, "macro.constraints.backlash", notes);
    struct qg_macro_rating rating;
    if (qg_macro_rate(initial, geometry, &rating) != QG_OK)
        qg_notes_add(notes, "macro",
                     "the formulas of ISO 6336 have no value for the initial pair, so no other can be compared with "
                     "it; allowed: a pair with a fillet that a 30 degree tangent touches");
    return notes->count + notes->lost == before ? QG_OK : QG_IMPOSSIBLE_GEAR;
}

/* ---- rating ----------------------------------------------------------------------------------------------------- */

enum qg_status qg_macro_rate(const struct qg_gear_pair *pair, const struct qg_pair_geometry *geometry,
                             struct qg_macro_rating *out) {
    struct qg_iso6336 iso;
    const enum qg_status status = qg_iso6336_rate(pair, geometry, pair->nominal_torque, &iso);
    if (status != QG_OK)
        return status;
    out->contact_stress = fmax(iso.contact_stress[QG_PINION], iso.contact_stress[QG_GEAR]);
    out->root_stress = fmax(iso.root_stress[QG_PINION], iso.root_stress[QG_GEAR]);
    return isfinite(out->contact_stress) && isfinite(out->root_stress) ? QG_OK : QG_NO_CONVERGENCE;
}
