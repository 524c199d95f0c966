/* Static contact over the mesh period; statics.h tells the idea.
 *
 * Geometry of one pair of flanks. Let B be the gear whose tip may engage and A its mate; the line of action touches
 * their base circles at T_B and T_A, L apart, and the pair's theoretical contact is xi_B from T_B, L - xi_B from T_A (either
 * may lie beyond a tip). From B's axis, with e1 towards T_B and e2 along the line towards A, the involute of B is
 *     Q(xi) = r_B e1' + xi e2',   (e1', e2') turned by D = (xi - xi_B)/r_B:  e1' = cos D e1 - sin D e2, e2' = cos D e2 + sin D e1
 * (the string unwinds). The same holds for A with its own (-e1, -e2). A point Q lies on the tangent of A's base circle that is
 * turned by D_A, at the length xi_Q = sqrt(|Q - O_A|^2 - r_A^2); A's involute cuts that tangent at xi_A + r_A D_A. Hence
 *     gap = xi_Q - (xi_A + r_A D_A),
 * exactly, and turning A by an angle changes it by r_A times that angle. The normals of the two flanks differ by
 * beta = D_A - D_B, zero on the line of action.
 */
#include "core/statics.h"

#include <assert.h>
#include <cblas.h>
#include <math.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "core/mesh.h"

/* Points on one pair of flanks. */
enum { POINTS_PER_PAIR = 1200 };

/* ---- geometry of one pair of flanks ----------------------------------------------------------------------------- */

/* The flanks of one pair of teeth at one mesh position. */
struct flanks {
    const struct qg_gear_pair *pair;
    const struct qg_pair_geometry *geometry;
    int tip, mate;       /* which gear is B, which is A */
    double tip_contact;  /* xi_B of the theoretical contact */
    double mate_contact; /* xi_A */
};

static struct flanks flanks_at(const struct qg_statics *s, double position, int pair) {
    const struct qg_pair_geometry *g = s->geometry;
    double xi = qg_path_position(g, position, pair);
    double pitch_point = g->gears[QG_PINION].base_radius * tan(g->working_pressure_angle);
    bool approach = xi < pitch_point;
    struct flanks f = {.pair = s->pair, .geometry = g, .tip = approach ? QG_GEAR : QG_PINION};
    f.mate = 1 - f.tip;
    f.tip_contact = approach ? g->line_length - xi : xi;
    f.mate_contact = g->line_length - f.tip_contact;
    return f;
}

/* Everything about the point at xi on the tip's flank. */
struct look {
    double gap;
    double xi_tip, xi_mate; /* tangent lengths: of the point itself, of its foot on the mate */
    double beta;            /* rad, between the two normals */
};

static struct look look_from(const struct flanks *f, double xi) {
    double r_tip = f->geometry->gears[f->tip].base_radius, r_mate = f->geometry->gears[f->mate].base_radius;
    double turned = (xi - f->tip_contact) / r_tip, c = cos(turned), s = sin(turned);
    double q1 = r_tip * c + xi * s, q2 = -r_tip * s + xi * c;            /* along e1, e2 from B's axis */
    double p1 = r_tip + r_mate - q1, p2 = f->geometry->line_length - q2; /* along -e1, -e2 from A's axis */
    double length = sqrt(fmax(0, p1 * p1 + p2 * p2 - r_mate * r_mate));
    double mate_turned = atan2(length * p1 - r_mate * p2, r_mate * p1 + length * p2);
    double foot = f->mate_contact + r_mate * mate_turned;
    return (struct look){.gap = length - foot, .xi_tip = xi, .xi_mate = foot, .beta = mate_turned - turned};
}

static double radius_at(const struct qg_gear_geometry *g, double xi) {
    return hypot(g->base_radius, xi);
}

static double xi_at(const struct qg_gear_geometry *g, double radius) {
    return sqrt(fmax(0, radius * radius - g->base_radius * g->base_radius));
}

static double arc_of(const struct qg_gear_geometry *g, double xi) {
    return xi * xi / (2 * g->base_radius);
}

