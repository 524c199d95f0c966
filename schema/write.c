/* The writer of job documents: walks the table of fields (fields.c) over a struct qg_job.
 *
 * It writes every member that the kind of study uses, defaults included. What is absent and means something by that is left
 * out: ramps and search parameters that are not there, the user's own moment of inertia, the reliability of a search. An
 * object of which nothing is left is left out itself.
 */
#include <assert.h>
#include <stdio.h>
#include <string.h>

#include "schema/fields.h"

static void write_object(struct qg_text *text, const struct qg_form *form, const char *base, enum qg_study_kind kind);

static void write_number(struct qg_text *text, const struct qg_field *field, const char *base) {
    const double value = *(const double *)(base + field->offset);
    if (field->need == QG_NEED_NOTHING && value == 0)
        return;
    qg_json_name(text, field->key);
    qg_json_number(text, value);
}

static void write_whole(struct qg_text *text, const struct qg_field *field, const char *base) {
    const char *at = base + field->offset;
    const int64_t value = field->type == QG_FIELD_SIZE   ? (int64_t) * (const size_t *)at
                          : field->type == QG_FIELD_SEED ? (int64_t) * (const uint64_t *)at
                                                         : (int64_t) * (const int *)at;
    qg_json_name(text, field->key);
    qg_json_integer(text, value);
}

static void write_choice(struct qg_text *text, const struct qg_field *field, const char *base) {
    const int choice = *(const int *)(base + field->offset);
    qg_json_name(text, field->key);
    qg_json_string(text, field->choices[choice]);
}

static void write_text(struct qg_text *text, const struct qg_field *field, const char *base) {
    qg_json_name(text, field->key);
    qg_json_string(text, base + field->offset);
}

static void write_labels(struct qg_text *text, const struct qg_field *field, const char *base) {
    const struct qg_job *job = (const struct qg_job *)base;
    qg_json_name(text, field->key);
    qg_json_open(text, '[');
    for (size_t i = 0; i < job->label_count; i++)
        qg_json_string(text, job->labels[i]);
    qg_json_close(text, ']');
}

static void write_load_cases(struct qg_text *text, const struct qg_field *field, const char *base) {
    const struct qg_job *job = (const struct qg_job *)base;
    qg_json_name(text, field->key);
    qg_json_open(text, '[');
    for (size_t i = 0; i < job->study.analysis.case_count; i++) {
        struct qg_load_case one = {.torque_nm = job->given.torque_nm[i]};
        if (one.torque_nm == 0)
            one.torque_fraction = job->study.analysis.torque_fraction[i];
        write_object(text, &qg_load_case_form, (const char *)&one, job->study.kind);
    }
    qg_json_close(text, ']');
}

static void write_range(struct qg_text *text, const struct qg_field *field, const char *base) {
    const struct qg_bounds *bounds = (const struct qg_bounds *)(base + field->offset);
    for (size_t i = 0; i < bounds->count; i++) {
        if (bounds->parameter[i] != (enum qg_parameter)field->fallback)
            continue;
        qg_json_name(text, field->key);
        qg_json_open(text, '[');
        qg_json_number(text, bounds->lower[i]);
        qg_json_number(text, bounds->upper[i]);
        qg_json_close(text, ']');
    }
}

static void write_grid(struct qg_text *text, const struct qg_field *field, const char *base) {
    const struct qg_grid *grid = (const struct qg_grid *)(base + field->offset);
    qg_json_name(text, field->key);
    qg_json_open(text, '[');
    for (size_t i = 0; i < grid->count; i++)
        write_object(text, field->form, (const char *)&grid->axis[i], QG_STUDY_MAP);
    qg_json_close(text, ']');
}

static void write_objectives(struct qg_text *text, const struct qg_field *field, const char *base) {
    const struct qg_objectives *objectives = (const struct qg_objectives *)(base + field->offset);
    qg_json_name(text, field->key);
    qg_json_open(text, '[');
    for (size_t i = 0; i < objectives->count; i++)
        qg_json_string(text, field->choices[objectives->item[i]]);
    qg_json_close(text, ']');
}

static void write_start(struct qg_text *text, const struct qg_field *field, const char *base) {
    const struct qg_speed_map *speeds = (const struct qg_speed_map *)(base + field->offset);
    qg_json_name(text, field->key);
    if (speeds->start_static)
        qg_json_string(text, "static");
    else
        qg_json_number(text, speeds->start_displacement);
}

