# make bench: speed, as JSON lines. Never part of make check.
EXTRA_PROGRAMS += tests/bench/bench
tests_bench_bench_SOURCES = tests/bench/bench.c
tests_bench_bench_LDADD = $(CORE_LIBS)

.PHONY: bench
bench: tests/bench/bench
	@./tests/bench/bench
