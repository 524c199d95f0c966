# Unit tests speak TAP through cmocka, service tests through bats; automake's driver counts both.
TEST_EXTENSIONS = .bats
LOG_DRIVER = env CMOCKA_MESSAGE_OUTPUT=TAP AM_TAP_AWK='$(AWK)' $(SHELL) $(top_srcdir)/build-aux/tap-driver.sh
BATS_LOG_DRIVER = env AM_TAP_AWK='$(AWK)' $(SHELL) $(top_srcdir)/build-aux/tap-driver.sh
BATS_LOG_COMPILER = $(BATS) --tap
AM_TESTS_ENVIRONMENT = \
	QG_SOURCE='$(abs_top_srcdir)'; export QG_SOURCE; \
	QG_BUILD='$(abs_top_builddir)'; export QG_BUILD;

include tests/core/local.mk
include tests/schema/local.mk
include tests/server/local.mk
include tests/service/local.mk
include tests/bench/local.mk
