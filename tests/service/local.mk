# Scripts that drive the real daemon with curl on a loopback port of its own choosing.
SERVICE_TESTS = \
	tests/service/access.bats \
	tests/service/backup.bats \
	tests/service/check.bats \
	tests/service/contract.bats \
	tests/service/disk.bats \
	tests/service/events.bats \
	tests/service/examples.bats \
	tests/service/drawings.bats \
	tests/service/hostility.bats \
	tests/service/http.bats \
	tests/service/integration.bats \
	tests/service/jobs.bats \
	tests/service/log.bats \
	tests/service/metrics.bats \
	tests/service/proxy.bats \
	tests/service/refusals.bats \
	tests/service/restart.bats \
	tests/service/systemd.bats \
	tests/service/tls.bats \
	tests/service/webhooks.bats
EXTRA_DIST += $(SERVICE_TESTS) tests/service/helper.bash tests/service/agreement.mjs tests/service/contract.mjs \
	tests/service/burst.mjs tests/service/differences.tsv tests/service/hostility.mjs tests/service/metrics.mjs \
	tests/service/judge_dxf.py tests/service/polls.mjs tests/service/proxy.mjs tests/service/receiver.mjs tests/tsan.supp

if HAVE_BATS
TESTS += $(SERVICE_TESTS)
endif
$(SERVICE_TESTS:.bats=.log): quietgeard quietgear

# The command line, by itself and against a daemon; FULL_SIZE_TESTS are about figures that only whole optimizations have.
FULL_SIZE_TESTS = tests/service/acceptance.bats
CLI_TESTS = \
	tests/service/cli.bats \
	tests/service/client.bats \
	tests/service/export.bats \
	tests/service/macro.bats \
	tests/service/map.bats \
	tests/service/reliefs.bats \
	tests/service/searches.bats \
	tests/service/stresses.bats
EXTRA_DIST += $(FULL_SIZE_TESTS) $(CLI_TESTS) tests/service/calculix.awk
if HAVE_BATS
TESTS += $(FULL_SIZE_TESTS) $(CLI_TESTS)
endif
$(FULL_SIZE_TESTS:.bats=.log) $(CLI_TESTS:.bats=.log): quietgear
tests/service/client.log tests/service/macro.log tests/service/map.log tests/service/searches.log: quietgear quietgeard
tests/service/disk.log tests/service/systemd.log: tests/faults/disk.so
