/* Rating of a spur gear pair by the formulas of ISO 6336:2006, for a line beside the finite elements: contact stress (part 2),
 * tooth-root stress (part 3), tooth and mesh stiffness (part 1, method B).
 *
 * These are nominal figures of a gear pair without reliefs: all general factors (application K_A, dynamics K_V, face load
 * K_Hbeta and K_Fbeta, transverse load K_Halpha and K_Falpha) are 1, both helix factors Z_beta and Y_beta are 1 (spur
 * gears), both gears are of one material. Reliefs do not enter. The basic rack is the hob: dedendum h_fP = hob addendum,
 * tip rounding rho_fP, no protuberance, one per gear.
 *
 * All functions are pure, allocate nothing, and cost about a microsecond.
 */
#ifndef QG_CORE_ISO6336_H
#define QG_CORE_ISO6336_H

#include <stdbool.h>

#include "core/pair.h"

/* One tooth as part 3 wants it; lengths in modules. */
struct qg_iso6336_tooth {
    double teeth;          /* z, > 0 */
    double pressure_angle; /* rad */
    double profile_shift;  /* x */
    double dedendum;       /* h_fP of the rack */
    double tip_rounding;   /* rho_fP of the rack */
    double outside_radius; /* r_a */
    double contact_ratio;  /* eps_alpha of the pair */
};

/* The critical section, where the 30 degree tangent touches the fillet, with the load at the outer point of single contact;
 * lengths in modules. */
struct qg_iso6336_root {
    double chord;                    /* s_Fn */
    double fillet_radius;            /* rho_F */
    double load_arm;                 /* h_Fe, of the load's cut with the tooth's centre line above the chord */
    double load_angle;               /* rad, alpha_Fen, of the load against the chord */
    double load_radius;              /* d_en / 2 */
    double form_factor;              /* Y_F */
    double stress_correction_factor; /* Y_S */
    double notch_parameter;          /* q_s = s_Fn / (2 rho_F); Y_S was fitted for 1 <= q_s < 8 */
};

/* Form factor Y_F and stress correction factor Y_S by method B of ISO 6336-3:2006, clauses 6.2 and 7.2:
 *     G = rho_fP - h_fP + x,  E = pi/4 - h_fP tan a - (1 - sin a) rho_fP / cos a,  H = 2/z (pi/2 - E) - pi/3,
 *     theta = 2G/z tan theta - H,
 *     s_Fn = z sin(pi/3 - theta) + sqrt 3 (G/cos theta - rho_fP),
 *     rho_F = rho_fP + 2 G^2 / (cos theta (z cos^2 theta - 2G)),
 *     r_e^2 = (sqrt(r_a^2 - r_b^2) - pi cos a (eps - 1))^2 + r_b^2,  cos a_e = r_b/r_e,
 *     gamma_e = (pi/2 + 2 x tan a)/z + inv a - inv a_e,  a_Fe = a_e - gamma_e,
 *     h_Fe = [(cos gamma_e - sin gamma_e tan a_Fe) 2 r_e - z cos(pi/3 - theta) - G/cos theta + rho_fP] / 2,
 *     Y_F = 6 h_Fe cos a_Fe / (s_Fn^2 cos a),  Y_S = (1.2 + 0.13 L) q_s^(1/(1.21 + 2.3/L)),  L = s_Fn/h_Fe.
 * From a contact ratio of 2 on no tooth carries alone; the standard keeps the load at the same point, (eps - 1) base pitches
 * before the tip, and lowers the stress by the deep tooth factor (below).
 * QG_NO_CONVERGENCE when the formulas have no value for such a tooth (no 30 degree tangent, load below the critical
 * section, undercut down to a point); *out is then undefined. */
enum qg_status qg_iso6336_root_factors(const struct qg_iso6336_tooth *tooth, struct qg_iso6336_root *out);

/* Deep tooth factor Y_DT of ISO 6336-3:2006, clause 9, for accurate gears with profile modifications: 1 up to a contact
 * ratio of 2.05, then 2.366 - 0.666 eps, 0.7 from 2.5 on. It is the factor of accuracy grades 1 to 4: general factors of 1
 * suppose no less. */
double qg_iso6336_deep_tooth_factor(double contact_ratio);

/* Theoretical single stiffness and mesh stiffness (part 1, clause 9.3). */
struct qg_iso6336_stiffness {
    double flexibility;      /* mm um/N, q' */
    double theoretical;      /* N/(mm um), c'_th = 1/q' */
    double single;           /* N/(mm um), c' = c'_th C_M C_R C_B E/206000 */
    double mesh;             /* N/(mm um), c_gamma_alpha = c' (0.75 eps_alpha + 0.25) */
    double rack_factor;      /* C_B */
    double specific_loading; /* N/mm, F_t/b; below 100 single is lowered by its fourth root over 100 */
};

