# Fuzzers. In `make check` each runs its seeds and some counted mutations. `make fuzz` explores with libFuzzer, for FUZZ_SECONDS
# each, in a build of its own by clang under AddressSanitizer and UndefinedBehaviorSanitizer (configure --enable-fuzzing).
# `make check-fuzz` in such a build does so as tests that can run beside each other, from the seeds; part of ./run-tests.
FUZZ_SECONDS = 60
FUZZ_SHARED = tests/fuzz/fuzz.h tests/fuzz/mutate.c
FUZZ_TESTS = tests/fuzz/fuzz_document tests/fuzz/fuzz_core tests/fuzz/fuzz_http
check_PROGRAMS += $(FUZZ_TESTS)
TESTS += $(FUZZ_TESTS)
FUZZ_MINUTES = tests/fuzz/core.bats tests/fuzz/document.bats tests/fuzz/http.bats
EXTRA_DIST += tests/fuzz/explore.sh $(FUZZ_MINUTES)

PATIENCE = tests/fuzz/patience.c tests/fuzz/patience.h
if HAVE_CMOCKA
check_PROGRAMS += tests/fuzz/test_patience
TESTS += tests/fuzz/test_patience
endif
tests_fuzz_test_patience_SOURCES = tests/fuzz/test_patience.c $(PATIENCE)
tests_fuzz_test_patience_CPPFLAGS = $(AM_CPPFLAGS) $(CMOCKA_CFLAGS)
tests_fuzz_test_patience_LDADD = $(CMOCKA_LIBS)

tests_fuzz_fuzz_document_SOURCES = tests/fuzz/fuzz_document.c tests/fuzz/plain_main.c $(FUZZ_SHARED)
tests_fuzz_fuzz_document_LDADD = $(SCHEMA_LIBS)
tests_fuzz_fuzz_core_SOURCES = tests/fuzz/fuzz_core.c tests/fuzz/plain_main.c $(FUZZ_SHARED)
tests_fuzz_fuzz_core_LDADD = $(CORE_LIBS)
tests_fuzz_fuzz_http_SOURCES = tests/fuzz/fuzz_http.c $(PATIENCE) tests/fuzz/plain_main.c $(FUZZ_SHARED)
tests_fuzz_fuzz_http_CPPFLAGS = $(AM_CPPFLAGS) $(CJSON_CFLAGS) $(MICROHTTPD_CFLAGS)
tests_fuzz_fuzz_http_LDADD = $(SERVER_LIBS)

EXTRA_PROGRAMS += tests/fuzz/explore_document tests/fuzz/explore_core tests/fuzz/explore_http
tests_fuzz_explore_document_SOURCES = tests/fuzz/fuzz_document.c tests/fuzz/explore.c $(FUZZ_SHARED)
tests_fuzz_explore_document_LDFLAGS = $(AM_LDFLAGS) -fsanitize=fuzzer
tests_fuzz_explore_document_LDADD = $(SCHEMA_LIBS)
tests_fuzz_explore_core_SOURCES = tests/fuzz/fuzz_core.c tests/fuzz/explore.c $(FUZZ_SHARED)
tests_fuzz_explore_core_LDFLAGS = $(AM_LDFLAGS) -fsanitize=fuzzer
tests_fuzz_explore_core_LDADD = $(CORE_LIBS)
tests_fuzz_explore_http_SOURCES = tests/fuzz/fuzz_http.c $(PATIENCE) tests/fuzz/explore.c $(FUZZ_SHARED)
tests_fuzz_explore_http_CPPFLAGS = $(tests_fuzz_fuzz_http_CPPFLAGS)
tests_fuzz_explore_http_LDFLAGS = $(AM_LDFLAGS) -fsanitize=fuzzer
tests_fuzz_explore_http_LDADD = $(SERVER_LIBS)

# make fuzz-document, fuzz-core, fuzz-http, or fuzz for all of them one after another.
FUZZ_TARGETS = fuzz-document fuzz-core fuzz-http
.PHONY: fuzz check-fuzz fuzzers $(FUZZ_TARGETS)
fuzz: $(FUZZ_TARGETS)
if FUZZING
fuzzers: $(FUZZ_TESTS) tests/fuzz/explore_document tests/fuzz/explore_core tests/fuzz/explore_http
check-fuzz: fuzzers
	FUZZ_SECONDS=$(FUZZ_SECONDS) $(MAKE) check-TESTS check_PROGRAMS='' TESTS='$(FUZZ_MINUTES)'
fuzz-document: tests/fuzz/fuzz_document tests/fuzz/explore_document
fuzz-core: tests/fuzz/fuzz_core tests/fuzz/explore_core
fuzz-http: tests/fuzz/fuzz_http tests/fuzz/explore_http
$(FUZZ_TARGETS):
	QG_SOURCE='$(abs_top_srcdir)' $(SHELL) $(srcdir)/tests/fuzz/explore.sh $(@:fuzz-%=%) $(FUZZ_SECONDS)
else
check-fuzz $(FUZZ_TARGETS):
	$(MKDIR_P) fuzzing
	test -f fuzzing/Makefile || \
		(cd fuzzing && $(abs_top_srcdir)/configure -q --enable-fuzzing --enable-asan --enable-ubsan CC='$(FUZZ_CC)')
	$(MAKE) -s -C fuzzing $@ FUZZ_SECONDS=$(FUZZ_SECONDS)
	test ! -d fuzzing/reliability || { $(MKDIR_P) reliability && \
		cat fuzzing/reliability/fuzzing-about.jsonl fuzzing/reliability/fuzzing-[!a]*.jsonl >reliability/fuzzing.jsonl; }
endif
FUZZ_CC = clang
