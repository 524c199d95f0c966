/* What a job leaves beside its result: its frequency response, and its evaluations one by one; as JSON and as CSV.
 */
#include <math.h>
#include <string.h>

#include "schema/fields.h"
#include "schema/members.h"
#include "schema/result_internal.h"

double qg_pinion_rpm(const struct qg_design_result *design, const struct qg_case_result *one, double frequency_ratio) {
    return frequency_ratio * one->natural_frequency * 60 / design->pair.gears[QG_PINION].teeth;
}

void qg_frequency_ratios_write(struct qg_text *text, const struct qg_job *job) {
    const struct qg_speed_map *speeds = &job->study.analysis.speeds;
    open_member(text, "frequency_ratio", '[');
    for (size_t i = 0; i < speeds->count; i++)
        qg_json_number(text, qg_speed_at(speeds, i));
    qg_json_close(text, ']');
}

void qg_response_write(struct qg_text *text, const struct qg_job *job, const struct qg_case_result *one) {
    const size_t n = job->study.analysis.speeds.count;
    open_member(text, "rms", '[');
    for (size_t i = 0; i < n; i++)
        qg_json_number(text, one->response[i].rms);
    qg_json_close(text, ']');
    open_member(text, "period", '[');
    for (size_t i = 0; i < n; i++)
        qg_json_integer(text, one->response[i].period);
    qg_json_close(text, ']');
}

static void write_response_of(struct qg_text *text, const struct qg_job *job, const struct qg_design_result *design) {
    if (!design || isnan(design->f_dte)) {
        qg_json_null(text);
        return;
    }
    const struct qg_speed_map *speeds = &job->study.analysis.speeds;
    qg_json_open(text, '{');
    number(text, "f_dte", design->f_dte);
    number(text, "half_backlash_um", design->backlash / 2 * um_per_mm);
    open_member(text, "load_cases", '[');
    for (size_t i = 0; i < design->case_count; i++) {
        const struct qg_case_result *one = &design->cases[i];
        qg_json_open(text, '{');
        number(text, "torque_nm", one->torque / nmm_per_nm);
        number(text, "natural_frequency_hz", one->natural_frequency);
        open_member(text, "pinion_rpm", '[');
        for (size_t j = 0; j < speeds->count; j++)
            qg_json_number(text, qg_pinion_rpm(design, one, qg_speed_at(speeds, j)));
        qg_json_close(text, ']');
        qg_response_write(text, job, one);
        qg_json_close(text, '}');
    }
    qg_json_close(text, ']');
    qg_json_close(text, '}');
}

void qg_frequency_response_write(struct qg_text *text, const struct qg_job *job,
                                 const struct qg_pair_geometry *geometry, const struct qg_design_result *design,
                                 const struct qg_design_result *reference) {
    qg_json_open(text, '{');
    number(text, "half_backlash_um", geometry->backlash / 2 * um_per_mm);
    qg_frequency_ratios_write(text, job);
    qg_json_name(text, "design");
    write_response_of(text, job, design);
    qg_json_name(text, "reference");
    write_response_of(text, job, reference);
    qg_json_close(text, '}');
}

/* One field of a CSV row, with what separates it from the next. NaN is an empty field. */
static void csv_number(struct qg_text *text, double value, char end) {
    char out[QG_NUMBER_ROOM];
    if (!isnan(value))
        qg_text_add(text, out, (size_t)qg_number_print(out, value));
    qg_text_add(text, &end, 1);
}

static void csv_text(struct qg_text *text, const char *plain, char end) {
    qg_text_add(text, plain, strlen(plain));
    qg_text_add(text, &end, 1);
}

static void csv_response(struct qg_text *text, const struct qg_job *job, const struct qg_design_result *design,
                         const char *name) {
    const struct qg_speed_map *speeds = &job->study.analysis.speeds;
    if (!design || isnan(design->f_dte))
        return;
    for (size_t i = 0; i < design->case_count; i++)
        for (size_t j = 0; j < speeds->count; j++) {
            const struct qg_case_result *one = &design->cases[i];
            const double ratio = qg_speed_at(speeds, j);
            csv_text(text, name, ',');
            csv_number(text, one->torque / nmm_per_nm, ',');
            csv_number(text, ratio, ',');
            csv_number(text, qg_pinion_rpm(design, one, ratio), ',');
            csv_number(text, one->response[j].rms, ',');
            csv_number(text, one->response[j].period, '\n');
        }
}

void qg_frequency_response_write_csv(struct qg_text *text, const struct qg_job *job,
                                     const struct qg_design_result *design, const struct qg_design_result *reference) {
    csv_text(text, "design,torque_nm,frequency_ratio,pinion_rpm,rms,period", '\n');
    csv_response(text, job, design, "design");
    csv_response(text, job, reference, "reference");
}

/* Evaluations */

/* A ramp that is absent has radius and amplitude 0; no present ramp has a radius of 0. */
static bool parameter_is_there(const struct qg_evaluation *evaluation, unsigned parameter) {
    return evaluation->phase != QG_PHASE_CANDIDATES && evaluation->parameter[parameter & ~1u] > 0;
}

void qg_evaluation_write(struct qg_text *text, const struct qg_evaluation *evaluation) {
    text->comma = false; /* lines stand by themselves */
    qg_json_open(text, '{');
    integer(text, "evaluation", evaluation->number);
    qg_json_name(text, "phase");
    qg_json_string(text, qg_phase_name(evaluation->phase));
    if (evaluation->phase == QG_PHASE_CANDIDATES)
        integer(text, "sample", (size_t)evaluation->parameter[0]);
    open_member(text, "parameters", '{');
    for (unsigned i = 0; i < QG_PARAMETER_COUNT; i++)
        if (parameter_is_there(evaluation, i))
            number(text, qg_parameter_name(i), evaluation->parameter[i]);
    qg_json_close(text, '}');
    number(text, "f_pps_um", evaluation->f_pps * um_per_mm);
    number(text, "f_dte", evaluation->f_dte);
    number(text, "f_dte_percentile", evaluation->f_dte_percentile);
    qg_json_close(text, '}');
    qg_text_add(text, "\n", 1);
    text->comma = false;
}

void qg_evaluation_write_csv(struct qg_text *text, const struct qg_evaluation *evaluation) {
    qg_text_format(text, "%zu,%s,", evaluation->number, qg_phase_name(evaluation->phase));
    for (unsigned i = 0; i < QG_PARAMETER_COUNT; i++)
        csv_number(text, parameter_is_there(evaluation, i) ? evaluation->parameter[i] : NAN, ',');
    csv_number(text, evaluation->f_pps * um_per_mm, ',');
    csv_number(text, evaluation->f_dte, ',');
    csv_number(text, evaluation->f_dte_percentile, '\n');
}

void qg_evaluation_write_csv_header(struct qg_text *text) {
    csv_text(text, "evaluation,phase", ',');
    for (unsigned i = 0; i < QG_PARAMETER_COUNT; i++)
        csv_text(text, qg_parameter_name(i), ',');
    csv_text(text, "f_pps_um,f_dte,f_dte_percentile", '\n');
}
