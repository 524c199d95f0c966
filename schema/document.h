/* The job document: JSON text in, struct out, and back with every default filled in.
 *
 * The reader is strict: well-formed UTF-8 and JSON to the letter, no duplicate or unknown keys, limited depth and size,
 * every value in range; and it reports every fault at once, each with its JSON pointer, what was found and what is allowed.
 */
#ifndef QG_SCHEMA_DOCUMENT_H
#define QG_SCHEMA_DOCUMENT_H

#include "core/study.h"
#include "schema/text.h"

enum { QG_DOCUMENT_BYTES_MAX = 1 << 20, QG_DOCUMENT_DEPTH_MAX = 32, QG_NAME_MAX = 200, QG_LABELS_MAX = 16, QG_LABEL_MAX = 64 };

/* A document that was read. */
struct qg_job {
    struct qg_study study;
    char name[QG_NAME_MAX * 4 + 1];      /* "" when absent; at most QG_NAME_MAX characters */
    char pair_name[QG_NAME_MAX * 4 + 1]; /* of the gear pair */
    size_t label_count;
    char labels[QG_LABELS_MAX][QG_LABEL_MAX * 4 + 1];
};

/* One fault: RFC 6901 pointer and words. */
struct qg_fault {
    char pointer[160];
    char detail[400];
};

/* Faults in the order of the document; those beyond the room are counted but not kept. */
enum { QG_FAULTS_ROOM = 100 };
struct qg_faults {
    size_t count, lost;
    struct qg_fault item[QG_FAULTS_ROOM];
};

enum qg_document_status {
    QG_DOCUMENT_OK,
    QG_DOCUMENT_NOT_JSON, /* syntax, encoding, size, depth, duplicate key: HTTP 400 */
    QG_DOCUMENT_INVALID,  /* JSON, but not a job that can be run: HTTP 422 */
    QG_DOCUMENT_NO_MEMORY
};

/* Reads and checks a document, including qg_study_check. warnings may be NULL. Threads: any. */
enum qg_document_status qg_document_read(const char *bytes, size_t length, struct qg_job *job, struct qg_faults *faults,
                                         struct qg_notes *warnings);

/* Writes the document of a job with all defaults filled in, as one JSON object. */
void qg_document_write(struct qg_text *text, const struct qg_job *job);

/* "evaluate", "optimize", "reliability". */
const char *qg_kind_name(enum qg_study_kind kind);

#endif
