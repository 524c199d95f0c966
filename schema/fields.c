/* The table of the job document (fields.h), and the mapping from core's names to JSON pointers that it carries.
 *
 * Units: lengths are millimetres on both sides. The figures that core holds in other units (angle, density, torque) lie in
 * struct qg_given here; read.c converts them, in one function. Ranges are those of sensible machines: they keep typing
 * errors out. What a gear pair allows beyond them, core says.
 */
#include "schema/fields.h"

#include <assert.h>
#include <string.h>

#include "schema/faults.h"

static_assert(sizeof(enum qg_plane) == sizeof(int), "choices are written through int");

#define AT(member) .offset = offsetof(OWNER, member)
#define FORM(name)                                                                                                     \
    const struct qg_form name = {.fields = name##_fields, .count = sizeof name##_fields / sizeof *name##_fields}
#define NUMBER(key_, where_, member, low_, high_)                                                                      \
    .key = (key_), .where = (where_), .type = QG_FIELD_NUMBER, AT(member), .low = (low_), .high = (high_)
#define COUNTED(type_, key_, where_, member, low_, high_)                                                              \
    .key = (key_), .where = (where_), .type = (type_), AT(member), .low = (low_), .high = (high_)
#define REQUIRED .need = QG_NEED_REQUIRED
#define DEFAULT(value) .need = QG_NEED_DEFAULT, .fallback = (value)
#define OPTIONAL .need = QG_NEED_NOTHING
#define OBJECT(key_, where_, form_) .key = (key_), .where = (where_), .type = QG_FIELD_OBJECT, .form = &(form_)
#define CHOICE(key_, where_, member, choices_)                                                                         \
    .key = (key_), .where = (where_), .type = QG_FIELD_CHOICE, AT(member), .choices = (choices_)
#define TEXT(key_, member)                                                                                             \
    .key = (key_), .where = (key_), .type = QG_FIELD_TEXT, AT(member), .high = QG_NAME_MAX, OPTIONAL

static const double largest_seed = 9007199254740991; /* 2^53 - 1: what every JSON reader holds exactly */

/* Gear pair */

#define OWNER struct qg_gear
static const struct qg_field gear_form_fields[] = {
    {COUNTED(QG_FIELD_INT, "teeth", "teeth", teeth, 5, 1000), REQUIRED},
    {NUMBER("profile_shift_mm", "profile_shift", profile_shift, -200, 200), REQUIRED},
    {NUMBER("outside_radius_mm", "outside_radius", outside_radius, 0.1, 20000), REQUIRED},
    {NUMBER("root_radius_mm", "root_radius", root_radius, 0.1, 20000), REQUIRED},
    {NUMBER("hob_tip_radius_mm", "hob_tip_radius", hob_tip_radius, 0, 100), REQUIRED},
    {NUMBER("bore_diameter_mm", "bore_diameter", bore_diameter, 0.1, 20000), REQUIRED},
    {NUMBER("face_width_mm", "face_width", face_width, 0.1, 2000), REQUIRED},
    {NUMBER("moment_of_inertia_kg_mm2", "moment_of_inertia", moment_of_inertia, 1e-6, 1e12), OPTIONAL},
};
static FORM(gear_form);
#undef OWNER

#define OWNER struct qg_job
static const struct qg_field material_form_fields[] = {
    {NUMBER("youngs_modulus_mpa", "youngs_modulus", study.pair.material.youngs_modulus, 100, 1e6), REQUIRED},
    {NUMBER("poisson_ratio", "poisson_ratio", study.pair.material.poisson_ratio, 0, 0.49), REQUIRED},
    {NUMBER("density_kg_per_m3", "density", given.density_kg_per_m3, 100, 30000), REQUIRED},
};
static FORM(material_form);

static const struct qg_field pair_form_fields[] = {
    {TEXT("name", pair_name)},
    {NUMBER("module_mm", "module", study.pair.rack.module, 0.05, 100), REQUIRED},
    {NUMBER("pressure_angle_deg", "pressure_angle", given.pressure_angle_deg, 10, 35), REQUIRED},
    {NUMBER("center_distance_mm", "center_distance", study.pair.center_distance, 0.5, 20000), REQUIRED},
    {OBJECT("pinion", "pinion", gear_form), AT(study.pair.gears[QG_PINION]), REQUIRED},
    {OBJECT("gear", "gear", gear_form), AT(study.pair.gears[QG_GEAR]), REQUIRED},
    {OBJECT("material", "material", material_form), REQUIRED},
    {NUMBER("damping_ratio", "damping_ratio", study.pair.damping_ratio, 0.001, 0.5), REQUIRED},
    {NUMBER("nominal_torque_nm", "nominal_torque", given.nominal_torque_nm, 0.001, 1e7), REQUIRED},
};
static FORM(pair_form);
#undef OWNER

#define OWNER struct qg_load_case
static const struct qg_field qg_load_case_form_fields[] = {
    {NUMBER("torque_fraction", "", torque_fraction, 0.001, 10), OPTIONAL},
    {NUMBER("torque_nm", "", torque_nm, 1e-6, 1e8), OPTIONAL},
};
FORM(qg_load_case_form);
#undef OWNER

/* Relief: one ramp each for tip and root, the same struct under two names of its radius. */

#define OWNER struct qg_ramp
#define RAMP_FORM(name, radius_key, radius_where)                                                                      \
    static const struct qg_field name##_fields[] = {                                                                   \
        {NUMBER(radius_key, radius_where, radius, 0.1, 20000), REQUIRED},                                              \
        {NUMBER("amplitude_mm", "amplitude", amplitude, 0, 1), REQUIRED},                                              \
    };                                                                                                                 \
    static const struct qg_form name = {                                                                               \
        .fields = name##_fields, .count = 2, .has_presence = true, .presence = offsetof(struct qg_ramp, present)}
RAMP_FORM(tip_form, "start_radius_mm", "start_radius");
RAMP_FORM(root_form, "end_radius_mm", "end_radius");
#undef OWNER

#define OWNER struct qg_relief
#define GEAR_RELIEF_FORM(name, i)                                                                                      \
    static const struct qg_field name##_fields[] = {                                                                   \
        {OBJECT("tip", "tip", tip_form), AT(gears[i].tip), OPTIONAL},                                                  \
        {OBJECT("root", "root", root_form), AT(gears[i].root), OPTIONAL},                                              \
    };                                                                                                                 \
    static FORM(name)
