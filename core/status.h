/* What core's functions answer, and the notes in which they say why.
 *
 * Conventions of the whole of core:
 *   units      millimetre, newton, megapascal, kilogram, second, radian; torque in N mm; where a dimensionless or
 *              other unit is meant, the comment at the field says so
 *   numbering  gear 0 is the pinion (it drives), gear 1 the gear; see QG_PINION, QG_GEAR
 *   answers    functions that can fail return enum qg_status, QG_OK being 0; what cannot happen is an assert
 *   ownership  X_init fills a caller's struct and X_finish frees what it holds; X_create returns a new object and
 *              X_destroy frees it; finish and destroy accept a zeroed struct or NULL
 *   threads    const arguments may be shared between threads; everything else belongs to one thread at a time
 *   purity     no JSON, HTTP, SQL, clock, environment or printing: the same arguments give the same bits
 */
#ifndef QG_CORE_STATUS_H
#define QG_CORE_STATUS_H

#include <stdbool.h>
#include <stddef.h>

enum { QG_PINION = 0, QG_GEAR = 1 };

/* Asked now and then, from any thread; true stops the work with QG_CANCELLED. asked NULL: never. */
struct qg_stop {
    bool (*asked)(void *self);
    void *self;
};

/* What it answers; false when there is nobody to ask. */
bool qg_is_stopped(const struct qg_stop *stop);

/* The one table of core's errors: name, text. */
#define QG_STATUS_TABLE(X)                                                                                             \
    X(QG_OK, "done")                                                                                                   \
    X(QG_OUT_OF_MEMORY, "out of memory")                                                                               \
    X(QG_IMPOSSIBLE_GEAR, "this gear pair cannot be made or cannot run")                                               \
    X(QG_NO_CONVERGENCE, "a numerical method did not converge")                                                        \
    X(QG_CANCELLED, "cancelled")

#define QG_STATUS_NAME(name, text) name,
enum qg_status { QG_STATUS_TABLE(QG_STATUS_NAME) QG_STATUS_COUNT };
#undef QG_STATUS_NAME

/* The table's text for a status; never NULL. */
const char *qg_status_text(enum qg_status status);

/* One remark about the input: an error or a warning. */
struct qg_note {
    char where[64]; /* the member it is about, in core's names: "pinion.hob_tip_radius", "center_distance"; "" is all */
    char text[320]; /* what was found, with the numbers, and what is allowed */
};

/* A short list of remarks, in the order in which they came; those beyond the room are counted but not kept. */
enum { QG_NOTES_ROOM = 24 };
struct qg_notes {
    size_t count; /* kept in item[] */
    size_t lost;  /* dropped for want of room */
    struct qg_note item[QG_NOTES_ROOM];
};

/* Appends a remark, printf-like. notes may be NULL: then nothing happens. */
void qg_notes_add(struct qg_notes *notes, const char *where, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

#endif
