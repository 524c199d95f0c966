# docs: the pages, and the scripts that write and draw them.
EXTRA_DIST += \
	docs/before-after.svg \
	docs/branches-B.svg \
	docs/branches-S.svg \
	docs/branches.md \
	docs/compare_definitions.sh \
	docs/deployment.md docs/operations.md \
	docs/http_hostility.md \
	docs/integration.md \
	docs/plm_client.py \
	docs/http_hostility.sh \
	docs/load-dependent-B.svg \
	docs/load_dependent.md \
	docs/page-compare.png \
	docs/page-job-dark.png \
	docs/page-job.png \
	docs/page-jobs.png \
	docs/page-map.png \
	docs/page-new.png \
	docs/macro.md \
	docs/macro.sh \
	docs/macro.svg \
	docs/performance.md \
	docs/plot_branches.sh \
	docs/plot_response.sh \
	docs/reliefs.md \
	docs/reliability.md docs/reliability.sh \
	docs/reliefs.sh \
	docs/searches.md \
	docs/searches.sh \
	docs/render_performance.sh \
	docs/webhooks.md \
	docs/validation-calculix.svg \
	docs/validation-optima.svg \
	docs/validation-starts.svg \
	docs/validation-stresses.svg \
	docs/validation.md \
	docs/validation.sh

# Runs the cases of the paper and writes docs/validation.md with its plots into the sources; needs gnuplot, takes two minutes.
.PHONY: validation
validation: quietgear tests/bench/bench
	PATH="$(abs_builddir):$$PATH" $(srcdir)/docs/validation.sh $(abs_builddir)/tests/bench/bench

# What hostile clients get, into docs/http_hostility.md in the sources; needs node, takes two minutes.
.PHONY: hostility
hostility: quietgeard
	PATH="$(abs_builddir):$$PATH" $(srcdir)/docs/http_hostility.sh

# Search methods against each other, into docs/searches.md of the sources: some eight minutes of processor time, five of two
# idle cores. SEEDS and SPEEDS make it shorter.
.PHONY: compare-searches
compare-searches: tests/bench/compare_searches
	$(srcdir)/docs/searches.sh $(abs_builddir)/tests/bench/compare_searches $(SEEDS) $(SPEEDS)

# What the campaigns (make fuzz, load, soak, ...) have left in this build tree, into docs/reliability.md in the sources.
.PHONY: reliability
reliability:
	$(srcdir)/docs/reliability.sh $(abs_builddir)