static void write_interval(struct qg_text *text, const struct qg_field *field, const char *base) {
    const struct qg_interval *interval = (const struct qg_interval *)(base + field->offset);
    const double ends[] = {interval->low, interval->high};
    qg_json_name(text, field->key);
    qg_json_open(text, '[');
    for (int i = 0; i < 2; i++)
        qg_json_number(text, ends[i]);
    qg_json_close(text, ']');
}

static void write_word_or_number(struct qg_text *text, const struct qg_field *field, const char *base) {
    const double value = *(const double *)(base + field->offset);
    qg_json_name(text, field->key);
    if (value == field->fallback)
        qg_json_string(text, field->choices[0]);
    else
        qg_json_number(text, value);
}

typedef void write_function(struct qg_text *text, const struct qg_field *field, const char *base);
static write_function *const writers[QG_FIELD_TYPE_COUNT] = {
    [QG_FIELD_NUMBER] = write_number,
    [QG_FIELD_INT] = write_whole,
    [QG_FIELD_SIZE] = write_whole,
    [QG_FIELD_SEED] = write_whole,
    [QG_FIELD_CHOICE] = write_choice,
    [QG_FIELD_KIND] = write_choice,
    [QG_FIELD_TEXT] = write_text,
    [QG_FIELD_LABELS] = write_labels,
    [QG_FIELD_LOAD_CASES] = write_load_cases,
    [QG_FIELD_RANGE] = write_range,
    [QG_FIELD_START] = write_start,
    [QG_FIELD_GRID] = write_grid,
    [QG_FIELD_INTERVAL] = write_interval,
    [QG_FIELD_INTERVAL_OF_WHOLES] = write_interval,
    [QG_FIELD_WORD_OR_NUMBER] = write_word_or_number,
    [QG_FIELD_OBJECTIVES] = write_objectives,
};

/* A member that is an object; taken back when there was nothing to write in it. */
static void write_member_object(struct qg_text *text, const struct qg_field *field, const char *base,
                                enum qg_study_kind kind) {
    const struct qg_form *form = field->form;
    const char *inner = base + field->offset;
    if (form->has_presence && !*(const bool *)(inner + form->presence))
        return;
    const size_t length = text->length;
    const bool comma = text->comma;
    qg_json_name(text, field->key);
    write_object(text, form, inner, kind);
    if (!text->failed && memcmp(text->data + text->length - 2, "{}", 2) == 0) {
        text->length = length;
        text->data[length] = '\0';
        text->comma = comma;
    }
}

/* The reliability of a search is asked for or not, objectives are one or several, and a search method has its own
 * parameters; all other members that the kind uses are there. base is a struct qg_job or a struct qg_optimizer where the
 * field says so. */
static bool is_there(const struct qg_field *field, const char *base) {
    if (field->methods)
        return (field->methods & 1u << ((const struct qg_optimizer *)base)->method) != 0;
    if (strcmp(field->key, "reliability") == 0)
        return ((const struct qg_job *)base)->study.reliability.samples > 0;
    if (strcmp(field->key, "objective") == 0)
        return ((const struct qg_job *)base)->study.objectives.count == 0;
    return strcmp(field->key, "objectives") != 0 || ((const struct qg_job *)base)->study.objectives.count > 0;
}

static void write_object(struct qg_text *text, const struct qg_form *form, const char *base, enum qg_study_kind kind) {
    qg_json_open(text, '{');
    for (size_t i = 0; i < form->count; i++) {
        const struct qg_field *field = &form->fields[i];
        if (!qg_field_used(field, kind) || !is_there(field, base))
            continue;
        if (field->type == QG_FIELD_OBJECT)
            write_member_object(text, field, base, kind);
        else
            writers[field->type](text, field, base);
    }
    qg_json_close(text, '}');
}

void qg_document_write(struct qg_text *text, const struct qg_job *job) {
    write_object(text, &qg_document_form, (const char *)job, job->study.kind);
}

void qg_pair_write(struct qg_text *text, const struct qg_job *job, const struct qg_gear_pair *pair,
                   double pressure_angle_deg, const char *name) {
    const struct qg_field *field = qg_form_find(&qg_document_form, "gear_pair");
    struct qg_job other = *job;
    other.study.pair = *pair;
    other.given.pressure_angle_deg = pressure_angle_deg;
    snprintf(other.pair_name, sizeof other.pair_name, "%s", name);
    write_object(text, field->form, (const char *)&other, QG_STUDY_OPTIMIZE);
}

void qg_relief_write(struct qg_text *text, const struct qg_relief *relief) {
    const struct qg_field *field = qg_form_find(&qg_document_form, "relief");
    write_object(text, field->form, (const char *)relief, QG_STUDY_EVALUATE);
}
