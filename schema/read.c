/* The reader of parsed job documents: the last of the three passes of read_bytes.c.
 *
 * A walk over the objects along the table of fields (fields.c), which fills the structs and reports what is wrong. It never
 * stops at a fault: the user gets them all at once. Core's own check of the study comes last, when the document itself is in
 * order, because its words would make no sense for half a study; of a document with faults elsewhere the gear pair is
 * checked alone.
 *
 * Structs are written through (base of the object's struct) + (offset in the field), as the table's types say.
 */
#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "schema/faults.h"
#include "schema/fields.h"
#include "schema/read.h"
#include "schema/words.h"

enum { KIND_UNKNOWN = -1, METHOD_UNKNOWN = -1 };

struct reader {
    struct qg_job *job;
    struct qg_faults *faults;
    struct qg_path path;
    int kind;   /* enum qg_study_kind, or KIND_UNKNOWN */
    int method; /* enum qg_search_method, or METHOD_UNKNOWN */
};

static void read_object(struct reader *r, const struct qg_form *form, const cJSON *item, char *base);
static void set_defaults(const struct reader *r, const struct qg_form *form, char *base);

/* Faults */

/* "found this, allowed that" at the current place. */
static void refuse(struct reader *r, const struct qg_field *field, const cJSON *item) {
    char is[QG_QUOTE_ROOM], words[QG_WORDS_ROOM];
    qg_faults_add(r->faults, r->path.text, "found %s, allowed %s", qg_found_words(item, is),
                  qg_allowed_words(field, words));
}

static void refuse_unknown_key(struct reader *r, const struct qg_form *form, const char *key) {
    char quoted[QG_QUOTE_ROOM], keys[240] = "";
    if (r->faults->count == QG_FAULTS_ROOM) {
        r->faults->lost++;
        return;
    }
    const char *nearest = qg_nearest_key(form, key);
    for (size_t i = 0, length = 0; i < form->count && length < sizeof keys && !nearest; i++)
        length += (size_t)snprintf(keys + length, sizeof keys - length, "%s%s", i ? ", " : "", form->fields[i].key);
    if (nearest)
        qg_faults_add(r->faults, r->path.text, "found the unknown key %s, did you mean \"%s\"?", qg_quote(quoted, key),
                      nearest);
    else
        qg_faults_add(r->faults, r->path.text, "found the unknown key %s, allowed %s", qg_quote(quoted, key), keys);
}

/* A key that studies of this kind have no use for. */
static void refuse_unused_key(struct reader *r, const struct qg_field *field) {
    char users[QG_WORDS_ROOM] = "";
    for (unsigned kind = QG_STUDY_EVALUATE; kind < QG_STUDY_KIND_COUNT; kind++)
        if (qg_field_used(field, kind))
            snprintf(users + strlen(users), sizeof users - strlen(users), "%s\"%s\"", users[0] ? " or " : "",
                     qg_kind_name(kind));
    qg_faults_add(r->faults, r->path.text, "found a key that kind \"%s\" does not use, allowed with %s only",
                  qg_kind_name((enum qg_study_kind)r->kind), users);
}

/* A key that the chosen search method has no use for. */
static void refuse_unused_by_method(struct reader *r, const struct qg_field *field) {
    for (unsigned method = 0; method < QG_SEARCH_METHOD_COUNT; method++)
        if (field->methods & 1u << method)
            qg_faults_add(r->faults, r->path.text, "found a key that method \"%s\" does not use, allowed with \"%s\"",
                          qg_method_name((enum qg_search_method)r->method), qg_method_name(method));
}

/* Values */

static bool in_range(const struct qg_field *field, double value) {
    return value >= field->low && value <= field->high;
}

/* A number within the field's range; reports what is wrong with it. */
static bool take_number(struct reader *r, const struct qg_field *field, const cJSON *item, double *value) {
    char is[QG_QUOTE_ROOM], words[QG_WORDS_ROOM];
    if (!cJSON_IsNumber(item)) {
        refuse(r, field, item);
        return false;
    }
    *value = item->valuedouble;
    if (in_range(field, *value))
        return true;
    qg_faults_add(r->faults, r->path.text, "found %s, allowed %s", qg_found_words(item, is),
                  qg_range_words(field, words));
    return false;
}

static void read_number(struct reader *r, const struct qg_field *field, const cJSON *item, char *base) {
    double value;
    if (take_number(r, field, item, &value))
        *(double *)(base + field->offset) = value;
}

