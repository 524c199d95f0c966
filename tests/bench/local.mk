# make bench: speed, as JSON lines. Never part of make check.
EXTRA_PROGRAMS += tests/bench/bench tests/bench/bench_macro
tests_bench_bench_SOURCES = tests/bench/bench.c
tests_bench_bench_LDADD = $(CORE_LIBS)
tests_bench_bench_macro_SOURCES = tests/bench/bench_macro.c
tests_bench_bench_macro_LDADD = $(CORE_LIBS)

.PHONY: bench
bench: tests/bench/bench tests/bench/bench_macro
	@./tests/bench/bench
	@./tests/bench/bench_macro

# Search methods against each other; docs/searches.sh writes the page.
EXTRA_PROGRAMS += tests/bench/compare_searches
tests_bench_compare_searches_SOURCES = tests/bench/compare_searches.c tests/bench/candidates.c tests/bench/candidates.h
tests_bench_compare_searches_LDADD = $(SCHEMA_LIBS)
CLEANFILES += tests/bench/compare_searches