static double xi_of_arc(const struct qg_gear_geometry *g, double arc) {
    return sqrt(fmax(0, 2 * g->base_radius * arc));
}

static struct qg_gap_sample sample_of(const struct flanks *f, const struct look *l, double weight) {
    struct qg_gap_sample sample = {.weight = weight, .gap = l->gap};
    sample.radius[f->tip] = radius_at(&f->geometry->gears[f->tip], l->xi_tip);
    sample.radius[f->mate] = radius_at(&f->geometry->gears[f->mate], l->xi_mate);
    return sample;
}

/* Moment arm of the normal about the pinion's axis, over its base radius. */
static double lever_of(const struct flanks *f, const struct look *l) {
    if (f->tip == QG_GEAR)
        return 1; /* the normal is the pinion's own */
    return cos(l->beta) - l->xi_tip / f->geometry->gears[QG_PINION].base_radius * sin(l->beta);
}

/* ---- laying points ---------------------------------------------------------------------------------------------- */

/* The stretch of the tip's flank (arc lengths) where the bare gap is at most the largest, and where points start. */
struct stretch {
    double low, high, center;
};

static double gap_at_arc(const struct flanks *f, double arc) {
    return look_from(f, xi_of_arc(&f->geometry->gears[f->tip], arc)).gap;
}

/* From the centre towards `limit`: the arc where the gap reaches the largest, or the limit. The gap grows on the way. */
static double reach_arc(const struct flanks *f, double center, double limit, double largest) {
    if (gap_at_arc(f, limit) <= largest)
        return limit;
    double inside = center, outside = limit;
    for (int i = 0; i < 60; i++) {
        double middle = (inside + outside) / 2;
        if (gap_at_arc(f, middle) <= largest)
            inside = middle;
        else
            outside = middle;
    }
    return inside;
}

/* False when this pair of teeth cannot touch at all. */
static bool stretch_of(const struct qg_statics *s, const struct flanks *f, struct stretch *out) {
    const struct qg_gear_geometry *tip = &f->geometry->gears[f->tip], *mate = &f->geometry->gears[f->mate];
    double highest = arc_of(tip, xi_at(tip, f->pair->gears[f->tip].outside_radius));
    double lowest = arc_of(tip, xi_at(tip, tip->form_radius));
    if (f->tip_contact <= 0 || f->mate_contact <= 0)
        return false;
    out->center = fmin(highest, fmax(lowest, arc_of(tip, f->tip_contact)));
    if (gap_at_arc(f, out->center) > s->largest_gap)
        return false;
    out->high = reach_arc(f, out->center, highest, s->largest_gap);
    out->low = reach_arc(f, out->center, lowest, s->largest_gap);
    /* the foot must stay on the mate's involute: it moves inwards on the mate as the point moves towards the tip */
    double mate_low = xi_at(mate, mate->form_radius), mate_high = xi_at(mate, f->pair->gears[f->mate].outside_radius);
    while (out->high > out->center && look_from(f, xi_of_arc(tip, out->high)).xi_mate < mate_low)
        out->high -= (highest - lowest) / 1000;
    while (out->low < out->center && look_from(f, xi_of_arc(tip, out->low)).xi_mate > mate_high)
        out->low += (highest - lowest) / 1000;
    return out->high > out->low;
}

/* Arc lengths of the points of a stretch, ascending: steps of the local node distance from the centre both ways, the last
 * one on the upper end itself (the tip corner when it is reached). Returns the count, at most POINTS_PER_PAIR. */
static size_t lay_arcs(const struct stretch *t, const struct qg_compliance *tip, double *arc) {
    double reversed[POINTS_PER_PAIR];
    size_t below = 0, n = 0;
    for (double at = t->center - qg_node_distance(tip, t->center); at >= t->low && below < POINTS_PER_PAIR / 2;
         at -= qg_node_distance(tip, at))
        reversed[below++] = at;
    for (size_t k = below; k > 0; k--)
        arc[n++] = reversed[k - 1];
    double at = t->center, step = qg_node_distance(tip, at);
    for (; at + 0.35 * step < t->high && n < POINTS_PER_PAIR - 1; at += step, step = qg_node_distance(tip, at))
        arc[n++] = at;
    arc[n++] = t->high;
    return n;
}

