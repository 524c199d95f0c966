# web: the page. $(webdir) is defined in server/local.mk, which compiles it into the daemon. web/dist is made by esbuild from
# web/src with the libraries that web/package-lock.json names; a release carries it, so that only a checkout needs npm.
WEB_FILES = \
	web/index.html \
	web/icon.svg \
	web/src/api.js \
	web/src/events.js \
	web/src/format.js \
	web/src/jobs.js \
	web/src/drawings/files.js \
	web/src/drawings/relief.jsx \
	web/src/drawings/stress.jsx \
	web/src/drawings/take-away.js \
	web/src/drawings/teeth.jsx \
	web/src/figures/curves.js \
	web/src/figures/designs.js \
	web/src/figures/search.js \
	web/src/form/check.js \
	web/src/form/document.js \
	web/src/form/draft.js \
	web/src/form/editor.jsx \
	web/src/form/fields.jsx \
	web/src/form/form.css \
	web/src/form/schema.js \
	web/src/form/sections.jsx \
	web/src/form/suggest.js \
	web/src/job-data.js \
	web/src/main.jsx \
	web/src/css/base.css \
	web/src/css/controls.css \
	web/src/css/frame.css \
	web/src/css/narrow.css \
	web/src/css/plots.css \
	web/src/css/report.css \
	web/src/css/tables.css \
	web/src/page.css \
	web/src/router.js \
	web/src/store.js \
	web/src/theme.js \
	web/src/parts/long-table.jsx \
	web/src/parts/parts.jsx \
	web/src/parts/relief-table.jsx \
	web/src/parts/standard-table.jsx \
	web/src/plots/draw.js \
	web/src/plots/menu.jsx \
	web/src/plots/painters.js \
	web/src/plots/palette.js \
	web/src/plots/picture.js \
	web/src/plots/plot.jsx \
	web/src/plots/read.js \
	web/src/views/compare.jsx \
	web/src/views/job-drawings.jsx \
	web/src/views/job-head.jsx \
	web/src/views/job-stress.jsx \
	web/src/views/job.jsx \
	web/src/views/jobs.jsx \
	web/src/views/key-figures.jsx \
	web/src/views/macro.jsx \
	web/src/views/new.jsx \
	web/src/views/reliability.jsx \
	web/src/views/report.jsx
EXTRA_DIST += $(WEB_FILES) web/build.sh web/package.json web/package-lock.json web/.npmrc

dist_web_DATA = \
	web/dist/page.js \
	web/dist/page.css \
	web/dist/index.html \
	web/dist/icon.svg \
	web/dist/licences.txt

web/dist/page.js: $(WEB_FILES) web/build.sh web/package-lock.json
	$(AM_V_GEN)$(SHELL) $(srcdir)/web/build.sh $(srcdir)/web web $(VERSION)
# made by the same command
web/dist/page.css web/dist/index.html web/dist/icon.svg web/dist/licences.txt: web/dist/page.js
	@:

MAINTAINERCLEANFILES = $(dist_web_DATA)
distclean-local:
	rm -rf web/npm
