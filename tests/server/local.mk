# One test program per module of the server, named after it.
SERVER_TESTS = \
	tests/server/test_access \
	tests/server/test_address \
	tests/server/test_board \
	tests/server/test_clock \
	tests/server/test_cors \
	tests/server/test_form \
	tests/server/test_encode \
	tests/server/test_forwarded \
	tests/server/test_guests \
	tests/server/test_hold \
	tests/server/test_job_copies \
	tests/server/test_log \
	tests/server/test_log_limit \
	tests/server/test_machine \
	tests/server/test_origin \
	tests/server/test_field_maker \
	tests/server/test_problem \
	tests/server/test_queries \
	tests/server/test_retention \
	tests/server/test_routes \
	tests/server/test_sender \
	tests/server/test_settings \
	tests/server/test_store \
	tests/server/test_systemd \
	tests/server/test_target \
	tests/server/test_token \
	tests/server/test_webhook
SERVER_TEST_LIBS = $(SERVER_LIBS) $(CMOCKA_LIBS)

if HAVE_CMOCKA
check_PROGRAMS += $(SERVER_TESTS)
TESTS += $(SERVER_TESTS)
endif

tests_server_test_board_SOURCES = tests/server/test_board.c tests/server/support.h
tests_server_test_board_LDADD = $(SERVER_TEST_LIBS)
tests_server_test_encode_SOURCES = tests/server/test_encode.c tests/server/support.h
tests_server_test_encode_LDADD = $(SERVER_TEST_LIBS)
tests_server_test_forwarded_SOURCES = tests/server/test_forwarded.c tests/server/support.h
tests_server_test_forwarded_LDADD = $(SERVER_TEST_LIBS)
tests_server_test_guests_SOURCES = tests/server/test_guests.c tests/server/support.h
tests_server_test_guests_LDADD = $(SERVER_TEST_LIBS)
tests_server_test_hold_SOURCES = tests/server/test_hold.c tests/server/support.h
tests_server_test_hold_LDADD = $(SERVER_TEST_LIBS)
tests_server_test_job_copies_SOURCES = tests/server/test_job_copies.c tests/server/place.h tests/server/support.h
tests_server_test_job_copies_CPPFLAGS = $(AM_CPPFLAGS) $(SQLITE_CFLAGS)
tests_server_test_job_copies_LDADD = $(SERVER_TEST_LIBS)
tests_server_test_log_SOURCES = tests/server/test_log.c tests/server/support.h
tests_server_test_log_LDADD = $(SERVER_TEST_LIBS)
tests_server_test_log_limit_SOURCES = tests/server/test_log_limit.c tests/server/support.h
tests_server_test_log_limit_LDADD = $(SERVER_TEST_LIBS)
tests_server_test_machine_SOURCES = tests/server/test_machine.c tests/server/support.h
tests_server_test_machine_LDADD = $(SERVER_TEST_LIBS)
tests_server_test_origin_SOURCES = tests/server/test_origin.c tests/server/support.h
tests_server_test_origin_LDADD = $(SERVER_TEST_LIBS)
tests_server_test_field_maker_SOURCES = tests/server/test_field_maker.c tests/server/support.h
tests_server_test_field_maker_LDADD = $(SERVER_TEST_LIBS)
tests_server_test_problem_SOURCES = tests/server/test_problem.c tests/server/support.h
tests_server_test_problem_LDADD = $(SERVER_TEST_LIBS)
tests_server_test_routes_SOURCES = tests/server/test_routes.c tests/server/support.h
tests_server_test_routes_LDADD = $(SERVER_TEST_LIBS)
tests_server_test_settings_SOURCES = tests/server/test_settings.c tests/server/support.h
tests_server_test_settings_LDADD = $(SERVER_TEST_LIBS)
tests_server_test_store_SOURCES = tests/server/test_store.c tests/server/support.h
tests_server_test_store_CPPFLAGS = $(AM_CPPFLAGS) $(SQLITE_CFLAGS)
tests_server_test_store_LDADD = $(SERVER_TEST_LIBS)
tests_server_test_systemd_SOURCES = tests/server/test_systemd.c tests/server/support.h
tests_server_test_systemd_LDADD = $(SERVER_TEST_LIBS)
tests_server_test_target_SOURCES = tests/server/test_target.c tests/server/support.h
tests_server_test_target_LDADD = $(SERVER_TEST_LIBS)
tests_server_test_access_SOURCES = tests/server/test_access.c tests/server/place.h tests/server/support.h
tests_server_test_access_CPPFLAGS = $(AM_CPPFLAGS) $(SQLITE_CFLAGS)
tests_server_test_access_LDADD = $(SERVER_TEST_LIBS)
tests_server_test_clock_SOURCES = tests/server/test_clock.c tests/server/support.h
tests_server_test_clock_LDADD = $(SERVER_TEST_LIBS)
tests_server_test_cors_SOURCES = tests/server/test_cors.c tests/server/support.h
tests_server_test_cors_LDADD = $(SERVER_TEST_LIBS)
tests_server_test_form_SOURCES = tests/server/test_form.c tests/server/support.h
tests_server_test_form_LDADD = $(SERVER_TEST_LIBS)
tests_server_test_token_SOURCES = tests/server/test_token.c tests/server/support.h
tests_server_test_token_LDADD = $(SERVER_TEST_LIBS)
tests_server_test_address_SOURCES = tests/server/test_address.c tests/server/support.h
tests_server_test_address_LDADD = $(SERVER_TEST_LIBS)
tests_server_test_sender_SOURCES = tests/server/test_sender.c tests/server/place.h tests/server/support.h
tests_server_test_sender_CPPFLAGS = $(AM_CPPFLAGS) $(SQLITE_CFLAGS)
tests_server_test_sender_LDADD = $(SERVER_TEST_LIBS)
tests_server_test_webhook_SOURCES = tests/server/test_webhook.c tests/server/support.h
tests_server_test_webhook_LDADD = $(SERVER_TEST_LIBS)
tests_server_test_queries_SOURCES = tests/server/test_queries.c tests/server/place.h tests/server/support.h
tests_server_test_queries_CPPFLAGS = $(AM_CPPFLAGS) $(SQLITE_CFLAGS)
tests_server_test_queries_LDADD = $(SERVER_TEST_LIBS) $(SQLITE_LIBS)
tests_server_test_retention_SOURCES = tests/server/test_retention.c tests/server/place.h tests/server/support.h
tests_server_test_retention_CPPFLAGS = $(AM_CPPFLAGS) $(SQLITE_CFLAGS)
tests_server_test_retention_LDADD = $(SERVER_TEST_LIBS)
