# The page: its modules by themselves, and its views in headless Chromium against a real daemon.
PAGE_TESTS = \
	tests/page/access.test.mjs \
	tests/page/drawings.test.mjs \
	tests/page/form.test.mjs \
	tests/page/modules.test.mjs \
	tests/page/new.test.mjs \
	tests/page/recovery.test.mjs \
	tests/page/results.test.mjs \
	tests/page/view.test.mjs
EXTRA_DIST += $(PAGE_TESTS) tests/page/harness.mjs

if HAVE_NODE
TESTS += $(PAGE_TESTS)
endif
tests/page/access.test.log tests/page/drawings.test.log tests/page/new.test.log tests/page/recovery.test.log \
	tests/page/results.test.log tests/page/view.test.log: quietgeard web/dist/page.js

# How soon a finished job is seen, in ms; a figure to look at, not a test: it depends on the machine.
.PHONY: page-speed
page-speed: quietgeard web/dist/page.js
	@QG_SOURCE='$(abs_top_srcdir)' QG_BUILD='$(abs_top_builddir)' $(NODE) --test-reporter=tap \
		--test-name-pattern='first paint' $(srcdir)/tests/page/view.test.mjs | sed -n 's/^# \(ms after\)/\1/p'

# Draws the page's pictures in docs/ anew.
EXTRA_DIST += tests/page/screenshots.mjs
.PHONY: screenshots
screenshots: quietgeard web/dist/page.js
	QG_SOURCE='$(abs_top_srcdir)' QG_BUILD='$(abs_top_builddir)' $(NODE) $(srcdir)/tests/page/screenshots.mjs $(srcdir)/docs
