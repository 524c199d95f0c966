/* The job document: JSON text in, struct out, and back with every default filled in.
 *
 * The reader is strict: well-formed UTF-8 and JSON to the letter, no duplicate or unknown keys, limited depth and size,
 * every value in range; and it reports every fault at once, each with its JSON pointer, what was found and what is allowed.
 */
#ifndef QG_SCHEMA_DOCUMENT_H
#define QG_SCHEMA_DOCUMENT_H

#include "core/study.h"
#include "schema/text.h"

enum {
    QG_DOCUMENT_BYTES_MAX = 1 << 20,
    QG_DOCUMENT_DEPTH_MAX = 32, /* levels of objects and arrays */
    QG_NAME_MAX = 200,          /* characters, as are the next two */
    QG_LABEL_MAX = 64,
    QG_LABELS_MAX = 16, /* how many */
    QG_POINTER_ROOM = 160
};

/* Figures that core holds in other units, as the document gives them. The echo prints these, so a user's number comes back
 * to the last bit. The reader fills them in together with the study; they have no other meaning. */
struct qg_given {
    double pressure_angle_deg;
    double density_kg_per_m3;
    double nominal_torque_nm;
    double torque_nm[QG_CASES_MAX]; /* per load case; 0: the case was given as a fraction of the nominal torque */
};

/* A document that was read. */
struct qg_job {
    struct qg_study study;
    struct qg_given given;
    char name[QG_NAME_MAX * 4 + 1];        /* "" when absent; at most QG_NAME_MAX characters */
    char pair_name[QG_NAME_MAX * 4 + 1];   /* of the gear pair */
    char external_id[QG_NAME_MAX * 4 + 1]; /* what another system calls the job; likewise */
    size_t label_count;
    char labels[QG_LABELS_MAX][QG_LABEL_MAX * 4 + 1];
};

/* One fault: RFC 6901 pointer ("" is the whole document) and words, both valid UTF-8. The words hold no control characters;
 * the pointer may, when a key of the document does. */
struct qg_fault {
    char pointer[QG_POINTER_ROOM];
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

/* Reads and checks a document of `length` bytes (no NUL needed), including qg_study_check. job and faults are set by the
 * call: job is complete when QG_DOCUMENT_OK is returned and of no use otherwise, faults is empty when and only when it is
 * (or memory was short). warnings (may be NULL) is appended to, `where` in core's names: see qg_document_pointer.
 * job and faults are large (16 and 56 KB) and keep nothing allocated. Threads: any. */
enum qg_document_status qg_document_read(const char *bytes, size_t length, struct qg_job *job, struct qg_faults *faults,
                                         struct qg_notes *warnings);

/* Writes the document of a job with all defaults filled in, as one JSON object: read again, it gives the same struct and
 * the same text. */
void qg_document_write(struct qg_text *text, const struct qg_job *job);

/* Writes one design as the document's "relief" object; ramps that are not present are left out. */
void qg_relief_write(struct qg_text *text, const struct qg_relief *relief);

/* Writes another pair as the document's "gear_pair" object: density and torque are those of the job, the name is at most
 * QG_NAME_MAX characters. Read again in a document, it is the same pair to the last bit. */
void qg_pair_write(struct qg_text *text, const struct qg_job *job, const struct qg_gear_pair *pair,
                   double pressure_angle_deg, const char *name);

/* The JSON pointer of the member that core calls `where` in its notes: "pinion.hob_tip_radius" is
 * /gear_pair/pinion/hob_tip_radius_mm, "bounds.gear.tip.amplitude" /relief_bounds/gear/tip/amplitude_mm,
 * "grid.0.from" /grid/0/from. A name that is not
 * known as a whole gives the member that its beginning names, at worst "", the document. */
void qg_document_pointer(const char *where, char pointer[QG_POINTER_ROOM]);

/* "evaluate", "optimize", "reliability", "map", "macro". */
const char *qg_kind_name(enum qg_study_kind kind);

/* "f_dte", "f_pps", "f_dte_percentile". */
const char *qg_objective_name(enum qg_objective objective);

/* What the best value of a job's progress is a value of; NULL for kinds that look for nothing, and for several objectives. */
const char *qg_job_objective(const struct qg_job *job);

#endif
