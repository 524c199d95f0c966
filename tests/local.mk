# Unit tests speak TAP through cmocka, service tests through bats, the page's through node; automake's driver counts all.
TEST_EXTENSIONS = .bats .mjs
LOG_DRIVER = env CMOCKA_MESSAGE_OUTPUT=TAP AM_TAP_AWK='$(AWK)' $(SHELL) $(top_srcdir)/build-aux/tap-driver.sh
BATS_LOG_DRIVER = env AM_TAP_AWK='$(AWK)' $(SHELL) $(top_srcdir)/build-aux/tap-driver.sh
BATS_LOG_COMPILER = $(BATS) --tap
MJS_LOG_DRIVER = $(BATS_LOG_DRIVER)
MJS_LOG_COMPILER = $(NODE) --test-reporter=tap
AM_TESTS_ENVIRONMENT = \
	QG_SOURCE='$(abs_top_srcdir)'; export QG_SOURCE; \
	QG_BUILD='$(abs_top_builddir)'; export QG_BUILD;

EXTRA_DIST += tests/house.bats
if HAVE_BATS
TESTS += tests/house.bats
endif

include tests/core/local.mk
include tests/schema/local.mk
include tests/server/local.mk
include tests/service/local.mk
include tests/page/local.mk
include tests/bench/local.mk
include tests/faults/local.mk
include tests/fuzz/local.mk
include tests/kill/local.mk
include tests/load/local.mk

# The service tests and those of what threads share, under ThreadSanitizer, in a build of its own.
TSAN_TESTS = $(SERVICE_TESTS) tests/service/export.bats tests/service/client.bats tests/load/short.test.mjs tests/fuzz/fuzz_http
TSAN_BUILT = tests/core/test_pool tests/core/test_cache tests/server/test_access tests/server/test_board \
	tests/server/test_guests tests/server/test_log tests/server/test_log_limit tests/server/test_sender tests/server/test_store
TSAN_CC = $(CC)
.PHONY: check-tsan
check-tsan:
	$(MKDIR_P) tsan
	test -f tsan/Makefile || (cd tsan && $(abs_top_srcdir)/configure -q --enable-tsan CC='$(TSAN_CC)')
	$(MAKE) -s -C tsan quietgeard quietgear web/dist/page.js systemd/quietgeard.service systemd/quietgear.tmpfiles tests/fuzz/fuzz_http $(TSAN_BUILT)
	QG_PATIENCE=10 TSAN_OPTIONS='suppressions=$(abs_top_srcdir)/tests/tsan.supp' \
		$(MAKE) -s -C tsan check-TESTS check_PROGRAMS='' TESTS='$(TSAN_BUILT) $(TSAN_TESTS)'