double qg_statics_reach(const struct qg_gear_pair *pair, const struct qg_pair_geometry *geometry, double approach) {
    return qg_relief_deepest(pair, geometry, QG_PINION) + qg_relief_deepest(pair, geometry, QG_GEAR) + 1.5 * approach;
}

/* Two points for each element of the tip's flank in the stretch, as lay_arcs lays them. */
size_t qg_statics_count_points(const struct qg_gear_pair *pair, const struct qg_pair_geometry *geometry,
                               double largest_gap, double position, int *pairs) {
    const struct qg_statics s = {.pair = pair, .geometry = geometry, .largest_gap = largest_gap};
    size_t points = 0;
    *pairs = 0;
    for (int k = -QG_PAIR_REACH; k <= QG_PAIR_REACH; k++) {
        struct flanks f = flanks_at(&s, position, k);
        struct stretch stretch;
        if (!stretch_of(&s, &f, &stretch))
            continue;
        const struct qg_gear_geometry *tip = &geometry->gears[f.tip];
        double corner = arc_of(tip, xi_at(tip, pair->gears[f.tip].outside_radius)), module = pair->rack.module;
        int low = qg_flank_elements(&qg_density_analysis, (corner - stretch.low) / module),
            high = qg_flank_elements(&qg_density_analysis, (corner - stretch.high) / module);
        points += 2 * (size_t)(low - high) + 2;
        ++*pairs;
    }
    return points;
}

/* ---- from flank to nodes ---------------------------------------------------------------------------------------- */

/* Absolute angle of the flank's outward normal at tangent length xi. */
static double normal_angle(const struct flanks *f, int gear, double xi) {
    const struct qg_gear_geometry *g = &f->geometry->gears[gear];
    double radius = radius_at(g, xi), pressure_angle = atan2(xi, g->base_radius);
    return qg_half_tooth_angle(&f->pair->rack, g, radius) + M_PI_2 - pressure_angle;
}

/* Builds one point from its neighbours' arcs: hat function, gap samples, spreads on both flanks ([2], by gear; the mate's is
 * walked from its far end since the feet move backwards). */
static void build_point(const struct flanks *f, const double arc[3], const struct qg_compliance compliance[2],
                        struct qg_contact_point *point, struct qg_spread spread[2]) {
    static const double gauss[3] = {-0.77459666924148337704, 0, 0.77459666924148337704};
    static const double share[3] = {5.0 / 18, 8.0 / 18, 5.0 / 18};
    const struct qg_gear_geometry *tip = &f->geometry->gears[f->tip], *mate = &f->geometry->gears[f->mate];
    struct look looks[QG_GAP_SAMPLES], here = look_from(f, xi_of_arc(tip, arc[1]));
    double weight[QG_GAP_SAMPLES], total = 0;
    for (int k = 0; k < QG_GAP_SAMPLES; k++) {
        double from = arc[k / 3], to = arc[k / 3 + 1], at = (1 + gauss[k % 3]) / 2;
        double hat = k < 3 ? at : 1 - at;
        looks[k] = look_from(f, xi_of_arc(tip, from + at * (to - from)));
        weight[k] = share[k % 3] * hat * (to - from);
        total += weight[k];
    }
    point->lever = lever_of(f, &here);
    point->width = total;
    point->at = sample_of(f, &here, 1);
    for (int k = 0; k < QG_GAP_SAMPLES; k++) {
        point->sample[k] = sample_of(f, &looks[k], weight[k] / total);
        if (weight[k] > 0)
            qg_spread_add(&spread[f->tip], &compliance[f->tip], arc_of(tip, looks[k].xi_tip),
                          normal_angle(f, f->tip, looks[k].xi_tip) - looks[k].beta, weight[k] / total);
    }
    for (int k = QG_GAP_SAMPLES - 1; k >= 0; k--)
        if (weight[k] > 0)
            qg_spread_add(&spread[f->mate], &compliance[f->mate], arc_of(mate, looks[k].xi_mate),
                          normal_angle(f, f->mate, looks[k].xi_mate), weight[k] / total);
}

