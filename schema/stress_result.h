/* What goes out about stresses: those of one load case by finite elements, and the pair's rating by ISO 6336. */
#ifndef QG_SCHEMA_STRESS_RESULT_H
#define QG_SCHEMA_STRESS_RESULT_H

#include "core/iso6336.h"
#include "core/stress.h"
#include "schema/text.h"

/* Appends the members of a load case about stresses ("max_root_stress_mpa" to "contact_pressure_path") to the object that is
 * open; all are null when stresses is NULL. lowest_pair is the number of the first pair of teeth. Threads: any. */
void qg_stresses_write(struct qg_text *text, const struct qg_stresses *stresses, int lowest_pair);

/* Appends the object of the member "iso6336": torque (N mm, on the pinion) is what the pair was rated for, width (mm) the
 * smaller face width. Threads: any. */
void qg_iso6336_write(struct qg_text *text, const struct qg_iso6336 *iso, double torque, double width);

#endif