GEAR_RELIEF_FORM(pinion_relief_form, QG_PINION);
GEAR_RELIEF_FORM(gear_relief_form, QG_GEAR);

static const char *const shapes[] = {[QG_SHAPE_LINEAR] = "linear", [QG_SHAPE_PARABOLIC] = "parabolic", NULL};
static const char *const ramps[] = {[QG_RAMP_RADIUS] = "radius", [QG_RAMP_ROLL_ANGLE] = "roll_angle", NULL};
static const struct qg_field relief_form_fields[] = {
    {CHOICE("shape", "shape", shape, shapes), DEFAULT(QG_SHAPE_LINEAR)},
    {CHOICE("ramp", "ramp", ramp, ramps), DEFAULT(QG_RAMP_RADIUS)},
    {OBJECT("pinion", "pinion", pinion_relief_form), OPTIONAL},
    {OBJECT("gear", "gear", gear_relief_form), OPTIONAL},
};
static FORM(relief_form);
#undef OWNER

/* Analysis: all of it lies in struct qg_analysis, whatever object of the document it is in. */

static const char *const planes[] = {[QG_PLANE_STRESS] = "stress", [QG_PLANE_STRAIN] = "strain", NULL};
static const char *const bores[] = {[QG_BORE_TORQUE_RING] = "torque_ring", [QG_BORE_CLAMPED] = "clamped", NULL};
static const char *const stiffnesses[] = {[QG_STIFFNESS_SECANT] = "secant",
                                          [QG_STIFFNESS_CONSISTENT] = "consistent",
                                          [QG_STIFFNESS_LOAD_DEPENDENT] = "load_dependent",
                                          NULL};
