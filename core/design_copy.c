/* Deep copies of design results. See design_copy.h. */
#include "core/design_copy.h"

#include <string.h>

/* Copies the arrays of one load case into those that `to` already has, and all else beside them. */
static void copy_case(struct qg_case_result *to, const struct qg_case_result *from, size_t positions, size_t speeds) {
    const struct qg_case_result room = *to;
    size_t bytes = positions * sizeof(double);
    *to = *from;
    to->static_transmission_error = memcpy(room.static_transmission_error, from->static_transmission_error, bytes);
    to->unloaded_transmission_error =
        memcpy(room.unloaded_transmission_error, from->unloaded_transmission_error, bytes);
    to->mesh_stiffness = memcpy(room.mesh_stiffness, from->mesh_stiffness, bytes);
    to->load_share = memcpy(room.load_share, from->load_share, bytes * QG_PAIR_COUNT);
    to->contact_pressure = memcpy(room.contact_pressure, from->contact_pressure, bytes);
    to->response = room.response;
    to->stresses = NULL; /* not there before the job is done */
    if (speeds > 0)
        memcpy(to->response, from->response, speeds * sizeof *to->response);
}

struct qg_design_result *qg_design_result_copy(const struct qg_analysis *analysis,
                                               const struct qg_design_result *result) {
    struct qg_design_result *copy = qg_design_result_create(analysis);
    if (!copy)
        return NULL;
    copy->pair = result->pair;
    copy->backlash = result->backlash;
    copy->relief = result->relief;
    copy->f_pps = result->f_pps;
    copy->f_dte = result->f_dte;
    copy->f_dte_percentile = result->f_dte_percentile;
    for (size_t i = 0; i < result->case_count; i++)
        copy_case(&copy->cases[i], &result->cases[i], result->positions, result->speeds);
    return copy;
}
