/* The plain form of a fuzzer: seeds, then counted mutations, in a child process that is watched.
 *
 *   fuzz_X [COUNT]              seeds and COUNT mutations; output for `make check`
 *   fuzz_X --write-corpus DIR   writes the seeds into a directory, for libFuzzer
 *   fuzz_X --write-words FILE   writes the words as a dictionary, for libFuzzer
 *   fuzz_X --file FILE...       judges the bytes of files
 *
 * Mutation n starts from seed n mod the number of seeds and is changed once, every fourth round of seeds twice. What kills the child, or keeps
 * it for longer than PATIENCE_S, is written to fuzz_X-N.input; the child's accepted count comes back through shared memory.
 */
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/fuzz/fuzz.h"

enum { PATIENCE_S = 60, SEED = 20261 };

/* What the child tells. */
struct told {
    size_t input, accepted;
};

static size_t count_seeds(void) {
    static uint8_t seed[FUZZ_BYTES_MAX];
    size_t count = 0;
    while (fuzz_harness.seed(count, seed))
        count++;
    return count;
}

/* Input number n: first the seeds as they are, then mutations. */
static size_t make_input(size_t n, size_t seeds, uint8_t out[FUZZ_BYTES_MAX]) {
    size_t size = fuzz_harness.seed(n % seeds, out);
    if (n < seeds)
        return size;
    size_t rounds = 1 + (n / seeds % 4 == 3);
    for (size_t i = 0; i < rounds; i++)
        size = fuzz_mutate(out, size, FUZZ_BYTES_MAX, (const uint64_t[2]){SEED + i, n});
    return size;
}

/* Input as memory of exactly its size, so that reading beyond it is seen. */
static void judge(const uint8_t *bytes, size_t size) {
    uint8_t *exact = malloc(size ? size : 1);
    if (!exact)
        fuzz_fail("out of memory");
    memcpy(exact, bytes, size);
    LLVMFuzzerTestOneInput(exact, size);
    free(exact);
}

static void run_all(struct told *told, size_t seeds, size_t count) {
    static uint8_t input[FUZZ_BYTES_MAX];
    for (told->input = 0; told->input < seeds + count; told->input++) {
        alarm(PATIENCE_S);
        judge(input, make_input(told->input, seeds, input));
        told->accepted = fuzz_harness.accepted;
    }
    exit(0);
}

static bool write_file(const char *path, const void *bytes, size_t size) {
    FILE *file = fopen(path, "wb");
    if (!file)
        return false;
    bool written = fwrite(bytes, 1, size, file) == size;
    return fclose(file) == 0 && written;
}

/* Says what went wrong, and keeps the input. */
static void keep_input(const struct told *told, size_t seeds, int status) {
    static uint8_t input[FUZZ_BYTES_MAX];
    char path[256];
    snprintf(path, sizeof path, "fuzz_%s-%zu.input", fuzz_harness.name, told->input);
    bool kept = write_file(path, input, make_input(told->input, seeds, input));
    printf("# input %zu ended it with %s %d; %s %s\n", told->input, WIFSIGNALED(status) ? "signal" : "status",
           WIFSIGNALED(status) ? WTERMSIG(status) : WEXITSTATUS(status), kept ? "kept in" : "cannot be written to",
           path);
}

static int check(size_t count) {
    size_t seeds = count_seeds();
    struct told *told = mmap(NULL, sizeof *told, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (!seeds || told == MAP_FAILED) {
        printf("Bail out! no seeds, or no memory\n");
        return 1;
    }
    fflush(stdout);
    pid_t child = fork();
    if (child == 0)
        run_all(told, seeds, count);
    int status = 0;
    waitpid(child, &status, 0);
    if (status != 0)
        keep_input(told, seeds, status);
    printf("# %zu seeds, %zu inputs, of which %zu %s\n", seeds, told->input, told->accepted, fuzz_harness.accepted_as);
    printf("1..2\n%sok 1 - %s: every input is handled as promised\n", status == 0 ? "" : "not ", fuzz_harness.name);
    bool deep = told->accepted * 20 > told->input;
    printf("%sok 2 - %s: more than one in twenty was %s\n", deep ? "" : "not ", fuzz_harness.name,
           fuzz_harness.accepted_as);
    return status == 0 && deep ? 0 : 1;
}

static int write_corpus(const char *directory) {
    static uint8_t seed[FUZZ_BYTES_MAX];
    char path[4096];
    size_t size;
    for (size_t i = 0; (size = fuzz_harness.seed(i, seed)) > 0; i++) {
        snprintf(path, sizeof path, "%s/seed-%03zu", directory, i);
        if (!write_file(path, seed, size))
            return 1;
    }
    return 0;
}

/* One word a line, in quotes, all but letters and digits as \xHH. */
static int write_words(const char *path) {
    FILE *file = fopen(path, "w");
    if (!file)
        return 1;
    for (size_t i = 0; fuzz_harness.words && fuzz_harness.words[i]; i++) {
        fputc('"', file);
        for (const char *at = fuzz_harness.words[i]; *at; at++)
            fprintf(file, "\\x%02x", (unsigned char)*at);
        fputs("\"\n", file);
    }
    return fclose(file) == 0 ? 0 : 1;
}

static int judge_files(char **paths) {
    static uint8_t input[FUZZ_BYTES_MAX];
    for (; *paths; paths++) {
        FILE *file = fopen(*paths, "rb");
        if (!file)
            return 1;
        judge(input, fread(input, 1, sizeof input, file));
        fclose(file);
    }
    return 0;
}

int main(int argc, char **argv) {
    if (argc == 3 && strcmp(argv[1], "--write-corpus") == 0)
        return write_corpus(argv[2]);
    if (argc == 3 && strcmp(argv[1], "--write-words") == 0)
        return write_words(argv[2]);
    if (argc >= 3 && strcmp(argv[1], "--file") == 0)
        return judge_files(argv + 2);
    return check(argc > 1 ? strtoul(argv[1], NULL, 10) : fuzz_harness.mutations);
}