/* Puts a whole number where the table says, in the type it says. */
static void store_whole(const struct qg_field *field, double value, char *base) {
    char *at = base + field->offset;
    if (field->type == QG_FIELD_SIZE)
        *(size_t *)at = (size_t)value;
    else if (field->type == QG_FIELD_SEED)
        *(uint64_t *)at = (uint64_t)value;
    else
        *(int *)at = (int)value;
}

static void read_whole(struct reader *r, const struct qg_field *field, const cJSON *item, char *base) {
    double value;
    if (!take_number(r, field, item, &value))
        return;
    if (value == floor(value))
        store_whole(field, value, base);
    else
        refuse(r, field, item);
}

/* The index of the item's word in the field's choices; -1 when it is none of them. */
static int choice_of(const struct qg_field *field, const cJSON *item) {
    for (int i = 0; cJSON_IsString(item) && field->choices[i]; i++)
        if (strcmp(field->choices[i], item->valuestring) == 0)
            return i;
    return -1;
}

static void read_choice(struct reader *r, const struct qg_field *field, const cJSON *item, char *base) {
    const int choice = choice_of(field, item);
    if (choice < 0)
        refuse(r, field, item);
    else if (field->type == QG_FIELD_CHOICE)
        *(int *)(base + field->offset) = choice;
}

/* Copies a string of low to high characters without control characters; `room` is 4 * high + 1 bytes. */
static void take_text(struct reader *r, const cJSON *item, size_t low, size_t high, char *out) {
    char is[QG_QUOTE_ROOM];
    size_t characters = 0;
    bool control = false;
    if (!cJSON_IsString(item)) {
        qg_faults_add(r->faults, r->path.text, "found %s, allowed a string of %zu to %zu characters",
                      qg_found_words(item, is), low, high);
        return;
    }
    for (const char *at = item->valuestring; *at; at++) {
        control = control || (unsigned char)*at < 0x20 || *at == 0x7f;
        characters += ((unsigned char)*at & 0xc0) != 0x80;
    }
    if (characters < low || characters > high)
        qg_faults_add(r->faults, r->path.text, "found %zu characters, allowed %zu to %zu", characters, low, high);
    else if (control)
        qg_faults_add(r->faults, r->path.text, "found a control character in %s, allowed printable ones",
                      qg_found_words(item, is));
    else
        memcpy(out, item->valuestring, strlen(item->valuestring) + 1);
}

static void read_text(struct reader *r, const struct qg_field *field, const cJSON *item, char *base) {
    take_text(r, item, 0, (size_t)field->high, base + field->offset);
}

static void read_labels(struct reader *r, const struct qg_field *field, const cJSON *item, char *base) {
    struct qg_job *job = r->job;
    const cJSON *label;
    (void)base;
    if (!cJSON_IsArray(item) || cJSON_GetArraySize(item) > QG_LABELS_MAX) {
        refuse(r, field, item);
        return;
    }
    cJSON_ArrayForEach(label, item) {
        const size_t n = job->label_count, mark = qg_path_push_index(&r->path, n);
        take_text(r, label, 1, QG_LABEL_MAX, job->labels[n]);
        for (size_t i = 0; i < n; i++)
            if (job->labels[n][0] && strcmp(job->labels[i], job->labels[n]) == 0)
                qg_faults_add(r->faults, r->path.text, "found the label of item %zu again, allowed once", i);
        job->label_count++;
        qg_path_pop(&r->path, mark);
    }
}

/* One load case: exactly one of its members. A torque in N m becomes a fraction later, when the nominal one is known. */
static void read_load_case(struct reader *r, const cJSON *item, size_t i) {
    struct qg_load_case one = {0};
    const size_t faults = r->faults->count + r->faults->lost;
    read_object(r, &qg_load_case_form, item, (char *)&one);
    if (r->faults->count + r->faults->lost > faults)
        return;
    if ((one.torque_fraction > 0) == (one.torque_nm > 0))
        qg_faults_add(r->faults, r->path.text, "found %s torque_fraction %s torque_nm, allowed exactly one of them",
                      one.torque_nm > 0 ? "both" : "neither", one.torque_nm > 0 ? "and" : "nor");
    r->job->study.analysis.torque_fraction[i] = one.torque_fraction;
    r->job->given.torque_nm[i] = one.torque_nm;
}