static const char *const branches[] = {[QG_BRANCH_FIXED] = "fixed",
                                       [QG_BRANCH_RUN_UP] = "run_up",
                                       [QG_BRANCH_RUN_DOWN] = "run_down",
                                       [QG_BRANCH_WORST] = "worst",
                                       NULL};
static const char *const branches_asked[] = {[QG_BRANCHES_NONE] = "none", [QG_BRANCHES_ALL] = "all", NULL};

#define OWNER struct qg_analysis
static const struct qg_field speeds_form_fields[] = {
    {NUMBER("min", "min", speeds.min, 0.01, 10), DEFAULT(0.2)},
    {NUMBER("max", "max", speeds.max, 0.01, 10), DEFAULT(1.4)},
    {COUNTED(QG_FIELD_SIZE, "count", "count", speeds.count, 1, QG_SPEEDS_MAX), DEFAULT(1000)},
};
static FORM(speeds_form);

static const struct qg_field start_form_fields[] = {
    {.key = "displacement",
     .where = "start_displacement",
     .type = QG_FIELD_START,
     AT(speeds),
     .low = -1000,
     .high = 1000,
     DEFAULT(0)},
    {NUMBER("velocity", "start_velocity", speeds.start_velocity, -1000, 1000), DEFAULT(0)},
};
static FORM(start_form);

static const struct qg_field analysis_form_fields[] = {
    {COUNTED(QG_FIELD_INT, "mesh_positions", "mesh_positions", mesh_positions, 4, QG_POSITIONS_MAX), DEFAULT(14)},
    {COUNTED(QG_FIELD_INT, "mesh_refinement", "mesh_refinement", mesh_refinement, 1, QG_REFINEMENT_MAX), DEFAULT(1)},
    {CHOICE("plane", "plane", plane, planes), DEFAULT(QG_PLANE_STRESS)},
    {CHOICE("bore", "bore", bore, bores), DEFAULT(QG_BORE_TORQUE_RING)},
    {CHOICE("mesh_stiffness", "mesh_stiffness", mesh_stiffness, stiffnesses), DEFAULT(QG_STIFFNESS_SECANT)},
    {COUNTED(QG_FIELD_INT, "harmonics", "harmonics", harmonics, 1, QG_HARMONICS_MAX), DEFAULT(6)},
    {OBJECT("speeds", "speeds", speeds_form), OPTIONAL},
    {CHOICE("branch", "speeds.branch", speeds.branch, branches), DEFAULT(QG_BRANCH_FIXED)},
    {OBJECT("initial_condition", "speeds", start_form), OPTIONAL},
    {CHOICE("branches", "branches", branches, branches_asked), DEFAULT(QG_BRANCHES_NONE), .used_by = QG_FOR_EVALUATE},
};
static FORM(analysis_form);
#undef OWNER

/* Search box: every leaf knows its parameter; base is always the struct qg_bounds itself. */

#define RANGE(key_, where_, parameter_, low_, high_)                                                                   \
    {                                                                                                                  \
        .key = (key_), .where = (where_), .type = QG_FIELD_RANGE, .need = QG_NEED_NOTHING, .low = (low_),              \
        .high = (high_), .fallback = (parameter_)                                                                      \
    }
#define RANGES_FORM(name, radius_key, radius_where, parameter)                                                         \
    static const struct qg_field name##_fields[] = {                                                                   \
        RANGE(radius_key, radius_where, parameter, 0.1, 20000),                                                        \
        RANGE("amplitude_mm", "amplitude", parameter + 1, 0, 1),                                                       \
    };                                                                                                                 \
    static FORM(name)
RANGES_FORM(pinion_tip_bounds_form, "start_radius_mm", "start_radius", QG_PINION_TIP_START_RADIUS);
RANGES_FORM(pinion_root_bounds_form, "end_radius_mm", "end_radius", QG_PINION_ROOT_END_RADIUS);
RANGES_FORM(gear_tip_bounds_form, "start_radius_mm", "start_radius", QG_GEAR_TIP_START_RADIUS);
RANGES_FORM(gear_root_bounds_form, "end_radius_mm", "end_radius", QG_GEAR_ROOT_END_RADIUS);

