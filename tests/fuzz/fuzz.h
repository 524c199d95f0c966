/* What the fuzzers share. A harness feeds bytes to a part of the product and aborts when something is not as its header
 * promises; it is linked in two ways:
 *
 *   plain     with plain_main.c: runs the seeds and a fixed number of counted mutations, the same ones each time. Part of
 *             `make check`, needs no more than any compiler.
 *   explore   with libFuzzer (`make fuzz`), which looks for inputs that reach new code.
 *
 * A harness is LLVMFuzzerTestOneInput, whose name is libFuzzer's, and the struct fuzz_harness. It is called from one thread.
 */
#ifndef QG_TESTS_FUZZ_FUZZ_H
#define QG_TESTS_FUZZ_FUZZ_H

#include <stddef.h>
#include <stdint.h>

enum { FUZZ_BYTES_MAX = 1 << 14 };

struct fuzz_harness {
    const char *name;
    /* Writes seed number `index` to out (FUZZ_BYTES_MAX bytes of room) and returns its length; 0: there is none. */
    size_t (*seed)(size_t index, uint8_t *out);
    const char *const *words; /* what mutations insert, ends with NULL; NULL: no such words */
    size_t mutations;         /* in the plain form */
    const char *accepted_as;  /* what `accepted` counts */
    size_t accepted;          /* inputs so far that got beyond the first refusal: none would make the test worthless */
};

/* The harness of this program. */
extern struct fuzz_harness fuzz_harness;

/* Judges one input; returns 0. Aborts when a promise is broken. */
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* Changes bytes in place, at least one of them when it can: flips, interesting bytes and numbers, words, ranges deleted,
 * doubled and moved. The same (seed, index) makes the same change. Returns the new size, at most room. */
size_t fuzz_mutate(uint8_t *data, size_t size, size_t room, const uint64_t which[2]);

/* Prints a printf-like message to stderr and aborts. */
_Noreturn void fuzz_fail(const char *format, ...) __attribute__((format(printf, 1, 2)));

/* Fails, with the condition's text and place, unless it is true. */
#define fuzz_require(condition) ((condition) ? (void)0 : fuzz_fail("%s:%d: not so: %s", __FILE__, __LINE__, #condition))

/* Reads a file of the sources (QG_SOURCE, else the present directory) into out; returns its length, 0 when it is not there
 * or too long. */
size_t fuzz_read_source(const char *path, uint8_t *out);

#endif