static void read_load_cases(struct reader *r, const struct qg_field *field, const cJSON *item, char *base) {
    struct qg_analysis *analysis = &r->job->study.analysis;
    const int n = cJSON_GetArraySize(item);
    const cJSON *one;
    size_t i = 0;
    (void)base;
    if (!cJSON_IsArray(item)) {
        refuse(r, field, item);
        return;
    }
    if (n < 1 || n > QG_CASES_MAX) {
        qg_faults_add(r->faults, r->path.text, "found %d load cases, allowed 1 to %d", n, QG_CASES_MAX);
        return;
    }
    cJSON_ArrayForEach(one, item) {
        const size_t mark = qg_path_push_index(&r->path, i);
        read_load_case(r, one, i++);
        qg_path_pop(&r->path, mark);
    }
    analysis->case_count = i;
}

static void read_grid(struct reader *r, const struct qg_field *field, const cJSON *item, char *base) {
    struct qg_grid *grid = (struct qg_grid *)(base + field->offset);
    const int n = cJSON_GetArraySize(item);
    const cJSON *one;
    if (!cJSON_IsArray(item)) {
        refuse(r, field, item);
        return;
    }
    if (n < 1 || n > QG_AXES_MAX) {
        qg_faults_add(r->faults, r->path.text, "found %d axes, allowed 1 to %d", n, QG_AXES_MAX);
        return;
    }
    cJSON_ArrayForEach(one, item) {
        const size_t mark = qg_path_push_index(&r->path, grid->count);
        char *axis = (char *)&grid->axis[grid->count++];
        set_defaults(r, field->form, axis);
        read_object(r, field->form, one, axis);
        qg_path_pop(&r->path, mark);
    }
}

/* Keeps the box's parameters ascending, in whatever order the document names them. */
static void insert_bounds(struct qg_bounds *bounds, enum qg_parameter parameter, const double limits[2]) {
    size_t at = bounds->count++;
    assert(bounds->count <= QG_PARAMETER_COUNT);
    for (; at > 0 && bounds->parameter[at - 1] > parameter; at--) {
        bounds->parameter[at] = bounds->parameter[at - 1];
        bounds->lower[at] = bounds->lower[at - 1];
        bounds->upper[at] = bounds->upper[at - 1];
    }
    bounds->parameter[at] = parameter;
    bounds->lower[at] = limits[0];
    bounds->upper[at] = limits[1];
}

/* Two numbers within the field's range; reports what is wrong with them. */
static bool take_two_numbers(struct reader *r, const struct qg_field *field, const cJSON *item, double out[2]) {
    if (!cJSON_IsArray(item) || cJSON_GetArraySize(item) != 2) {
        refuse(r, field, item);
        return false;
    }
    bool good = true;
    for (int i = 0; i < 2; i++) {
        const size_t mark = qg_path_push_index(&r->path, (size_t)i);
        const struct qg_field one = {.type = QG_FIELD_NUMBER, .low = field->low, .high = field->high};
        good &= take_number(r, &one, cJSON_GetArrayItem(item, i), &out[i]);
        qg_path_pop(&r->path, mark);
    }
    return good;
}

static void refuse_order(struct reader *r, const double limits[2], const char *allowed_order) {
    char lower[QG_NUMBER_ROOM], upper[QG_NUMBER_ROOM];
    qg_number_print(lower, limits[0]);
    qg_number_print(upper, limits[1]);
    qg_faults_add(r->faults, r->path.text, "found [%s, %s], allowed a lower limit %s the upper one", lower, upper,
                  allowed_order);
}

static void read_range(struct reader *r, const struct qg_field *field, const cJSON *item, char *base) {
    double limits[2];
    if (!take_two_numbers(r, field, item, limits))
        return;
    if (limits[0] < limits[1])
        insert_bounds((struct qg_bounds *)(base + field->offset), (enum qg_parameter)field->fallback, limits);
    else
        refuse_order(r, limits, "below");
}

static void read_interval(struct reader *r, const struct qg_field *field, const cJSON *item, char *base) {
    double limits[2];
    if (!take_two_numbers(r, field, item, limits))
        return;
    if (field->type == QG_FIELD_INTERVAL_OF_WHOLES && (limits[0] != floor(limits[0]) || limits[1] != floor(limits[1])))
        refuse(r, field, item);
    else if (limits[0] <= limits[1])
        *(struct qg_interval *)(base + field->offset) = (struct qg_interval){limits[0], limits[1]};
    else
        refuse_order(r, limits, "not above");
}

