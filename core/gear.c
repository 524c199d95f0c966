/* Geometry of one hob-cut involute gear.
 *
 * The rack (hob) rolls on the reference circle. Its tip rounding of radius rho has its centre at depth d below the rolling
 * line and at distance c from the axis of the rack's tooth. At the moment when the rounding cuts with its normal at angle
 * theta below the rolling line, that normal passes through the pitch point (law of gearing), so the centre stands at
 * (d / tan theta, -d) from the pitch point and the point cut lies rho further along the normal. theta = pi/2 is the bottom of
 * the space, theta = alpha the hand-over to the rack's straight flank, hence the form point, where root curve and involute
 * share position and tangent. With f = d + rho sin alpha, the depth of that hand-over,
 *     r_form^2 = r_b^2 + (r sin alpha - f / sin alpha)^2,
 * and a negative bracket means that the hob cuts away involute again: undercut.
 */
#include "core/gear.h"

#include <math.h>
#include <stdbool.h>
#include <stdio.h>

double qg_involute(double angle) {
    return tan(angle) - angle;
}

double qg_half_tooth_angle(const struct qg_rack *rack, const struct qg_gear_geometry *gear, double radius) {
    double pressure_angle = acos(fmin(1, gear->base_radius / radius));
    return gear->tooth_thickness / (2 * gear->reference_radius) + qg_involute(rack->pressure_angle) -
           qg_involute(pressure_angle);
}

struct qg_polar qg_trochoid_point(const struct qg_rack *rack, const struct qg_gear *gear,
                                  const struct qg_gear_geometry *geometry, double parameter) {
    double theta = M_PI_2 - parameter * (M_PI_2 - rack->pressure_angle);
    double r = geometry->reference_radius;
    double center_x = geometry->hob_tip_center_depth / tan(theta);
    double x = center_x + gear->hob_tip_radius * cos(theta);
    double y = r - geometry->hob_tip_center_depth - gear->hob_tip_radius * sin(theta);
    double rolled = (center_x - geometry->hob_tip_center_offset) / r;
    return (struct qg_polar){.radius = hypot(x, y), .angle = M_PI / gear->teeth - atan2(x, y) + rolled};
}

/* Where a fault is: prefix + member. */
struct place {
    char text[64];
};

static struct place place(const char *prefix, const char *member) {
    struct place p;
    snprintf(p.text, sizeof p.text, "%s%s", prefix, member);
    return p;
}

/* True when all figures are finite and positive enough to compute with. */
static bool figures_are_usable(const struct qg_gear *gear, const char *prefix, struct qg_notes *notes) {
    const struct {
        const char *member;
        double value;
        bool may_be_zero;
    } figures[] = {
        {"outside_radius", gear->outside_radius, false}, {"root_radius", gear->root_radius, false},
        {"hob_tip_radius", gear->hob_tip_radius, true},  {"bore_diameter", gear->bore_diameter, false},
        {"face_width", gear->face_width, false},         {"moment_of_inertia", gear->moment_of_inertia, true},
    };
    size_t before = notes->count + notes->lost;
    for (size_t i = 0; i < sizeof figures / sizeof *figures; i++)
        if (!isfinite(figures[i].value) || figures[i].value < 0 || (figures[i].value == 0 && !figures[i].may_be_zero))
            qg_notes_add(notes, place(prefix, figures[i].member).text, "found %g, allowed: %s", figures[i].value,
                         figures[i].may_be_zero ? "0 or more" : "more than 0");
    if (!isfinite(gear->profile_shift))
        qg_notes_add(notes, place(prefix, "profile_shift").text, "found %g, allowed: a finite number",
                     gear->profile_shift);
    if (gear->teeth < 5)
        qg_notes_add(notes, place(prefix, "teeth").text, "found %d, allowed: 5 or more", gear->teeth);
    return notes->count + notes->lost == before;
}

