/* Counted mutations, and the other small things that harnesses share. */
#include <ctype.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/random.h"
#include "tests/fuzz/fuzz.h"

/* Numbers drawn for one mutation. */
struct dice {
    const uint64_t *which;
    uint32_t lane;
};

/* One of 0 .. n - 1; 0 when n is 0. */
static size_t throw_dice(struct dice *dice, size_t n) {
    return (size_t)(qg_random_uniform(dice->which[0], QG_STREAM_TESTS, dice->which[1], dice->lane++) * (double)n);
}

/* The bytes under change. */
struct bytes {
    uint8_t *data;
    size_t size, room;
};

/* Replaces `length` bytes at `at` by others, as far as there is room. */
static void splice(struct bytes *bytes, size_t at, size_t length, const void *by, size_t by_length) {
    if (bytes->size - length + by_length > bytes->room)
        return;
    memmove(bytes->data + at + by_length, bytes->data + at + length, bytes->size - at - length);
    memcpy(bytes->data + at, by, by_length);
    bytes->size = bytes->size - length + by_length;
}

static void flip_bit(struct bytes *bytes, struct dice *dice) {
    if (bytes->size)
        bytes->data[throw_dice(dice, bytes->size)] ^= (uint8_t)(1u << throw_dice(dice, 8));
}

static void set_byte(struct bytes *bytes, struct dice *dice) {
    static const char interesting[] =
        "\0\x01\x02\t\n\r \"%&'*,-./0123456789:;<=>?@AZ[\\]_az{|}~\x7f\x80\xbf\xc0\xe0\xf0\xff";
    uint8_t byte = (uint8_t)interesting[throw_dice(dice, sizeof interesting - 1)];
    size_t at = throw_dice(dice, bytes->size + 1);
    splice(bytes, at, at < bytes->size && throw_dice(dice, 2) ? 1 : 0, &byte, 1);
}

/* A part of the bytes, short ones more often. */
static size_t throw_range(struct bytes *bytes, struct dice *dice, size_t *at) {
    *at = throw_dice(dice, bytes->size);
    size_t most = bytes->size - *at, usual = throw_dice(dice, 4) ? 16 : most;
    return throw_dice(dice, most < usual ? most : usual) + (most > 0);
}

static void delete_range(struct bytes *bytes, struct dice *dice) {
    size_t at, length = throw_range(bytes, dice, &at);
    splice(bytes, at, length, "", 0);
}

/* Copies a part to another place. */
static void copy_range(struct bytes *bytes, struct dice *dice) {
    uint8_t part[FUZZ_BYTES_MAX];
    size_t at, length = throw_range(bytes, dice, &at);
    if (length > sizeof part)
        return;
    memcpy(part, bytes->data + at, length);
    splice(bytes, throw_dice(dice, bytes->size + 1), 0, part, length);
}

static bool is_of_number(uint8_t byte) {
    return isdigit(byte) || byte == '.' || byte == '-' || byte == '+';
}

/* Replaces the number behind a random place by another one. */
static void change_number(struct bytes *bytes, struct dice *dice) {
    static const char *const numbers[] = {"0",     "1",    "-1",   "2",     "0.5",    "1e-300",    "1e300",
                                          "-0.0",  "1e-5", "17",   "64",    "1000",   "100001",    "9007199254740993",
                                          "1e400", "0.1",  "0.02", "44.54", "1e1000", "4294967296"};
    char scaled[32];
    size_t at = throw_dice(dice, bytes->size), length = 0;
    while (at < bytes->size && !isdigit(bytes->data[at]))
        at++;
    while (at > 0 && at < bytes->size && is_of_number(bytes->data[at - 1]))
        at--;
    while (at + length < bytes->size && length < 24 && is_of_number(bytes->data[at + length]))
        length++;
    if (!length)
        return;
    const char *by = numbers[throw_dice(dice, sizeof numbers / sizeof *numbers)];
    if (throw_dice(dice, 3)) { /* near the old value: what is read on */
        memcpy(scaled, bytes->data + at, length);
        scaled[length] = '\0';
        double factor = 0.9 + 0.2 * (double)throw_dice(dice, 1000) / 1000;
        snprintf(scaled, sizeof scaled, "%.6g", strtod(scaled, NULL) * factor);
        by = scaled;
    }
    splice(bytes, at, length, by, strlen(by));
}

static void insert_word(struct bytes *bytes, struct dice *dice) {
    size_t count = 0;
    while (fuzz_harness.words && fuzz_harness.words[count])
        count++;
    if (!count)
        return;
    const char *word = fuzz_harness.words[throw_dice(dice, count)];
    splice(bytes, throw_dice(dice, bytes->size + 1), 0, word, strlen(word));
}

size_t fuzz_mutate(uint8_t *data, size_t size, size_t room, const uint64_t which[2]) {
    /* Most changes of numbers leave a document that can be read on; most others do not. */
    static void (*const changes[])(struct bytes *, struct dice *) = {
        change_number, change_number, change_number, change_number, change_number, change_number,
        flip_bit,      set_byte,      delete_range,  copy_range,    insert_word};
    struct bytes bytes = {data, size, room};
    struct dice dice = {which, 0};
    for (size_t left = 1 + throw_dice(&dice, 2); left > 0; left--)
        changes[throw_dice(&dice, sizeof changes / sizeof *changes)](&bytes, &dice);
    return bytes.size;
}

void fuzz_fail(const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    vfprintf(stderr, format, arguments);
    va_end(arguments);
    fputc('\n', stderr);
    abort();
}

size_t fuzz_read_source(const char *path, uint8_t *out) {
    char full[4096];
    const char *source = getenv("QG_SOURCE");
    snprintf(full, sizeof full, "%s/%s", source ? source : ".", path);
    FILE *file = fopen(full, "rb");
    if (!file)
        return 0;
    size_t length = fread(out, 1, FUZZ_BYTES_MAX, file);
    if (fgetc(file) != EOF)
        length = 0;
    fclose(file);
    return length;
}