/* ---- flexibility of a site -------------------------------------------------------------------------------------- */

/* A tooth of the pair k is the k-th counter-clockwise on the pinion, clockwise on the gear. */
static void fill_flexibility(struct qg_contact_site *site, const struct qg_flank_matrices *f,
                             struct qg_spread (*spread)[2]) {
    for (size_t i = 0; i < site->n; i++)
        for (size_t j = 0; j <= i; j++) {
            int d = site->point[i].pair - site->point[j].pair;
            double value = qg_flank_flexibility(f, QG_PINION, d, &spread[i][QG_PINION], &spread[j][QG_PINION]) +
                           qg_flank_flexibility(f, QG_GEAR, -d, &spread[i][QG_GEAR], &spread[j][QG_GEAR]);
            site->flexibility[i * site->n + j] = site->flexibility[j * site->n + i] = value;
        }
}

/* ---- sites ------------------------------------------------------------------------------------------------------ */

/* Points of one pair of teeth, appended to the site. arcs has room for them. */
static void add_pair(struct qg_contact_site *site, const struct flanks *f, int pair, const double *arc, size_t count,
                     const struct qg_compliance compliance[2], struct qg_spread (*spread)[2]) {
    for (size_t i = 0; i < count; i++) {
        const double around[3] = {arc[i > 0 ? i - 1 : 0], arc[i], arc[i + 1 < count ? i + 1 : i]};
        const struct qg_gear_geometry *tip = &f->geometry->gears[f->tip];
        double corner = arc_of(tip, xi_at(tip, f->pair->gears[f->tip].outside_radius));
        site->point[site->n].pair = pair;
        site->point[site->n].near_corner = corner - arc[i] < QG_CORNER_ZONE * f->pair->rack.module;
        build_point(f, around, compliance, &site->point[site->n], spread[site->n]);
        site->n++;
    }
}

/* Everything that the pieces of statics_init share. */
struct site_builder {
    struct qg_statics *statics;
    const struct qg_compliance *compliance;
    const struct qg_stop *stop;
    struct qg_flank_matrices matrices;
    enum qg_status *status; /* per position */
    atomic_size_t bytes;    /* of the sites so far */
    double bytes_max;       /* 0: any */
};

/* True when a site of so many points may be made. All sites together decide: the answer is the same in any order. */
static bool may_hold(struct site_builder *b, size_t points) {
    const size_t bytes = points * (points * sizeof(double) + sizeof(struct qg_contact_point));
    const size_t sum = atomic_fetch_add(&b->bytes, bytes) + bytes;
    return b->bytes_max == 0 || (double)sum <= b->bytes_max;
}

static enum qg_status build_site(struct site_builder *b, size_t position) {
    const struct qg_statics *s = b->statics;
    struct qg_contact_site *site = &s->site[position];
    double phi = qg_statics_position(s, position);
    struct flanks flanks[QG_PAIR_COUNT];
    double(*arc)[POINTS_PER_PAIR] = malloc(QG_PAIR_COUNT * sizeof *arc);
    size_t count[QG_PAIR_COUNT] = {0}, total = 0;
    for (int k = 0; k < QG_PAIR_COUNT && arc; k++) {
        struct stretch stretch;
        flanks[k] = flanks_at(s, phi, k - QG_PAIR_REACH);
        if (!stretch_of(s, &flanks[k], &stretch))
            continue;
        count[k] = lay_arcs(&stretch, &b->compliance[flanks[k].tip], arc[k]);
        if (count[k] < 2) /* a sliver at the largest gap: nothing that could touch */
            count[k] = 0;
        total += count[k];
    }
    if (total == 0 || !may_hold(b, total)) {
        free(arc);
        return arc && total == 0 ? QG_NO_CONVERGENCE : QG_OUT_OF_MEMORY;
    }
    struct qg_spread(*spread)[2] = calloc(total, sizeof *spread);
    site->point = calloc(total, sizeof *site->point);
    site->flexibility = malloc(total * total * sizeof *site->flexibility);
    enum qg_status status = spread && site->point && site->flexibility ? QG_OK : QG_OUT_OF_MEMORY;
    for (int k = 0; k < QG_PAIR_COUNT && status == QG_OK; k++) {
        if (count[k] > 0)
            add_pair(site, &flanks[k], k - QG_PAIR_REACH, arc[k], count[k], b->compliance, spread);
    }
    if (status == QG_OK)
        fill_flexibility(site, &b->matrices, spread);
    if (status == QG_OK && !(site->spread = qg_spreads_pack(spread, total)))
        status = QG_OUT_OF_MEMORY;
    free(arc);
    free(spread);
    return status;
}