static const struct qg_field pinion_bounds_form_fields[] = {
    {OBJECT("tip", "tip", pinion_tip_bounds_form), OPTIONAL},
    {OBJECT("root", "root", pinion_root_bounds_form), OPTIONAL},
};
static FORM(pinion_bounds_form);
static const struct qg_field gear_bounds_form_fields[] = {
    {OBJECT("tip", "tip", gear_tip_bounds_form), OPTIONAL},
    {OBJECT("root", "root", gear_root_bounds_form), OPTIONAL},
};
static FORM(gear_bounds_form);
static const struct qg_field bounds_form_fields[] = {
    {OBJECT("pinion", "pinion", pinion_bounds_form), OPTIONAL},
    {OBJECT("gear", "gear", gear_bounds_form), OPTIONAL},
};
static FORM(bounds_form);

/* Grid of a map: one axis, offsets in struct qg_axis */

static const char *const parameters[] = {
    [QG_PINION_TIP_START_RADIUS] = "pinion.tip.start_radius_mm",
    [QG_PINION_TIP_AMPLITUDE] = "pinion.tip.amplitude_mm",
    [QG_PINION_ROOT_END_RADIUS] = "pinion.root.end_radius_mm",
    [QG_PINION_ROOT_AMPLITUDE] = "pinion.root.amplitude_mm",
    [QG_GEAR_TIP_START_RADIUS] = "gear.tip.start_radius_mm",
    [QG_GEAR_TIP_AMPLITUDE] = "gear.tip.amplitude_mm",
    [QG_GEAR_ROOT_END_RADIUS] = "gear.root.end_radius_mm",
    [QG_GEAR_ROOT_AMPLITUDE] = "gear.root.amplitude_mm",
    [QG_PARAMETER_COUNT] = NULL,
};
#define OWNER struct qg_axis
static const struct qg_field axis_form_fields[] = {
    {CHOICE("parameter", "parameter", parameter, parameters), REQUIRED},
    {NUMBER("from", "from", from, 0, 20000), REQUIRED},
    {NUMBER("to", "to", to, 0, 20000), REQUIRED},
    {COUNTED(QG_FIELD_SIZE, "count", "count", count, 2, 1000), DEFAULT(15)},
};
static FORM(axis_form);
#undef OWNER

/* Macro-geometry: intervals that are absent get their defaults from the initial pair (core/macro.h, qg_macro_complete) */

#define INTERVAL(type_, key_, where_, member, low_, high_)                                                             \
    { .key = (key_), .where = (where_), .type = (type_), AT(member), .low = (low_), .high = (high_), OPTIONAL }
static const char *const largest[] = {"largest", NULL};
#define OWNER struct qg_macro_ranges
#define GEAR_RANGES_FORM(name, i)                                                                                      \
    static const struct qg_field name##_fields[] = {                                                                   \
        INTERVAL(QG_FIELD_INTERVAL_OF_WHOLES, "teeth", "teeth", gears[i].teeth, 5, 1000),                              \
        INTERVAL(QG_FIELD_INTERVAL, "profile_shift_mm", "profile_shift", gears[i].profile_shift, -200, 200),           \
        INTERVAL(QG_FIELD_INTERVAL, "outside_radius_mm", "outside_radius", gears[i].outside_radius, 0.1, 20000),       \
        INTERVAL(QG_FIELD_INTERVAL, "root_radius_mm", "root_radius", gears[i].root_radius, 0.1, 20000),                \
        {.key = "hob_tip_radius_mm",                                                                                   \
         .where = "hob_tip_radius",                                                                                    \
         .type = QG_FIELD_WORD_OR_NUMBER,                                                                              \
         AT(gears[i].hob_tip_radius),                                                                                  \
         .high = 100,                                                                                                  \
         .choices = largest,                                                                                           \
         DEFAULT(-1)},                                                                                                 \
    };                                                                                                                 \
    static FORM(name)
GEAR_RANGES_FORM(pinion_ranges_form, QG_PINION);
GEAR_RANGES_FORM(gear_ranges_form, QG_GEAR);

