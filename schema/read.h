/* From a parsed document to a job: what read.c does for read_bytes.c.
 */
#ifndef QG_SCHEMA_READ_H
#define QG_SCHEMA_READ_H

#include <cjson/cJSON.h>

#include "schema/document.h"

/* Walks over a parsed document, fills the job, which must be zeroed, and appends every fault. warnings may be NULL. The
 * locale of the thread must be "C". Threads: any. */
void qg_tree_read(const cJSON *root, struct qg_job *job, struct qg_faults *faults, struct qg_notes *warnings);

#endif
