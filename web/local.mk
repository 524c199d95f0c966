# web: the page. $(webdir) is defined in server/local.mk, which compiles it into the daemon.
dist_web_DATA = \
	web/index.html \
	web/page.css \
	web/page.js
