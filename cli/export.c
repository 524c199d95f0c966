/* quietgear export: a gear pair at one mesh position and torque, written down for another program. */
#include <errno.h>
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli/commands.h"
#include "cli/files.h"
#include "cli/job.h"
#include "cli/words.h"
#include "core/deck.h"
#include "core/field.h"
#include "core/pool.h"
#include "schema/abaqus.h"
#include "schema/drawing.h"
#include "schema/field.h"

/* What is asked for, made out of the options. */
struct request {
    const struct qg_options *options;
    const struct qg_job *job;
    struct qg_pair_geometry geometry;
    double position; /* mesh periods */
    double fraction; /* of the nominal torque */
};

/* Does the work and appends the file to text. */
typedef enum qg_status writer(const struct request *request, struct qg_text *text, struct qg_notes *notes);

/* ---- formats ---------------------------------------------------------------------------------------------------- */

static enum qg_status write_abaqus(const struct request *r, struct qg_text *text, struct qg_notes *notes) {
    const struct qg_study *study = &r->job->study;
    const struct qg_deck_plan plan = {.pair = &study->pair,
                                      .geometry = &r->geometry,
                                      .relief = &study->relief,
                                      .plane = study->analysis.plane,
                                      .bore = study->analysis.bore,
                                      .refinement = study->analysis.mesh_refinement,
                                      .position = r->position,
                                      .torque = r->fraction * study->pair.nominal_torque};
    struct qg_deck deck;
    enum qg_status status = qg_deck_init(&deck, &plan, notes);
    if (status == QG_OK)
        qg_abaqus_write(text, r->job, &deck);
    qg_deck_finish(&deck);
    return status;
}

/* The full field, written by `write`. */
static enum qg_status write_field(const struct request *r, struct qg_text *text, struct qg_notes *notes,
                                  void (*write)(struct qg_text *text, const struct qg_field *field)) {
    const struct qg_study *study = &r->job->study;
    const struct qg_field_plan plan = {.pair = &study->pair,
                                       .analysis = &study->analysis,
                                       .relief = &study->relief,
                                       .position = r->position,
                                       .torque_fraction = r->fraction};
    struct qg_pool *pool = qg_pool_create(r->options->threads == 1 ? 1 : 2); /* the two gears side by side */
    if (!pool)
        return QG_OUT_OF_MEMORY;
    const struct qg_means means = {.executor = qg_pool_executor(pool)};
    struct qg_field field;
    enum qg_status status = qg_field_compute(&field, &plan, &means, notes);
    if (status == QG_OK)
        write(text, &field);
    qg_field_finish(&field);
    qg_pool_destroy(pool);
    return status;
}

static enum qg_status write_vtk(const struct request *r, struct qg_text *text, struct qg_notes *notes) {
    return write_field(r, text, notes, qg_field_write_vtk);
}

static enum qg_status write_gmsh(const struct request *r, struct qg_text *text, struct qg_notes *notes) {
    return write_field(r, text, notes, qg_field_write_gmsh);
}

static enum qg_status write_json(const struct request *r, struct qg_text *text, struct qg_notes *notes) {
    return write_field(r, text, notes, qg_field_write);
}

static enum qg_status write_dxf(const struct request *r, struct qg_text *text, struct qg_notes *notes) {
    (void)notes;
    qg_dxf_write(text, r->job, QG_EXTENT_GEARS, r->position);
    return QG_OK;
}

static enum qg_status write_dxf_spaces(const struct request *r, struct qg_text *text, struct qg_notes *notes) {
    (void)notes;
    qg_dxf_write(text, r->job, QG_EXTENT_SPACES, r->position);
    return QG_OK;
}

static const struct format {
    const char *name;
    writer *write;
    bool has_position, has_load; /* whether these options mean anything to it */
} formats[] = {
    {"abaqus", write_abaqus, true, true}, {"vtk", write_vtk, true, true},
    {"gmsh", write_gmsh, true, true},     {"json", write_json, true, true},
    {"dxf", write_dxf, true, false},      {"dxf-spaces", write_dxf_spaces, false, false},
};

static const struct format *find_format(const char *name) {
    for (size_t i = 0; i < sizeof formats / sizeof *formats; i++)
        if (name && strcmp(formats[i].name, name) == 0)
            return &formats[i];
    return NULL;
}