static const struct qg_field ranges_form_fields[] = {
    INTERVAL(QG_FIELD_INTERVAL, "module_mm", "module", module, 0.05, 100),
    INTERVAL(QG_FIELD_INTERVAL, "pressure_angle_deg", "pressure_angle", pressure_angle_deg, 10, 35),
    {OBJECT("pinion", "pinion", pinion_ranges_form), OPTIONAL},
    {OBJECT("gear", "gear", gear_ranges_form), OPTIONAL},
};
static FORM(ranges_form);
#undef OWNER

#define OWNER struct qg_macro_limits
static const struct qg_field limits_form_fields[] = {
    {NUMBER("ratio_percent", "ratio", ratio_percent, 0, 100), DEFAULT(1)},
    INTERVAL(QG_FIELD_INTERVAL, "backlash_mm", "backlash", backlash, 0, 10),
    {NUMBER("tip_thickness_modules", "tip_thickness", tip_thickness, 0, 2), DEFAULT(0.4)},
    {NUMBER("tip_clearance_modules", "tip_clearance", tip_clearance, 0, 2), DEFAULT(0.25)},
    {NUMBER("contact_stress_factor", "contact_stress", contact_stress_factor, 0.01, 100), DEFAULT(1)},
    {NUMBER("root_stress_factor", "root_stress", root_stress_factor, 0.01, 100), DEFAULT(1)},
};
static FORM(limits_form);
#undef OWNER

#define OWNER struct qg_macro
static const struct qg_field macro_form_fields[] = {
    {COUNTED(QG_FIELD_SEED, "samples", "samples", samples, 1, 1e11), DEFAULT(1e9)},
    {COUNTED(QG_FIELD_SEED, "seed", "seed", seed, 0, largest_seed), DEFAULT(1)},
    {COUNTED(QG_FIELD_SIZE, "keep", "keep", keep, 1, QG_MACRO_KEEP_MAX), DEFAULT(10)},
    {OBJECT("ranges", "ranges", ranges_form), AT(ranges), OPTIONAL},
    {OBJECT("constraints", "constraints", limits_form), AT(limits), OPTIONAL},
};
static FORM(macro_form);
#undef OWNER

/* Search and reliability */

static const char *const methods[] = {[QG_SEARCH_RANDOM_SIMPLEX] = "random_simplex",
                                      [QG_SEARCH_MULTISTART_SIMPLEX] = "multistart_simplex",
                                      [QG_SEARCH_METHOD_COUNT] = NULL};
#define OWNER struct qg_optimizer
static const struct qg_field optimizer_form_fields[] = {
    {CHOICE("method", "method", method, methods), DEFAULT(QG_SEARCH_RANDOM_SIMPLEX)},
    {COUNTED(QG_FIELD_SIZE, "random_samples", "random_samples", random_samples, 1, 1000000), DEFAULT(180),
     .methods = QG_FOR_RANDOM_SIMPLEX},
    {COUNTED(QG_FIELD_SIZE, "simplex_iterations", "simplex_iterations", simplex_iterations, 0, 1000000), DEFAULT(80),
     .methods = QG_FOR_RANDOM_SIMPLEX},
    {COUNTED(QG_FIELD_SIZE, "evaluations", "evaluations", evaluations, 1, 1000000), DEFAULT(320),
     .methods = QG_FOR_MULTISTART_SIMPLEX},
    {COUNTED(QG_FIELD_SIZE, "starts", "starts", starts, 1, QG_STARTS_MAX), DEFAULT(4),
     .methods = QG_FOR_MULTISTART_SIMPLEX},
    {COUNTED(QG_FIELD_SEED, "seed", "seed", seed, 0, largest_seed), DEFAULT(1)},
    {COUNTED(QG_FIELD_SIZE, "verification_factor", "verification_factor", verification_factor, 0, 16), DEFAULT(4)},
};
static FORM(optimizer_form);
#undef OWNER