static void build_site_piece(void *context, size_t item, int worker) {
    struct site_builder *b = context;
    (void)worker;
    b->status[item] = qg_is_stopped(b->stop) ? QG_CANCELLED : build_site(b, item);
}

/* The largest distance between two pairs that may touch at one position. */
static int largest_pair_distance(const struct qg_statics *s) {
    int most = 0;
    for (size_t position = 0; position < s->positions; position++) {
        int first = QG_PAIR_COUNT, last = -1;
        for (int k = 0; k < QG_PAIR_COUNT; k++) {
            struct flanks f = flanks_at(s, qg_statics_position(s, position), k - QG_PAIR_REACH);
            struct stretch stretch;
            if (!stretch_of(s, &f, &stretch))
                continue;
            first = k < first ? k : first;
            last = k;
        }
        most = last - first > most ? last - first : most;
    }
    return most;
}

/* What a pair would approach if one point in the middle of the flanks took the whole force: an upper estimate. */
static double rough_approach(const struct qg_compliance compliance[2], double force) {
    double sum = 0;
    for (int g = 0; g < 2; g++) {
        size_t middle = 2 * (compliance[g].flank_count / 2) + 1;
        sum += qg_compliance_entry(&compliance[g], 0, middle, middle);
    }
    return sum * force;
}

double qg_statics_position(const struct qg_statics *s, size_t i) {
    return s->first + (double)i / (double)s->positions;
}

/* Makes all sites of statics, whose pair, geometry and positions are set. */
static enum qg_status make_sites(struct qg_statics *statics, const struct qg_compliance *compliance,
                                 double largest_force, const struct qg_means *means) {
    const size_t positions = statics->positions;
    const struct qg_gear_pair *pair = statics->pair;
    const struct qg_pair_geometry *geometry = statics->geometry;
    statics->largest_gap = qg_statics_reach(pair, geometry, rough_approach(compliance, largest_force));
    statics->site = calloc(positions, sizeof *statics->site);
    struct site_builder builder = {
        .statics = statics, .compliance = compliance, .stop = &means->stop, .bytes_max = means->operator_bytes_max};
    builder.status = calloc(positions, sizeof *builder.status);
    enum qg_status status = statics->site && builder.status ? QG_OK : QG_OUT_OF_MEMORY;
    int distance = largest_pair_distance(statics), rows = distance < 2 * QG_PAIR_REACH ? distance + 1 : distance;
    if (status == QG_OK)
        status = qg_stress_rows_init(&statics->stress, compliance, rows, &means->stop);
    if (status == QG_OK)
        status = qg_flank_matrices_init(&builder.matrices, compliance, distance, &means->stop);
    if (status == QG_OK) {
        means->executor.run(means->executor.self, positions, build_site_piece, &builder);
        for (size_t i = 0; i < positions; i++) {
            if (builder.status[i] != QG_OK)
                status = builder.status[i];
            if (statics->site[i].n > statics->most_points)
                statics->most_points = statics->site[i].n;
        }
    }
    qg_flank_matrices_finish(&builder.matrices);
    free(builder.status);
    if (status != QG_OK)
        qg_statics_finish(statics);
    return status;
}

