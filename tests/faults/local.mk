# Faults made on purpose: a disk that fails and memory that runs out when told to.
FAULT_SHIMS = tests/faults/disk.so tests/faults/memory.so
FAULT_TESTS = tests/faults/short.test.mjs
EXTRA_DIST += tests/faults/disk.c tests/faults/memory.c $(FAULT_TESTS) tests/faults/campaigns.mjs tests/faults/day.mjs \
	tests/faults/disk.mjs tests/faults/faults.mjs tests/faults/memory.mjs tests/faults/programs.mjs
CLEANFILES += $(FAULT_SHIMS)
check_DATA = $(FAULT_SHIMS)

FAULT_COMPILE = $(AM_V_CCLD)$(MKDIR_P) tests/faults && $(CC) -D_GNU_SOURCE -std=c17 -O2 $(WARNINGS) -fPIC -shared
tests/faults/disk.so: tests/faults/disk.c
	$(FAULT_COMPILE) '$(srcdir)/tests/faults/disk.c' -o $@ -ldl
tests/faults/memory.so: tests/faults/memory.c
	$(FAULT_COMPILE) '$(srcdir)/tests/faults/memory.c' -o $@ -lgcc_s

# The n-th allocation, the n-th call of SQLite's files.
if HAVE_CMOCKA
check_PROGRAMS += tests/faults/test_faults
TESTS += tests/faults/test_faults
endif
tests_faults_test_faults_SOURCES = tests/faults/test_faults.c
tests_faults_test_faults_CPPFLAGS = $(AM_CPPFLAGS) $(SQLITE_CFLAGS) $(CJSON_CFLAGS)
tests_faults_test_faults_LDADD = $(SERVER_LIBS) $(CMOCKA_LIBS)
tests_faults_test_faults_LDFLAGS = $(AM_LDFLAGS) -Wl,--wrap=malloc -Wl,--wrap=calloc -Wl,--wrap=realloc -Wl,--wrap=strdup

# Whole programs.
if HAVE_NODE
TESTS += $(FAULT_TESTS)
endif
tests/faults/short.test.log: quietgeard quietgear $(FAULT_SHIMS)

# Every n of every scenario, and the figures of docs/reliability.md: about a quarter of an
# hour on two idle processors. FAULT_STRIDE=10 takes every tenth.
FAULT_STRIDE = 1
.PHONY: faults
faults: tests/faults/test_faults $(FAULT_SHIMS) quietgeard quietgear
	$(MKDIR_P) reliability
	printf '%s\n' '{"text":"`make faults FAULT_STRIDE=$(FAULT_STRIDE)`: each scenario is run once for every call that fails in it (`tests/faults/test_faults.c`). The answer has to be the right one, to the last bit, or a clear error; what was promised before has to be in the database, which passes its integrity check. `make check` does the same under fewer n; a build with `--enable-asan` sees leaks. Full, read-only and failing disks under a daemon at work: `tests/service/disk.bats`."}' > reliability/faults.jsonl
	QG_FAULT_FIGURES=reliability/faults.jsonl QG_FAULT_STRIDE=$(FAULT_STRIDE) tests/faults/test_faults
	QG_SOURCE='$(abs_top_srcdir)' QG_BUILD='$(abs_builddir)' $(NODE) $(srcdir)/tests/faults/faults.mjs --stride $(FAULT_STRIDE)