/* Hob and root: rounding that fits, no undercut. */
static void check_root(const struct qg_rack *rack, const struct qg_gear *gear, const struct qg_gear_geometry *g,
                       const char *prefix, struct qg_notes *notes) {
    if (g->hob_addendum <= 0)
        qg_notes_add(notes, place(prefix, "root_radius").text,
                     "the hob would not reach into the gear: its addendum would be %.4f mm; the root radius must lie "
                     "below %.4f mm (reference radius plus profile shift), found %.4f mm",
                     g->hob_addendum, g->reference_radius + gear->profile_shift, gear->root_radius);
    double widest = (M_PI * rack->module / 4 - g->hob_addendum * tan(rack->pressure_angle)) *
                    cos(rack->pressure_angle) / (1 - sin(rack->pressure_angle));
    if (g->hob_tip_center_offset < 0)
        qg_notes_add(notes, place(prefix, "hob_tip_radius").text,
                     "a hob tip of radius %.4f mm does not fit the space of a hob tooth of addendum %.4f mm; at most "
                     "%.4f mm fits",
                     gear->hob_tip_radius, g->hob_addendum, fmax(0, widest));
    double sine = sin(rack->pressure_angle);
    double cut_depth = g->hob_tip_center_depth + gear->hob_tip_radius * sine;
    double remaining = g->reference_radius * sine - cut_depth / sine;
    if (remaining < 0)
        qg_notes_add(notes, place(prefix, "root_radius").text,
                     "undercut: the hob's straight flank ends %.4f mm below the rolling line, more than the %.4f mm "
                     "that keep the involute whole; raise the root radius or the profile shift",
                     cut_depth, g->reference_radius * sine * sine);
}

/* Radii in order, tooth not pointed. */
static void check_tooth(const struct qg_rack *rack, const struct qg_gear *gear, const struct qg_gear_geometry *g,
                        const char *prefix, struct qg_notes *notes) {
    if (gear->outside_radius <= fmax(g->form_radius, gear->root_radius))
        qg_notes_add(notes, place(prefix, "outside_radius").text,
                     "found %.4f mm, must be above the form radius %.4f mm, where the involute begins, and the root "
                     "radius %.4f mm",
                     gear->outside_radius, g->form_radius, gear->root_radius);
    else if (g->tip_thickness <= 0)
        qg_notes_add(notes, place(prefix, "outside_radius").text,
                     "pointed tooth: at %.4f mm the tip would be %.4f mm thick; lower the outside radius or the "
                     "profile shift",
                     gear->outside_radius, g->tip_thickness);
    if (gear->bore_diameter / 2 > gear->root_radius - rack->module / 2)
        qg_notes_add(notes, place(prefix, "bore_diameter").text,
                     "found %.4f mm, allowed: at most %.4f mm, which leaves half a module of rim below the root circle",
                     gear->bore_diameter, 2 * gear->root_radius - rack->module);
}

/* Hollow disc from the bore to the base circle, over the face width: the convention of the 2011 paper. */
static double disc_inertia(const struct qg_gear *gear, double base_radius, double density) {
    double bore = gear->bore_diameter / 2;
    return M_PI_2 * density * gear->face_width * (pow(base_radius, 4) - pow(bore, 4));
}

enum qg_status qg_gear_derive(const struct qg_rack *rack, const struct qg_gear *gear, double density,
                              const char *prefix, struct qg_gear_geometry *out, struct qg_notes *notes) {
    struct qg_notes mine = {0};
    if (!notes)
        notes = &mine;
    size_t before = notes->count + notes->lost;
    *out = (struct qg_gear_geometry){0};
    if (!figures_are_usable(gear, prefix, notes))
        return QG_IMPOSSIBLE_GEAR;

    double m = rack->module, alpha = rack->pressure_angle, rho = gear->hob_tip_radius;
    double r = m * gear->teeth / 2;
    out->reference_radius = r;
    out->base_radius = r * cos(alpha);
    out->base_pitch = M_PI * m * cos(alpha);
    out->tooth_thickness = M_PI * m / 2 + 2 * gear->profile_shift * tan(alpha);
    out->hob_addendum = r + gear->profile_shift - gear->root_radius;
    out->hob_tip_center_depth = r - gear->root_radius - rho;
    out->hob_tip_center_offset = M_PI * m / 4 - (out->hob_addendum - rho) * tan(alpha) - rho / cos(alpha);
    double remaining = r * sin(alpha) - (out->hob_tip_center_depth + rho * sin(alpha)) / sin(alpha);
    out->form_radius = hypot(out->base_radius, remaining);
    out->tip_thickness = 2 * gear->outside_radius * qg_half_tooth_angle(rack, out, gear->outside_radius);
    out->moment_of_inertia =
        gear->moment_of_inertia > 0 ? gear->moment_of_inertia : disc_inertia(gear, out->base_radius, density);

    check_root(rack, gear, out, prefix, notes);
    check_tooth(rack, gear, out, prefix, notes);
    if (out->moment_of_inertia <= 0)
        qg_notes_add(notes, place(prefix, "bore_diameter").text,
                     "the bore reaches beyond the base radius %.4f mm: a disc between them has no inertia; give "
                     "moment_of_inertia or a smaller bore",
                     out->base_radius);
    return notes->count + notes->lost == before ? QG_OK : QG_IMPOSSIBLE_GEAR;
}