#define OWNER struct qg_reliability
static const struct qg_field reliability_form_fields[] = {
    {COUNTED(QG_FIELD_SIZE, "samples", "samples", samples, 1, 1000000), DEFAULT(100)},
    {NUMBER("radius_range_mm", "radius_range", radius_range, 0, 100), DEFAULT(0.2)},
    {NUMBER("amplitude_range_mm", "amplitude_range", amplitude_range, 0, 1), DEFAULT(0.012)},
    {NUMBER("limit_f_dte", "limit_f_dte", limit_f_dte, 0.0001, 1000), DEFAULT(0.5)},
    {COUNTED(QG_FIELD_SEED, "seed", "seed", seed, 0, largest_seed), DEFAULT(1)},
    {NUMBER("percentile", "percentile", percentile, 50, 100), DEFAULT(90), .used_by = QG_FOR_OPTIMIZE},
    {COUNTED(QG_FIELD_SIZE, "percentile_trials", "percentile_trials", percentile_trials, 2, QG_PERCENTILE_TRIALS_MAX),
     DEFAULT(24), .used_by = QG_FOR_OPTIMIZE},
};
static FORM(reliability_form);
#undef OWNER

/* The document */

static const char *const kinds[] = {
    [QG_STUDY_EVALUATE] = "evaluate", [QG_STUDY_OPTIMIZE] = "optimize", [QG_STUDY_RELIABILITY] = "reliability",
    [QG_STUDY_MAP] = "map",           [QG_STUDY_MACRO] = "macro",       [QG_STUDY_KIND_COUNT] = NULL,
};
static const char *const objectives[] = {[QG_OBJECTIVE_F_DTE] = "f_dte",
                                         [QG_OBJECTIVE_F_PPS] = "f_pps",
                                         [QG_OBJECTIVE_F_DTE_PERCENTILE] = "f_dte_percentile",
                                         [QG_OBJECTIVE_COUNT] = NULL};

#define OWNER struct qg_job
static const struct qg_field qg_document_form_fields[] = {
    {.key = "kind", .where = "kind", .type = QG_FIELD_KIND, AT(study.kind), .choices = kinds, REQUIRED},
    {TEXT("name", name)},
    {TEXT("external_id", external_id)},
    {.key = "labels", .where = "labels", .type = QG_FIELD_LABELS, .high = QG_LABEL_MAX, OPTIONAL},
    {OBJECT("gear_pair", "", pair_form), REQUIRED},
    {.key = "load_cases",
     .where = "analysis.torque_fraction",
     .type = QG_FIELD_LOAD_CASES,
     .high = QG_CASES_MAX,
     OPTIONAL},
    {OBJECT("relief", "", relief_form), AT(study.relief), OPTIONAL, .used_by = QG_FOR_ALL & ~QG_FOR_MACRO,
     .required_by = QG_FOR_RELIABILITY},
    {OBJECT("analysis", "analysis", analysis_form), AT(study.analysis), OPTIONAL},
    {CHOICE("objective", "objective", study.objective, objectives), DEFAULT(QG_OBJECTIVE_F_DTE),
     .used_by = QG_FOR_OPTIMIZE | QG_FOR_MAP | QG_FOR_MACRO},
    {.key = "objectives",
     .where = "objectives",
     .type = QG_FIELD_OBJECTIVES,
     AT(study.objectives),
     .low = 2,
     .high = QG_OBJECTIVE_COUNT,
     .choices = objectives,
     OPTIONAL,
     .used_by = QG_FOR_OPTIMIZE},
    {OBJECT("relief_bounds", "bounds", bounds_form), AT(study.bounds), OPTIONAL, .used_by = QG_FOR_OPTIMIZE,
     .required_by = QG_FOR_OPTIMIZE},
    {.key = "grid",
     .where = "grid",
     .type = QG_FIELD_GRID,
     AT(study.grid),
     .high = QG_AXES_MAX,
     .form = &axis_form,
     OPTIONAL,
     .used_by = QG_FOR_MAP,
     .required_by = QG_FOR_MAP},
    {OBJECT("macro", "macro", macro_form), AT(study.macro), OPTIONAL, .used_by = QG_FOR_MACRO},
    {OBJECT("optimizer", "optimizer", optimizer_form), AT(study.optimizer), OPTIONAL, .used_by = QG_FOR_OPTIMIZE},
    {OBJECT("reliability", "reliability", reliability_form), AT(study.reliability), OPTIONAL,
     .used_by = QG_FOR_OPTIMIZE | QG_FOR_RELIABILITY, .required_by = QG_FOR_RELIABILITY},
};
FORM(qg_document_form);
#undef OWNER

