# Scripts that drive the real daemon with curl on a loopback port of its own choosing.
SERVICE_TESTS = \
	tests/service/jobs.bats \
	tests/service/refusals.bats \
	tests/service/restart.bats
EXTRA_DIST += $(SERVICE_TESTS) tests/service/helper.bash

if HAVE_BATS
TESTS += $(SERVICE_TESTS)
endif
$(SERVICE_TESTS:.bats=.log): quietgeard
