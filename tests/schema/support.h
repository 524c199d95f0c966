/* What the tests of the schema share: documents from files and from text, and random bits. */
#ifndef QG_TESTS_SCHEMA_SUPPORT_H
#define QG_TESTS_SCHEMA_SUPPORT_H

#include <stddef.h>
#include <stdint.h>

#include "schema/document.h"

/* A file below the source tree ($QG_SOURCE, else "."), in memory of exactly its size, so that a sanitizer sees any step
 * beyond it. Fails the test when it cannot be read. The caller frees it. */
char *read_source_file(const char *name, size_t *length);

/* qg_document_read on a copy of exactly the given length. */
enum qg_document_status read_exact(const char *bytes, size_t length, struct qg_job *job, struct qg_faults *faults);

/* True when one of the faults is at the pointer. */
int has_fault_at(const struct qg_faults *faults, const char *pointer);

/* The next of a sequence of random 64 bits (splitmix64); *state is the seed. */
uint64_t next_random(uint64_t *state);

/* Documents of the least that each kind takes. */
extern const char least_evaluate[], least_optimize[], least_reliability[], least_map[], least_macro[];

#endif