static void read_word_or_number(struct reader *r, const struct qg_field *field, const cJSON *item, char *base) {
    const bool number = cJSON_IsNumber(item);
    if (number)
        read_number(r, field, item, base);
    else if (cJSON_IsString(item) && strcmp(item->valuestring, field->choices[0]) == 0)
        *(double *)(base + field->offset) = field->fallback;
    else
        refuse(r, field, item);
}

static void read_objectives(struct reader *r, const struct qg_field *field, const cJSON *item, char *base) {
    struct qg_objectives *objectives = (struct qg_objectives *)(base + field->offset);
    const int n = cJSON_GetArraySize(item);
    const cJSON *one;
    if (!cJSON_IsArray(item) || n < field->low || n > field->high) {
        refuse(r, field, item);
        return;
    }
    cJSON_ArrayForEach(one, item) {
        const size_t mark = qg_path_push_index(&r->path, objectives->count);
        const struct qg_field word = {.type = QG_FIELD_CHOICE, .choices = field->choices};
        const int choice = choice_of(field, one);
        if (choice < 0)
            refuse(r, &word, one);
        for (size_t i = 0; i < objectives->count && choice >= 0; i++)
            if (objectives->item[i] == (enum qg_objective)choice)
                qg_faults_add(r->faults, r->path.text, "found the objective of item %zu again, allowed once", i);
        objectives->item[objectives->count++] = choice < 0 ? QG_OBJECTIVE_COUNT : (enum qg_objective)choice;
        qg_path_pop(&r->path, mark);
    }
}

static void read_start(struct reader *r, const struct qg_field *field, const cJSON *item, char *base) {
    struct qg_speed_map *speeds = (struct qg_speed_map *)(base + field->offset);
    if (cJSON_IsString(item) && strcmp(item->valuestring, "static") == 0)
        return; /* the default */
    if (take_number(r, field, item, &speeds->start_displacement))
        speeds->start_static = 0;
}

static void read_member_object(struct reader *r, const struct qg_field *field, const cJSON *item, char *base) {
    read_object(r, field->form, item, base + field->offset);
}

typedef void read_function(struct reader *r, const struct qg_field *field, const cJSON *item, char *base);
static read_function *const readers[QG_FIELD_TYPE_COUNT] = {
    [QG_FIELD_NUMBER] = read_number,
    [QG_FIELD_INT] = read_whole,
    [QG_FIELD_SIZE] = read_whole,
    [QG_FIELD_SEED] = read_whole,
    [QG_FIELD_CHOICE] = read_choice,
    [QG_FIELD_TEXT] = read_text,
    [QG_FIELD_KIND] = read_choice,
    [QG_FIELD_OBJECT] = read_member_object,
    [QG_FIELD_LABELS] = read_labels,
    [QG_FIELD_RANGE] = read_range,
    [QG_FIELD_GRID] = read_grid,
    [QG_FIELD_OBJECTIVES] = read_objectives,
    [QG_FIELD_START] = read_start,
    [QG_FIELD_INTERVAL] = read_interval,
    [QG_FIELD_INTERVAL_OF_WHOLES] = read_interval,
    [QG_FIELD_WORD_OR_NUMBER] = read_word_or_number,
    [QG_FIELD_LOAD_CASES] = read_load_cases,
};

/* Objects */

static void read_member(struct reader *r, const struct qg_form *form, const cJSON *item, char *base) {
    const struct qg_field *field = qg_form_find(form, item->string);
    const size_t mark = qg_path_push(&r->path, item->string);
    if (!field)
        refuse_unknown_key(r, form, item->string);
    else if (r->kind != KIND_UNKNOWN && !qg_field_used(field, (enum qg_study_kind)r->kind))
        refuse_unused_key(r, field);
    else if (field->methods && r->method != METHOD_UNKNOWN && !(field->methods & 1u << r->method))
        refuse_unused_by_method(r, field);
    else
        readers[field->type](r, field, item, base);
    qg_path_pop(&r->path, mark);
}

static void check_presence(struct reader *r, const struct qg_field *field, const cJSON *object) {
    char words[QG_WORDS_ROOM];
    const bool required = r->kind == KIND_UNKNOWN ? field->need == QG_NEED_REQUIRED
                                                  : qg_field_required(field, (enum qg_study_kind)r->kind);
    if (!required || cJSON_GetObjectItemCaseSensitive(object, field->key))
        return;
    const size_t mark = qg_path_push(&r->path, field->key);
    qg_faults_add(r->faults, r->path.text, "found nothing, allowed %s", qg_allowed_words(field, words));
    qg_path_pop(&r->path, mark);
}

