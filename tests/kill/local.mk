# kill -9. The short form is part of `make check`.
KILL_TESTS = tests/kill/short.test.mjs
EXTRA_DIST += $(KILL_TESTS) tests/kill/campaign.mjs tests/kill/kill.mjs
if HAVE_NODE
TESTS += $(KILL_TESTS)
endif
tests/kill/short.test.log: quietgeard quietgear

# KILL_ROUNDS kills at random moments under load: five minutes.
KILL_ROUNDS = 200
KILL_SEED = 1
.PHONY: kill
kill: quietgeard quietgear
	QG_SOURCE='$(abs_top_srcdir)' QG_BUILD='$(abs_builddir)' $(NODE) $(srcdir)/tests/kill/kill.mjs --rounds $(KILL_ROUNDS) --seed $(KILL_SEED)
