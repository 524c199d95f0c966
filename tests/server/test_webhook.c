/* Signatures and secrets of webhooks. */
#include "tests/server/support.h"

#include <string.h>

#include "server/base/webhook.h"

/* The example of the scheme's reference libraries. */
static void signs_as_published(void **state) {
    (void)state;
    char signature[QG_SIGNATURE_ROOM];
    const struct qg_message message = {
        .id = "msg_p5jXN8AQM9LWM0D4loKWxJek", .timestamp = 1614265330, .body = "{\"test\": 2432232314}"};
    assert_true(qg_webhook_sign(signature, "whsec_MfKQ9r8GKYqrTwjUPD8ILPZIo2LaLaSw", &message));
    assert_string_equal(signature, "v1,g0hM9SsE+OTPJTGt/tmIKtSyZlE3uFJELVlNIOLJ1OE=");
}

static void signs_all_parts(void **state) {
    (void)state;
    static const char secret[] = "whsec_MfKQ9r8GKYqrTwjUPD8ILPZIo2LaLaSw";
    static const struct qg_message messages[] = {{"a", "b", 1}, {"c", "b", 1}, {"a", "c", 1}, {"a", "b", 2}};
    char signatures[4][QG_SIGNATURE_ROOM], other[QG_SIGNATURE_ROOM];
    for (size_t i = 0; i < 4; i++) {
        assert_true(qg_webhook_sign(signatures[i], secret, &messages[i]));
        for (size_t j = 0; j < i; j++)
            assert_string_not_equal(signatures[i], signatures[j]);
    }
    assert_true(qg_webhook_sign(other, "whsec_MfKQ9r8GKYqrTwjUPD8ILPZIo2LaLaSx", &messages[0]));
    assert_string_not_equal(other, signatures[0]);
    assert_false(qg_webhook_sign(other, "MfKQ9r8GKYqrTwjUPD8ILPZIo2LaLaSw", &messages[0]));
}

static void knows_secrets(void **state) {
    (void)state;
    char made[QG_WEBHOOK_SECRET_ROOM], again[QG_WEBHOOK_SECRET_ROOM], id[QG_WEBHOOK_ID_ROOM];
    assert_true(qg_webhook_make_secret(made) && qg_webhook_make_secret(again));
    assert_true(qg_webhook_is_secret(made));
    assert_string_not_equal(made, again);
    assert_true(qg_webhook_make_id(id));
    assert_int_equal(strlen(id), 15);
    assert_true(qg_webhook_is_secret("whsec_MfKQ9r8GKYqrTwjUPD8ILPZIo2LaLaSw")); /* 24 bytes */
    static const char *const wrong[] = {
        "",
        "whsec_",
        "whsec_abc",
        "WHSEC_MfKQ9r8GKYqrTwjUPD8ILPZIo2LaLaSw",
        "whsec_MfKQ9r8GKYqrTwjUPD8ILPZIo2LaLaS=", /* 23 bytes */
        "whsec_MfKQ9r8GKYqrTwjUPD8ILPZIo2LaLaSwMfKQ9r8GKYqrTwjUPD8ILPZIo2LaLaSwMfKQ9r8GKYqrTwjUPD8ILPZIo2LaLaSw"};
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++)
        if (qg_webhook_is_secret(wrong[i]))
            fail_msg("%s was taken", wrong[i]);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(signs_as_published),
        cmocka_unit_test(signs_all_parts),
        cmocka_unit_test(knows_secrets),
    };
    return cmocka_run_group_tests_name("webhook", tests, NULL, NULL);
}