static void read_object(struct reader *r, const struct qg_form *form, const cJSON *item, char *base) {
    char is[QG_QUOTE_ROOM];
    const cJSON *member;
    if (!cJSON_IsObject(item)) {
        qg_faults_add(r->faults, r->path.text, "found %s, allowed an object", qg_found_words(item, is));
        return;
    }
    if (form->has_presence)
        *(bool *)(base + form->presence) = true;
    cJSON_ArrayForEach(member, item) {
        read_member(r, form, member, base);
    }
    for (size_t i = 0; i < form->count; i++)
        check_presence(r, &form->fields[i], item);
}

/* The document as a whole */

static void set_defaults(const struct reader *r, const struct qg_form *form, char *base) {
    for (size_t i = 0; i < form->count; i++) {
        const struct qg_field *field = &form->fields[i];
        if (r->kind == KIND_UNKNOWN || !qg_field_used(field, (enum qg_study_kind)r->kind))
            continue;
        if (field->type == QG_FIELD_OBJECT)
            set_defaults(r, field->form, base + field->offset);
        else if (field->type == QG_FIELD_START)
            ((struct qg_speed_map *)(base + field->offset))->start_static = 1;
        else if (field->type == QG_FIELD_INTERVAL || field->type == QG_FIELD_INTERVAL_OF_WHOLES)
            *(struct qg_interval *)(base + field->offset) = (struct qg_interval){NAN, NAN};
        else if (field->need != QG_NEED_DEFAULT)
            continue;
        else if (field->type == QG_FIELD_NUMBER || field->type == QG_FIELD_WORD_OR_NUMBER)
            *(double *)(base + field->offset) = field->fallback;
        else
            store_whole(field, field->fallback, base);
    }
}

static bool has(const cJSON *root, const char *object, const char *key) {
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(root, object);
    return item && (!key || cJSON_GetObjectItemCaseSensitive(item, key));
}

/* Defaults that depend on what the document says elsewhere. */
static void set_dependent_defaults(struct reader *r, const cJSON *root) {
    struct qg_study *study = &r->job->study;
    struct qg_analysis *analysis = &study->analysis;
    static const double usual[] = {0.33, 0.66, 1};
    if (!has(root, "load_cases", NULL)) {
        analysis->case_count = sizeof usual / sizeof *usual;
        memcpy(analysis->torque_fraction, usual, sizeof usual);
    }
    const int most = (analysis->mesh_positions - 1) / 2;
    if (!has(root, "analysis", "harmonics") && analysis->harmonics > most)
        analysis->harmonics = most;
    if (!has(root, "reliability", NULL))
        study->reliability = (struct qg_reliability){0};
}

/* Keys of which only one may be given. */
static void check_alternatives(struct reader *r, const cJSON *root) {
    if (has(root, "objective", NULL) && has(root, "objectives", NULL))
        qg_faults_add(r->faults, "/objectives", "found both objective and objectives, allowed one of them");
}

/* The search method, which decides what the optimizer's other members mean. */
static int method_of(const cJSON *root) {
    const struct qg_field *optimizer = qg_form_find(&qg_document_form, "optimizer");
    const struct qg_field *method = qg_form_find(optimizer->form, "method");
    const cJSON *given = cJSON_GetObjectItemCaseSensitive(root, "optimizer");
    return has(root, "optimizer", "method") ? choice_of(method, cJSON_GetObjectItemCaseSensitive(given, "method"))
                                            : (int)method->fallback;
}

/* What the kind of study needs beyond its keys: something to move, or something to vary. */
static void check_kind(struct reader *r) {
    const struct qg_study *study = &r->job->study;
    bool ramps = false;
    for (int i = 0; i < 2; i++)
        ramps = ramps || study->relief.gears[i].tip.present || study->relief.gears[i].root.present;
    if (study->kind == QG_STUDY_OPTIMIZE && study->bounds.count == 0)
        qg_faults_add(r->faults, "/relief_bounds", "found no parameter, allowed 1 to %d of them", QG_PARAMETER_COUNT);
    if (study->kind == QG_STUDY_RELIABILITY && !ramps)
        qg_faults_add(r->faults, "/relief",
                      "found no tip and no root relief, allowed at least one: they are what varies");
}

