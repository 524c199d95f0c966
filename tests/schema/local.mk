# One test program per module of schema; support.c is what they share.
SCHEMA_TESTS = \
	tests/schema/test_bad \
	tests/schema/test_document \
	tests/schema/test_drawing \
	tests/schema/test_fields \
	tests/schema/test_result \
	tests/schema/test_scan \
	tests/schema/test_text
SCHEMA_TEST_SUPPORT = tests/schema/support.c tests/schema/support.h
SCHEMA_TEST_LIBS = $(SCHEMA_LIBS) $(CMOCKA_LIBS)
SCHEMA_TEST_CPPFLAGS = $(AM_CPPFLAGS) $(CJSON_CFLAGS) $(CMOCKA_CFLAGS)
EXTRA_DIST += tests/schema/bad tests/schema/bad.tsv

if HAVE_CMOCKA
check_PROGRAMS += $(SCHEMA_TESTS)
TESTS += $(SCHEMA_TESTS)
endif

tests_schema_test_bad_SOURCES = tests/schema/test_bad.c $(SCHEMA_TEST_SUPPORT)
tests_schema_test_bad_CPPFLAGS = $(SCHEMA_TEST_CPPFLAGS)
tests_schema_test_bad_LDADD = $(SCHEMA_TEST_LIBS)
tests_schema_test_document_SOURCES = tests/schema/test_document.c $(SCHEMA_TEST_SUPPORT)
tests_schema_test_document_CPPFLAGS = $(SCHEMA_TEST_CPPFLAGS)
tests_schema_test_document_LDADD = $(SCHEMA_TEST_LIBS)
tests_schema_test_drawing_SOURCES = tests/schema/test_drawing.c $(SCHEMA_TEST_SUPPORT)
tests_schema_test_drawing_CPPFLAGS = $(SCHEMA_TEST_CPPFLAGS)
tests_schema_test_drawing_LDADD = $(SCHEMA_TEST_LIBS)
tests_schema_test_fields_SOURCES = tests/schema/test_fields.c $(SCHEMA_TEST_SUPPORT)
tests_schema_test_fields_CPPFLAGS = $(SCHEMA_TEST_CPPFLAGS)
tests_schema_test_fields_LDADD = $(SCHEMA_TEST_LIBS)
tests_schema_test_result_SOURCES = tests/schema/test_result.c $(SCHEMA_TEST_SUPPORT)
tests_schema_test_result_CPPFLAGS = $(SCHEMA_TEST_CPPFLAGS)
tests_schema_test_result_LDADD = $(SCHEMA_TEST_LIBS)
tests_schema_test_scan_SOURCES = tests/schema/test_scan.c $(SCHEMA_TEST_SUPPORT)
tests_schema_test_scan_CPPFLAGS = $(SCHEMA_TEST_CPPFLAGS)
tests_schema_test_scan_LDADD = $(SCHEMA_TEST_LIBS)
tests_schema_test_text_SOURCES = tests/schema/test_text.c $(SCHEMA_TEST_SUPPORT)
tests_schema_test_text_CPPFLAGS = $(SCHEMA_TEST_CPPFLAGS)
tests_schema_test_text_LDADD = $(SCHEMA_TEST_LIBS)

EXTRA_DIST += tests/package.json tests/package-lock.json tests/.npmrc tests/schema/schemas.mjs tests/schema/schemas.bats \
	tests/schema/locale.bats
if HAVE_BATS
TESTS += tests/schema/locale.bats tests/schema/schemas.bats
endif
tests/schema/locale.log: tests/schema/test_text
tests/schema/schemas.log: quietgear tests/schema/test_drawing tests/schema/test_result