enum qg_status qg_statics_init(struct qg_statics *statics, const struct qg_gear_pair *pair,
                               const struct qg_pair_geometry *geometry, const struct qg_compliance *compliance,
                               size_t positions, double largest_force, const struct qg_means *means) {
    *statics = (struct qg_statics){.pair = pair, .geometry = geometry, .positions = positions};
    return make_sites(statics, compliance, largest_force, means);
}

enum qg_status qg_statics_init_at(struct qg_statics *statics, const struct qg_gear_pair *pair,
                                  const struct qg_pair_geometry *geometry, const struct qg_compliance *compliance,
                                  double position, double largest_force, const struct qg_means *means) {
    *statics = (struct qg_statics){.pair = pair, .geometry = geometry, .positions = 1, .first = position};
    return make_sites(statics, compliance, largest_force, means);
}

void qg_statics_finish(struct qg_statics *statics) {
    for (size_t i = 0; statics->site && i < statics->positions; i++) {
        free(statics->site[i].point);
        free(statics->site[i].flexibility);
        free(statics->site[i].spread);
    }
    free(statics->site);
    qg_stress_rows_finish(&statics->stress);
    *statics = (struct qg_statics){0};
}

/* ---- one design ------------------------------------------------------------------------------------------------- */

enum qg_status qg_statics_workspace_init(struct qg_statics_workspace *w, const struct qg_statics *statics) {
    *w = (struct qg_statics_workspace){0};
    w->gap = malloc(statics->most_points * sizeof *w->gap);
    w->lever = malloc(statics->most_points * sizeof *w->lever);
    size_t root =
        statics->stress.points[0] > statics->stress.points[1] ? statics->stress.points[0] : statics->stress.points[1];
    w->stress = malloc(root * sizeof *w->stress);
    if (w->gap && w->lever && w->stress && qg_contact_init(&w->contact, statics->most_points) == QG_OK)
        return QG_OK;
    qg_statics_workspace_finish(w);
    return QG_OUT_OF_MEMORY;
}

void qg_statics_workspace_finish(struct qg_statics_workspace *w) {
    qg_contact_finish(&w->contact);
    free(w->gap);
    free(w->lever);
    free(w->stress);
    *w = (struct qg_statics_workspace){0};
}

static double relieved(const struct qg_statics *s, const struct qg_relief *relief, const struct qg_gap_sample *at) {
    return at->gap + qg_relief_depth(relief, s->geometry, s->pair, QG_PINION, at->radius[QG_PINION]) +
           qg_relief_depth(relief, s->geometry, s->pair, QG_GEAR, at->radius[QG_GEAR]);
}

/* Averaged gaps of all points, and the unloaded transmission error: the smallest gap over its lever, refined by a parabola
 * through the neighbours of the smallest. */
static double fill_gaps(const struct qg_statics *s, const struct qg_contact_site *site, const struct qg_relief *relief,
                        struct qg_statics_workspace *w) {
    double *pointwise = w->contact.opening; /* free until the solve */
    size_t least = 0;
    for (size_t i = 0; i < site->n; i++) {
        const struct qg_contact_point *p = &site->point[i];
        w->lever[i] = p->lever;
        w->gap[i] = 0;
        for (int k = 0; k < QG_GAP_SAMPLES; k++)
            if (p->sample[k].weight > 0)
                w->gap[i] += p->sample[k].weight * relieved(s, relief, &p->sample[k]);
        pointwise[i] = relieved(s, relief, &p->at) / p->lever;
        if (pointwise[i] < pointwise[least])
            least = i;
    }
    double best = pointwise[least];
    bool inside = least > 0 && least + 1 < site->n && site->point[least - 1].pair == site->point[least].pair &&
                  site->point[least + 1].pair == site->point[least].pair;
    if (inside) {
        double slope = (pointwise[least + 1] - pointwise[least - 1]) / 2;
        double bend = pointwise[least + 1] - 2 * best + pointwise[least - 1];
        if (bend > 0)
            best -= slope * slope / (2 * bend);
    }
    return fmax(0, best);
}