/* Tooth stiffness of a pair; arrays are [pinion, gear].
 *     q' = 0.04723 + 0.15551/z1 + 0.25791/z2 - 0.00635 x1 - 0.11654 x1/z1 - 0.00193 x2 - 0.24188 x2/z2
 *          + 0.00529 x1^2 + 0.00182 x2^2,
 *     C_M = 0.8, C_R = 1 (solid discs), C_B = mean over both gears of (1 + (1.2 - h_fP)/2) (1 - 0.02 (20 - a in degrees)).
 * tooth[].contact_ratio is read from the pinion's. specific_loading F_t/b in N/mm, youngs_modulus in MPa. Fitted by the
 * standard for x1 >= x2 and -0.5 <= x1 + x2 <= 2 (QG_ISO6336_SHIFTS). */
struct qg_iso6336_stiffness qg_iso6336_stiffness(const struct qg_iso6336_tooth tooth[2], double specific_loading,
                                                 double youngs_modulus);

/* Where the standard gives ranges for its formulas: enum, name, what is then beyond its range. Figures are computed all the
 * same. Sources: part 1, clause 9.3 (stiffness); scopes of parts 2 and 3 (contact ratio); part 3, clauses 7.2 (q_s) and
 * 8.2 (rim). */
#define QG_ISO6336_RANGE_TABLE(X)                                                                                      \
    X(QG_ISO6336_SHIFTS, "profile_shifts",                                                                             \
      "tooth and mesh stiffness: the formula was fitted for x1 >= x2 and -0.5 <= x1 + x2 <= 2")                        \
    X(QG_ISO6336_SHORT_CONTACT, "short_contact", "mesh stiffness: meant for contact ratios from 1.2 on")               \
    X(QG_ISO6336_LONG_CONTACT, "long_contact", "contact and root stress: meant for contact ratios below 2.5")          \
    X(QG_ISO6336_NOTCH, "notch", "root stress: Y_S was fitted for notch parameters q_s from 1 to 8")                   \
    X(QG_ISO6336_THIN_RIM, "thin_rim", "root stress: Y_B is meant for rims of more than half the tooth depth")

#define QG_ISO6336_NAME(name, word, text) name,
enum qg_iso6336_range { QG_ISO6336_RANGE_TABLE(QG_ISO6336_NAME) QG_ISO6336_RANGES };
#undef QG_ISO6336_NAME

/* The table's name of a range ("profile_shifts", ...) and its words for what lies beyond it. */
const char *qg_iso6336_range_name(enum qg_iso6336_range range);
const char *qg_iso6336_range_text(enum qg_iso6336_range range);

/* Everything about a pair. */
struct qg_iso6336 {
    double tangential_force;         /* N, F_t = 2 T/d at the reference circle */
    double nominal_contact_stress;   /* MPa, sigma_H0 at the pitch point */
    double contact_stress[2];        /* MPa, sigma_H = Z_B sigma_H0 on the pinion, Z_D sigma_H0 on the gear */
    double root_stress[2];           /* MPa, sigma_F = F_t/(b m) Y_F Y_S Y_B Y_DT */
    double root_face_width[2];       /* mm, b of root_stress */
    double zone_factor;              /* Z_H */
    double elasticity_factor;        /* sqrt MPa, Z_E */
    double contact_ratio_factor;     /* Z_eps */
    double single_contact_factor[2]; /* Z_B, Z_D */
    double rim_factor[2];            /* Y_B */
    double deep_tooth_factor;        /* Y_DT */
    struct qg_iso6336_root root[2];
    struct qg_iso6336_stiffness stiffness;
    bool is_beyond[QG_ISO6336_RANGES]; /* whether the pair lies outside of that range */
};

/* Rates a pair under `torque` (N mm, on the pinion, > 0). pair must have passed qg_pair_derive, which filled geometry.
 *
 * Contact (ISO 6336-2:2006): sigma_H0 = Z_H Z_E Z_eps sqrt(F_t/(d1 b) (u + 1)/u), b the smaller face width,
 *     Z_H = sqrt(2 cos a_w / (cos^2 a sin a_w)),  Z_E = sqrt(E / (2 pi (1 - nu^2))),  Z_eps = sqrt((4 - eps)/3),
 *     Z_B = max(1, M1),  M1 = tan a_w / sqrt((sqrt(d_a1^2/d_b1^2 - 1) - n 2pi/z1) (sqrt(d_a2^2/d_b2^2 - 1) - (eps - n) 2pi/z2)),
 * Z_D with the gears exchanged. n = 1 puts the load at the inner point of single contact; from a contact ratio of 2 on the
 * standard wants the inner point of double contact, n = 2. Z_eps is kept at its value for 3 beyond it; the
 * standard's own range ends at 2.5.
 *
 * Root (ISO 6336-3:2006): b is the gear's own face width, at most the smaller one plus a module on each side;
 *     Y_B = 1, below a rim of s_R = 1.2 h_t: 1.6 ln(2.242 h_t/s_R), s_R from bore to root circle, h_t the tooth depth.
 * The standard does without rims below 0.5 h_t; the formula is then carried on.
 * QG_NO_CONVERGENCE: see qg_iso6336_root_factors. */
enum qg_status qg_iso6336_rate(const struct qg_gear_pair *pair, const struct qg_pair_geometry *geometry, double torque,
                               struct qg_iso6336 *out);

#endif