/* ---- the command line ------------------------------------------------------------------------------------------- */

static int refuse(const char *option, const char *found, const char *allowed) {
    fprintf(stderr, "quietgear: %s: %s%s, allowed %s\n", option, found ? "found " : "not given", found ? found : "",
            allowed);
    return QG_EXIT_WRONG_INPUT;
}

/* A number of the whole text within low .. high; NAN otherwise. */
static double parse_number(const char *text, double low, double high) {
    char *end;
    double value = strtod(text, &end);
    return end == text || *end || !(value >= low && value <= high) ? NAN : value;
}

/* The number of a load case, 0 .. count - 1; -1 otherwise. */
static long parse_index(const char *text, size_t count) {
    char *end;
    errno = 0;
    long value = strtol(text, &end, 10);
    return end == text || *end || errno || value < 0 || (size_t)value >= count ? -1 : value;
}

/* The share of the nominal torque that is asked for; an exit status. */
static int choose_fraction(const struct qg_options *options, const struct qg_analysis *analysis, double *fraction) {
    *fraction = 0;
    for (size_t k = 0; k < analysis->case_count; k++)
        *fraction = fmax(*fraction, analysis->torque_fraction[k]);
    if (options->torque_fraction) {
        *fraction = parse_number(options->torque_fraction, 0.001, 10);
        if (isnan(*fraction))
            return refuse("--torque-fraction", options->torque_fraction, "0.001 to 10");
    }
    if (options->load_case) {
        char allowed[64];
        long index = parse_index(options->load_case, analysis->case_count);
        snprintf(allowed, sizeof allowed, "0 to %zu, the places in /load_cases", analysis->case_count - 1);
        if (index < 0)
            return refuse("--load-case", options->load_case, allowed);
        *fraction = analysis->torque_fraction[index];
    }
    return QG_EXIT_DONE;
}

/* ---- the work --------------------------------------------------------------------------------------------------- */

static int export_to(const struct request *request, struct qg_output *output) {
    struct qg_notes notes = {0};
    struct qg_text text = {0};
    enum qg_status status = find_format(request->options->format)->write(request, &text, &notes);
    int exit_status = QG_EXIT_FAILED;
    if (status == QG_OK)
        exit_status = qg_deliver(&text, output);
    else
        fprintf(stderr, "quietgear: %s%s%s\n", qg_status_text(status), notes.count ? ": " : "",
                notes.count ? notes.item[0].text : "");
    qg_text_finish(&text);
    return exit_status;
}

static int export_job(const struct qg_options *options, const struct qg_job *job) {
    struct request request = {.options = options, .job = job};
    struct qg_output output;
    request.position = options->position ? parse_number(options->position, 0, 1) : 0.5;
    int status = choose_fraction(options, &job->study.analysis, &request.fraction);
    if (status != QG_EXIT_DONE)
        return status;
    qg_pair_derive(&job->study.pair, &request.geometry, NULL); /* the reader has found it possible */
    if (!qg_output_open(&output, options->result_path)) {
        fprintf(stderr, "%s: %s\n", options->result_path, strerror(errno));
        return QG_EXIT_FAILED;
    }
    status = export_to(&request, &output);
    qg_output_discard(&output);
    return status;
}

int qg_command_export(const struct qg_options *options) {
    static const char allowed[] = "abaqus, vtk, gmsh, json, dxf or dxf-spaces";
    const struct format *format = find_format(options->format);
    if (!format)
        return refuse("--format", options->format, allowed);
    if (options->position && !format->has_position)
        return refuse("--position", options->position, "only with formats that show the pair in mesh");
    if (options->torque_fraction && !format->has_load)
        return refuse("--torque-fraction", options->torque_fraction, "only with formats that have loads");
    if (options->load_case && !format->has_load)
        return refuse("--load-case", options->load_case, "only with formats that have loads");
    if (options->position && isnan(parse_number(options->position, 0, 1)))
        return refuse("--position", options->position, "0 to 1");
    if (options->torque_fraction && options->load_case)
        return refuse("--load-case", options->load_case, "only without --torque-fraction");
    return qg_with_job(options, export_job);
}