/* Contact pressure at point i (MPa): the load on it and on half of each neighbour, over the width of the same. Corner nodes and
 * midsides of quadratic elements do not share an even pressure evenly; that see-saw, harmless in any sum, spoils single points
 * by a tenth, and this average takes it out whole. 0 at the ends and beside a tip corner, where there is none (statics.h). */
double qg_contact_pressure(const struct qg_statics *s, const struct qg_contact_site *site, const double *load,
                           size_t i) {
    if (i == 0 || i + 1 >= site->n)
        return 0;
    const struct qg_contact_point *p = &site->point[i - 1];
    if (p[0].pair != p[1].pair || p[2].pair != p[1].pair || p[2].near_corner)
        return 0;
    double force = load[i - 1] / 2 + load[i] + load[i + 1] / 2, width = p[0].width / 2 + p[1].width + p[2].width / 2;
    return force / (width * s->geometry->face_width);
}

/* Reads one solved position into a case's arrays. */
static void read_solution(const struct qg_statics *s, size_t position, const struct qg_contact *contact,
                          struct qg_case_result *c) {
    const struct qg_contact_site *site = &s->site[position];
    double *share = c->load_share + position * QG_PAIR_COUNT, total = 0, pressure = 0;
    memset(share, 0, QG_PAIR_COUNT * sizeof *share);
    for (size_t i = 0; i < site->n; i++) {
        share[site->point[i].pair + QG_PAIR_REACH] += contact->load[i];
        total += contact->load[i];
        pressure = fmax(pressure, qg_contact_pressure(s, site, contact->load, i));
    }
    for (int k = 0; k < QG_PAIR_COUNT; k++)
        share[k] /= total;
    c->static_transmission_error[position] = contact->approach;
    c->contact_pressure[position] = pressure;
    c->complementarity_residual = fmax(c->complementarity_residual, contact->residual);
}

static void summarize(size_t positions, struct qg_case_result *c) {
    double low = INFINITY, high = -INFINITY;
    size_t touching = 0;
    c->max_contact_pressure = 0;
    for (size_t i = 0; i < positions; i++) {
        low = fmin(low, c->static_transmission_error[i]);
        high = fmax(high, c->static_transmission_error[i]);
        c->max_contact_pressure = fmax(c->max_contact_pressure, c->contact_pressure[i]);
        for (int k = 0; k < QG_PAIR_COUNT; k++)
            touching += c->load_share[i * QG_PAIR_COUNT + (size_t)k] > 0;
    }
    c->pps = high - low;
    c->loaded_contact_ratio = (double)touching / (double)positions;
}

enum qg_status qg_statics_solve(const struct qg_statics *s, struct qg_statics_workspace *w,
                                struct qg_design_result *result) {
    for (size_t k = 0; k < result->case_count; k++) {
        struct qg_case_result *c = &result->cases[k];
        c->normal_force = c->torque / s->geometry->gears[QG_PINION].base_radius;
        c->complementarity_residual = 0;
    }
    for (size_t i = 0; i < s->positions; i++) {
        const struct qg_contact_site *site = &s->site[i];
        if (qg_is_stopped(&w->stop))
            return QG_CANCELLED;
        double unloaded = fill_gaps(s, site, &result->relief, w);
        for (size_t k = 0; k < result->case_count; k++) {
            struct qg_case_result *c = &result->cases[k];
            const struct qg_contact_problem problem = {site->n, site->flexibility, w->gap, w->lever, c->normal_force};
            enum qg_status status = qg_contact_solve(&w->contact, &problem, k > 0);
            if (status != QG_OK)
                return status;
            c->unloaded_transmission_error[i] = unloaded;
            read_solution(s, i, &w->contact, c);
        }
    }
    for (size_t k = 0; k < result->case_count; k++)
        summarize(s->positions, &result->cases[k]);
    return QG_OK;
}

enum qg_status qg_statics_contact(const struct qg_statics *s, struct qg_statics_workspace *w,
                                  const struct qg_relief *relief, size_t i, double force) {
    const struct qg_contact_site *site = &s->site[i];
    fill_gaps(s, site, relief, w);
    const struct qg_contact_problem problem = {site->n, site->flexibility, w->gap, w->lever, force};
    return qg_contact_solve(&w->contact, &problem, 0);
}

