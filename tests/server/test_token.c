/* Secrets and tokens: published test vectors, and what passes as a token. */
#include "tests/server/support.h"

#include <string.h>

#include "server/base/token.h"

/* FIPS 180-4's example of one block, as NIST's CAVS publishes it: SHA-256("abc"). */
static void hashes_as_published(void **state) {
    (void)state;
    unsigned char hash[QG_HASH_BYTES], expected[QG_HASH_BYTES];
    assert_true(qg_secret_hash(hash, "abc", 3));
    assert_true(
        qg_hex_read(expected, sizeof expected, "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"));
    assert_memory_equal(hash, expected, sizeof hash);
    assert_true(qg_secret_equal(hash, expected));
    expected[31] ^= 1;
    assert_false(qg_secret_equal(hash, expected));
}

/* RFC 4231, test case 2. */
static void signs_as_published(void **state) {
    (void)state;
    unsigned char sum[QG_HASH_BYTES];
    char digits[2 * QG_HASH_BYTES + 1];
    assert_true(qg_secret_sign(sum, "Jefe", 4, "what do ya want for nothing?", 28));
    qg_hex_write(digits, sum, sizeof sum);
    assert_string_equal(digits, "5bdcc146bf60754e6a042426089575c75a003f089d2739839dec58b964ec3843");
}

static void reads_hexadecimal_to_the_letter(void **state) {
    (void)state;
    unsigned char bytes[2];
    assert_true(qg_hex_read(bytes, 2, "0af9"));
    assert_int_equal(bytes[0], 0x0a);
    assert_int_equal(bytes[1], 0xf9);
    static const char *const wrong[] = {"", "0af", "0af90", "0AF9", "0ag9", " af9"};
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++)
        assert_false(qg_hex_read(bytes, 2, wrong[i]));
}

/* RFC 4648, section 10. */
static void codes_base64_as_published(void **state) {
    (void)state;
    static const char *const pairs[][2] = {{"f", "Zg=="},        {"fo", "Zm8="},        {"foo", "Zm9v"},
                                           {"foob", "Zm9vYg=="}, {"fooba", "Zm9vYmE="}, {"foobar", "Zm9vYmFy"}};
    for (size_t i = 0; i < sizeof pairs / sizeof pairs[0]; i++) {
        char text[16];
        unsigned char bytes[6];
        size_t length = sizeof bytes;
        assert_true(qg_base64_write(text, sizeof text, pairs[i][0], strlen(pairs[i][0])));
        assert_string_equal(text, pairs[i][1]);
        assert_true(qg_base64_read(bytes, &length, pairs[i][1]));
        assert_int_equal(length, strlen(pairs[i][0]));
        assert_memory_equal(bytes, pairs[i][0], length);
        assert_false(qg_base64_write(text, strlen(pairs[i][1]), pairs[i][0], strlen(pairs[i][0])));
    }
    static const char *const wrong[] = {"",          "Zg",   "Zg=",  "Z===",     "Zm9v\n",
                                        "Zm9v Zg==", "Zm9_", "=Zm9", "Zg==Zg==", "Zm9vYmFyZm9v"};
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        unsigned char bytes[6];
        size_t length = sizeof bytes;
        if (qg_base64_read(bytes, &length, wrong[i]))
            fail_msg("\"%s\" was read", wrong[i]);
    }
}

static void makes_tokens_that_read_back(void **state) {
    (void)state;
    struct qg_token first = {0}, second = {0};
    char text[QG_TOKEN_ROOM], other[QG_TOKEN_ROOM], id[QG_TOKEN_ID_ROOM];
    unsigned char hash[QG_HASH_BYTES];
    assert_true(qg_token_make(&first, text) && qg_token_make(&second, other));
    assert_int_equal(strlen(text), QG_TOKEN_ROOM - 1);
    assert_true(qg_token_read(text, id, hash));
    assert_string_equal(id, first.id);
    assert_memory_equal(hash, first.hash, sizeof hash);
    assert_string_not_equal(first.id, second.id);
    assert_memory_not_equal(first.hash, second.hash, sizeof hash);
    assert_null(strstr(text + 16, first.id));
}

static void refuses_what_is_no_token(void **state) {
    (void)state;
    struct qg_token token;
    char text[QG_TOKEN_ROOM], changed[QG_TOKEN_ROOM + 1], id[QG_TOKEN_ID_ROOM];
    unsigned char hash[QG_HASH_BYTES];
    assert_true(qg_token_make(&token, text));
    static const size_t places[] = {0, 2, 15, 20, QG_TOKEN_ROOM - 2};
    for (size_t i = 0; i < sizeof places / sizeof places[0]; i++) {
        strcpy(changed, text);
        changed[places[i]] = 'X';
        assert_false(qg_token_read(changed, id, hash));
    }
    assert_false(qg_token_read("", id, hash));
    assert_false(qg_token_read(strcat(strcpy(changed, text), "0"), id, hash));
    changed[QG_TOKEN_ROOM - 2] = '\0';
    assert_false(qg_token_read(changed, id, hash));
}

static void writes_scopes(void **state) {
    (void)state;
    struct qg_text text = {0};
    qg_scopes_write(&text, QG_SCOPE_READ | QG_SCOPE_ADMIN);
    assert_string_equal(text.data, "[\"read\",\"admin\"]");
    qg_text_finish(&text);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(hashes_as_published),
        cmocka_unit_test(signs_as_published),
        cmocka_unit_test(reads_hexadecimal_to_the_letter),
        cmocka_unit_test(codes_base64_as_published),
        cmocka_unit_test(makes_tokens_that_read_back),
        cmocka_unit_test(refuses_what_is_no_token),
        cmocka_unit_test(writes_scopes),
    };
    return cmocka_run_group_tests_name("token", tests, NULL, NULL);
}