const char *qg_kind_name(enum qg_study_kind kind) {
    assert((unsigned)kind < sizeof kinds / sizeof *kinds - 1);
    return kinds[kind];
}

const char *qg_objective_name(enum qg_objective objective) {
    assert((unsigned)objective < QG_OBJECTIVE_COUNT);
    return objectives[objective];
}

const char *qg_job_objective(const struct qg_job *job) {
    const enum qg_study_kind kind = job->study.kind;
    const bool searches = kind != QG_STUDY_EVALUATE && kind != QG_STUDY_RELIABILITY;
    return searches && job->study.objectives.count == 0 ? qg_objective_name(job->study.objective) : NULL;
}

const char *qg_method_name(enum qg_search_method method) {
    assert((unsigned)method < QG_SEARCH_METHOD_COUNT);
    return methods[method];
}

const char *qg_parameter_name(enum qg_parameter parameter) {
    assert((unsigned)parameter < QG_PARAMETER_COUNT);
    return parameters[parameter];
}

const struct qg_field *qg_form_find(const struct qg_form *form, const char *key) {
    for (size_t i = 0; i < form->count; i++)
        if (strcmp(form->fields[i].key, key) == 0)
            return &form->fields[i];
    return NULL;
}

bool qg_field_used(const struct qg_field *field, enum qg_study_kind kind) {
    return field->used_by == 0 || (field->used_by & 1u << kind) != 0;
}

bool qg_field_required(const struct qg_field *field, enum qg_study_kind kind) {
    return field->need == QG_NEED_REQUIRED || (field->required_by & 1u << kind) != 0;
}

/* The search for the member that names the most of `where`. */
struct search {
    const char *where;
    struct qg_path path;
    size_t best; /* bytes of where that the best member so far accounts for */
    char *pointer;
};

/* Behind a name: "[3]" or ".3" becomes the array index. Returns the bytes of where that it takes. */
static size_t index_step(struct search *search, size_t at) {
    const char *digits = search->where + at + 1;
    const bool bracket = search->where[at] == '[';
    const size_t n = bracket || search->where[at] == '.' ? strspn(digits, "0123456789") : 0;
    if (n == 0 || n > 6 || (bracket ? digits[n] != ']' : strchr(".", digits[n]) == NULL)) /* "" is found too */
        return 0;
    char index[8] = {0};
    memcpy(index, digits, n);
    qg_path_push(&search->path, index);
    return n + 1 + bracket;
}

/* Tries the members of a form on what is left of the name from `at` on. */
static void search_form(struct search *search, const struct qg_form *form, size_t at) {
    for (size_t i = 0; i < form->count; i++) {
        const struct qg_field *field = &form->fields[i];
        const size_t n = strlen(field->where), mark = search->path.length;
        if (strncmp(search->where + at, field->where, n) != 0)
            continue;
        size_t end = at + n;
        if (n > 0 && strchr(".[", search->where[end]) == NULL) /* "" is found too: the end of the name */
            continue;
        if (n == 0 && strcmp(search->where + at, field->key) == 0) /* "relief": the object itself */
            end += strlen(field->key);
        qg_path_push(&search->path, field->key);
        end += field->type == QG_FIELD_LOAD_CASES || field->type == QG_FIELD_GRID ? index_step(search, end) : 0;
        if (end > search->best) {
            search->best = end;
            memcpy(search->pointer, search->path.text, search->path.length + 1);
        }
        if (field->form && (end == at || search->where[end] == '.'))
            search_form(search, field->form, end == at ? end : end + 1);
        qg_path_pop(&search->path, mark);
    }
}

void qg_document_pointer(const char *where, char pointer[QG_POINTER_ROOM]) {
    struct search search = {.where = where, .pointer = pointer};
    pointer[0] = '\0';
    search_form(&search, &qg_document_form, 0);
}
