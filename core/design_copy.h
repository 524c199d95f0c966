/* A copy of a design's result that outlives the callback in which it was shown.
 */
#ifndef QG_CORE_DESIGN_COPY_H
#define QG_CORE_DESIGN_COPY_H

#include "core/model.h"

/* A deep copy of a result that was made for this analysis, to be given to qg_design_result_destroy. NULL when memory is
 * short. */
struct qg_design_result *qg_design_result_copy(const struct qg_analysis *analysis,
                                               const struct qg_design_result *result);

#endif