enum qg_status qg_statics_ladder(const struct qg_statics *s, struct qg_statics_workspace *w,
                                 const struct qg_relief *relief, size_t levels, const double *load, double *approach) {
    assert(levels >= 1 && load[0] == 0);
    for (size_t i = 0; i < s->positions; i++) {
        const struct qg_contact_site *site = &s->site[i];
        if (qg_is_stopped(&w->stop))
            return QG_CANCELLED;
        approach[i] = fill_gaps(s, site, relief, w);
        for (size_t j = 1; j < levels; j++) {
            const struct qg_contact_problem problem = {site->n, site->flexibility, w->gap, w->lever, load[j]};
            enum qg_status status = qg_contact_solve(&w->contact, &problem, j > 1);
            if (status != QG_OK)
                return status;
            approach[j * s->positions + i] = w->contact.approach;
        }
    }
    return QG_OK;
}

/* ---- stresses ---------------------------------------------------------------------------------------------------- */

/* Extremes in the roots of one gear: the loads of all points that touch, added up for every tooth within reach. */
static void read_roots(const struct qg_statics *s, size_t position, const struct qg_statics_workspace *w, int gear,
                       struct qg_stresses *out) {
    const struct qg_contact_site *site = &s->site[position];
    struct qg_root_stress tension = {.stress = -INFINITY}, compression = {.stress = INFINITY};
    int turn = gear == QG_PINION ? 1 : -1; /* of the pairs' numbers, counter-clockwise */
    for (int pair = -QG_PAIR_REACH; pair <= QG_PAIR_REACH; pair++) {
        memset(w->stress, 0, s->stress.points[gear] * sizeof *w->stress);
        for (size_t k = 0; k < w->contact.touching; k++) {
            size_t i = (size_t)w->contact.active[k];
            qg_stress_add(&s->stress, gear, turn * (pair - site->point[i].pair), &site->spread[i][gear],
                          -w->contact.load[i], w->stress); /* spreads point outwards, pressure inwards */
        }
        qg_stress_extremes(&s->stress, gear, pair, w->stress, &tension, &compression);
    }
    out->tension[gear][position] = tension;
    out->compression[gear][position] = compression;
}

/* The largest pressure of each pair of teeth, and where. */
static void read_pressures(const struct qg_statics *s, size_t position, const double *load,
                           struct qg_pair_pressure *out) {
    const struct qg_contact_site *site = &s->site[position];
    for (size_t i = 0; i < site->n; i++) {
        const struct qg_contact_point *p = &site->point[i];
        struct qg_pair_pressure *best = &out[p->pair + QG_PAIR_REACH];
        double pressure = qg_contact_pressure(s, site, load, i);
        if (pressure <= best->pressure)
            continue;
        best->pressure = pressure;
        best->path = qg_path_position(s->geometry, qg_statics_position(s, position), p->pair);
        for (int g = 0; g < 2; g++)
            best->radius[g] = p->at.radius[g];
    }
}

enum qg_status qg_statics_stress(const struct qg_statics *s, struct qg_statics_workspace *w,
                                 const struct qg_relief *relief, size_t position, size_t count, const double *load,
                                 struct qg_stresses *const *stresses) {
    const struct qg_contact_site *site = &s->site[position];
    fill_gaps(s, site, relief, w);
    for (size_t k = 0; k < count; k++) {
        const struct qg_contact_problem problem = {site->n, site->flexibility, w->gap, w->lever, load[k]};
        enum qg_status status = qg_contact_solve(&w->contact, &problem, k > 0);
        if (status != QG_OK)
            return status;
        struct qg_pair_pressure *pressure = stresses[k]->pressure + position * QG_PAIR_COUNT;
        memset(pressure, 0, QG_PAIR_COUNT * sizeof *pressure);
        read_pressures(s, position, w->contact.load, pressure);
        for (int g = 0; g < 2; g++)
            read_roots(s, position, w, g, stresses[k]);
    }
    return QG_OK;
}
