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
