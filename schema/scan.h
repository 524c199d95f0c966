/* The strict look at the bytes of a document, before any parser sees them. */
#ifndef QG_SCHEMA_SCAN_H
#define QG_SCHEMA_SCAN_H

#include "schema/document.h"

/* Longest number taken, in characters: the parser behind the scan reads numbers through a buffer of this length. */
enum { QG_NUMBER_LENGTH_MAX = 63 };

/* Checks that bytes[0..length) is exactly one JSON text as RFC 8259 has it, and within our limits: at most
 * QG_DOCUMENT_BYTES_MAX bytes of valid UTF-8 without a byte order mark, at most QG_DOCUMENT_DEPTH_MAX levels of objects and
 * arrays, no key twice in an object (compared after unescaping, case matters), no \u0000 and no lone surrogate, numbers that
 * a double holds. The first fault of syntax ends the scan; duplicate keys up to there are all reported.
 * Returns QG_DOCUMENT_OK, QG_DOCUMENT_NOT_JSON with at least one fault added, or QG_DOCUMENT_NO_MEMORY.
 * Threads: any; numbers are read in the locale of the calling thread, whose decimal point has to be ".". */
enum qg_document_status qg_scan(const char *bytes, size_t length, struct qg_faults *faults);

#endif
