# Load. The short form is part of `make check`; the campaigns measure, and write figures for docs/reliability.md.
LOAD_TESTS = tests/load/short.test.mjs
# Of what memory a daemon takes; sanitizers take more.
MEMORY_TESTS = tests/load/memory.test.mjs
EXTRA_DIST += $(LOAD_TESTS) $(MEMORY_TESTS) tests/load/crowds.mjs tests/load/drive.mjs tests/load/heavy.mjs \
	tests/load/load.mjs tests/load/memory.mjs tests/load/soak.mjs
if HAVE_NODE
TESTS += $(LOAD_TESTS) $(MEMORY_TESTS)
endif
tests/load/short.test.log tests/load/memory.test.log: quietgeard

EXTRA_PROGRAMS += tests/load/claims
CLEANFILES += tests/load/claims
tests_load_claims_SOURCES = tests/load/claims.c
tests_load_claims_LDADD = $(SERVER_LIBS)

# Latency at a constant rate, a long queue, many event streams, lighttpd for comparison: three minutes of an idle machine.
.PHONY: load soak
load: quietgeard tests/load/claims
	QG_SOURCE='$(abs_top_srcdir)' QG_BUILD='$(abs_builddir)' $(NODE) $(srcdir)/tests/load/load.mjs $(LOAD_FLAGS)

# Crowds that want the daemon to hold much, its memory held to bounds: a minute or two.
.PHONY: memory
memory: quietgeard
	QG_SOURCE='$(abs_top_srcdir)' QG_BUILD='$(abs_builddir)' $(NODE) $(srcdir)/tests/load/memory.mjs

# Mixed traffic for SOAK_MINUTES, memory watched.
SOAK_MINUTES = 30
soak: quietgeard
	QG_SOURCE='$(abs_top_srcdir)' QG_BUILD='$(abs_builddir)' $(NODE) $(srcdir)/tests/load/soak.mjs --minutes $(SOAK_MINUTES)
