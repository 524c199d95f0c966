/* The one table of the job document: every key with its place in the structs, its range, its default and core's name for
 * it. The reader, the writer and the mapping from core's names to JSON pointers walk this table and know no key by
 * themselves; job.schema.json is compared with it by a test.
 */
#ifndef QG_SCHEMA_FIELDS_H
#define QG_SCHEMA_FIELDS_H

#include "schema/document.h"

enum qg_field_type {
    QG_FIELD_NUMBER,             /* double */
    QG_FIELD_INT,                /* int */
    QG_FIELD_SIZE,               /* size_t */
    QG_FIELD_SEED,               /* uint64_t */
    QG_FIELD_CHOICE,             /* an enum, by its name in `choices` */
    QG_FIELD_TEXT,               /* char array for `high` characters of UTF-8 */
    QG_FIELD_OBJECT,             /* members by `form` */
    QG_FIELD_KIND,               /* the study's kind; read before everything else */
    QG_FIELD_LABELS,             /* array of texts */
    QG_FIELD_LOAD_CASES,         /* array of objects */
    QG_FIELD_RANGE,              /* [lower, upper] of the search box, for the qg_parameter in `fallback` */
    QG_FIELD_GRID,               /* array of objects by `form`, each a struct qg_axis of the struct qg_grid */
    QG_FIELD_OBJECTIVES,         /* array of names in `choices`, all different; the struct qg_objectives */
    QG_FIELD_START,              /* "static" or a number of half-backlashes */
    QG_FIELD_INTERVAL,           /* [low, high], low <= high, as struct qg_interval; both NaN when absent */
    QG_FIELD_INTERVAL_OF_WHOLES, /* the same, whole numbers */
    QG_FIELD_WORD_OR_NUMBER,     /* double; the one word in `choices` is stored as `fallback` */
    QG_FIELD_TYPE_COUNT
};

/* What to do when the key is absent. */
enum qg_field_need {
    QG_NEED_DEFAULT, /* take `fallback` */
    QG_NEED_NOTHING, /* leave the struct zero: absent has a meaning of its own, or the default is "" or [] */
    QG_NEED_REQUIRED
};

/* Kinds of studies as a set of bits, for keys that only some of them use. */
enum {
    QG_FOR_EVALUATE = 1 << QG_STUDY_EVALUATE,
    QG_FOR_OPTIMIZE = 1 << QG_STUDY_OPTIMIZE,
    QG_FOR_RELIABILITY = 1 << QG_STUDY_RELIABILITY,
    QG_FOR_MAP = 1 << QG_STUDY_MAP,
    QG_FOR_MACRO = 1 << QG_STUDY_MACRO,
    QG_FOR_ALL = (1 << QG_STUDY_KIND_COUNT) - 1
};

/* Search methods likewise. */
enum {
    QG_FOR_RANDOM_SIMPLEX = 1 << QG_SEARCH_RANDOM_SIMPLEX,
    QG_FOR_MULTISTART_SIMPLEX = 1 << QG_SEARCH_MULTISTART_SIMPLEX
};

struct qg_form;

struct qg_field {
    const char *key;
    const char *where; /* core's name below the parent's; "" adds nothing to it */
    enum qg_field_type type;
    enum qg_field_need need;
    size_t offset;              /* of the value, in the object that `form` describes */
    double low, high;           /* allowed, both included */
    double fallback;            /* the default; of a choice, its index */
    const char *const *choices; /* ends with NULL */
    const struct qg_form *form;
    unsigned used_by, required_by; /* sets of kinds; 0: all of them, and none beyond `need` */
    unsigned methods; /* set of search methods that use it; 0: all of them. Only in the form of the optimizer */
};

/* The members of one object. */
struct qg_form {
    const struct qg_field *fields;
    size_t count;
    bool has_presence; /* a bool at `presence` says whether the object is there at all */
    size_t presence;
};

/* The whole document, offsets in struct qg_job. */
extern const struct qg_form qg_document_form;

/* One load case, offsets in struct qg_load_case. Exactly one of the two members is given; the other is 0. */
struct qg_load_case {
    double torque_fraction, torque_nm;
};
extern const struct qg_form qg_load_case_form;

/* A search parameter at the JSON edge: "pinion.tip.start_radius_mm". */
const char *qg_parameter_name(enum qg_parameter parameter);

/* A search method: "random_simplex", "multistart_simplex". */
const char *qg_method_name(enum qg_search_method method);

/* The field of a form with that key; NULL when there is none. */
const struct qg_field *qg_form_find(const struct qg_form *form, const char *key);

/* True when a study of that kind uses the field, or cannot do without it. */
bool qg_field_used(const struct qg_field *field, enum qg_study_kind kind);
bool qg_field_required(const struct qg_field *field, enum qg_study_kind kind);

#endif