/* Into core's units: the one place. */
static void convert_units(struct qg_job *job) {
    const struct qg_given *given = &job->given;
    struct qg_gear_pair *pair = &job->study.pair;
    pair->rack.pressure_angle = given->pressure_angle_deg * (M_PI / 180);
    pair->material.density = given->density_kg_per_m3 * 1e-9; /* kg/m3 to kg/mm3 */
    pair->nominal_torque = given->nominal_torque_nm * 1e3;    /* N m to N mm */
    for (size_t i = 0; i < job->study.analysis.case_count; i++)
        if (given->torque_nm[i] > 0)
            job->study.analysis.torque_fraction[i] = given->torque_nm[i] / given->nominal_torque_nm;
}

/* Load cases given in N m, against the range of fractions. Needs the nominal torque. */
static void check_torques(struct reader *r) {
    const struct qg_job *job = r->job;
    const struct qg_field *fraction = qg_form_find(&qg_load_case_form, "torque_fraction");
    for (size_t i = 0; i < job->study.analysis.case_count; i++) {
        char pointer[QG_POINTER_ROOM], words[QG_WORDS_ROOM];
        if (!(job->given.torque_nm[i] > 0) || in_range(fraction, job->study.analysis.torque_fraction[i]))
            continue;
        snprintf(pointer, sizeof pointer, "/load_cases/%zu/torque_nm", i);
        qg_faults_add(r->faults, pointer, "found %g times the nominal torque, allowed %s times",
                      job->study.analysis.torque_fraction[i], qg_range_words(fraction, words));
    }
}

/* Defaults that core derives from a pair that can run; of another one there is nothing to derive. */
static void complete_macro(struct qg_study *study) {
    struct qg_pair_geometry geometry;
    if (study->kind == QG_STUDY_MACRO && qg_pair_derive(&study->pair, &geometry, NULL) == QG_OK)
        qg_macro_complete(&study->macro, &study->pair, geometry.backlash);
}

/* Core's notes as faults. */
static void add_notes(struct qg_faults *faults, const struct qg_notes *notes) {
    for (size_t i = 0; i < notes->count; i++) {
        char pointer[QG_POINTER_ROOM];
        qg_document_pointer(notes->item[i].where, pointer);
        qg_faults_add(faults, pointer, "%s", notes->item[i].text);
    }
    faults->lost += notes->lost;
}

/* True when no fault so far is about the gear pair, so that core can judge it. */
static bool pair_is_read(const struct qg_faults *faults, const cJSON *root) {
    static const char prefix[] = "/gear_pair";
    for (size_t i = 0; i < faults->count; i++)
        if (strncmp(faults->item[i].pointer, prefix, sizeof prefix - 1) == 0)
            return false;
    return faults->lost == 0 && has(root, "gear_pair", NULL);
}

/* What only core can judge. */
static void check_with_core(struct reader *r, const cJSON *root, struct qg_notes *warnings) {
    struct qg_notes errors = {0};
    const struct qg_study *study = &r->job->study;
    struct qg_pair_geometry geometry;
    if (r->faults->count == 0)
        qg_study_check(study, NULL, &errors, warnings);
    else if (pair_is_read(r->faults, root))
        qg_pair_derive(&study->pair, &geometry, &errors);
    add_notes(r->faults, &errors);
}

static void read_document(struct reader *r, const cJSON *root, struct qg_notes *warnings) {
    const struct qg_field *kind = qg_form_find(&qg_document_form, "kind");
    r->kind = choice_of(kind, cJSON_GetObjectItemCaseSensitive(root, "kind"));
    if (r->kind != KIND_UNKNOWN)
        r->job->study.kind = (enum qg_study_kind)r->kind;
    r->method = method_of(root);
    set_defaults(r, &qg_document_form, (char *)r->job);
    read_object(r, &qg_document_form, root, (char *)r->job);
    if (!cJSON_IsObject(root))
        return;
    set_dependent_defaults(r, root);
    convert_units(r->job);
    check_alternatives(r, root);
    if (pair_is_read(r->faults, root)) {
        check_torques(r);
        complete_macro(&r->job->study);
    }
    if (r->faults->count == 0)
        check_kind(r);
    check_with_core(r, root, warnings);
}

void qg_tree_read(const cJSON *root, struct qg_job *job, struct qg_faults *faults, struct qg_notes *warnings) {
    struct reader reader = {.job = job, .faults = faults, .kind = KIND_UNKNOWN};
    read_document(&reader, root, warnings);
}
