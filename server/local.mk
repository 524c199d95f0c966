# server: quietgeard. Everything but main.c is a library, so that the tests can link it.
bin_PROGRAMS += quietgeard
noinst_LIBRARIES += libserver.a
libserver_a_SOURCES = \
	server/base/address.c server/base/address.h \
	server/base/clock.c server/base/clock.h \
	server/base/journal.c server/base/journal.h \
	server/base/log.c server/base/log.h \
	server/base/log_entry.c server/base/log_entry.h \
	server/base/log_limit.c server/base/log_limit.h \
	server/base/machine.c server/base/machine.h \
	server/base/member.c server/base/member.h \
	server/base/secret.c server/base/secret.h \
	server/base/systemd.c server/base/systemd.h \
	server/base/token.c server/base/token.h \
	server/base/webhook.c server/base/webhook.h \
	server/store/access.c server/store/access.h \
	server/store/attempts.c \
	server/store/backup.c server/store/backup.h \
	server/store/expiry.c server/store/expiry.h \
	server/store/format.c \
	server/store/internal.h \
	server/store/jobs.c \
	server/store/restore.c \
	server/store/store.c server/store/store.h \
	server/store/webhooks.c server/store/webhooks.h \
	server/work/attempt.c server/work/attempt.h \
	server/work/board.c server/work/board.h \
	server/work/field_maker.c server/work/field_maker.h \
	server/work/job_copies.c server/work/job_copies.h \
	server/work/job_text.c server/work/job_text.h \
	server/work/metrics.c server/work/metrics.h \
	server/work/retention.c server/work/retention.h \
	server/work/runner.c server/work/runner.h \
	server/work/sender.c server/work/sender.h \
	server/work/watchdog.c server/work/watchdog.h \
	server/http/access.c server/http/access.h \
	server/http/access_log.c server/http/access_log.h \
	server/http/admit.c server/http/internal.h \
	server/http/send.c \
	server/http/authorize.c server/http/authorize.h \
	server/http/cors.c server/http/cors.h \
	server/http/encode.c server/http/encode.h \
	server/http/exchange.c server/http/exchange.h \
	server/http/forwarded.c server/http/forwarded.h \
	server/http/guests.c server/http/guests.h \
	server/http/hold.c server/http/hold.h \
	server/http/http.c server/http/http.h \
	server/http/nudge.c server/http/nudge.h \
	server/http/origin.c server/http/origin.h \
	server/http/problem.c server/http/problem.h \
	server/http/refusals.c server/http/refusals.h \
	server/http/routes.c server/http/routes.h \
	server/http/stream.c server/http/stream.h \
	server/http/target.c server/http/target.h \
	server/http/tls.c server/http/tls.h \
	server/calls/access.c server/calls/access.h \
	server/calls/backup.c server/calls/backup.h \
	server/calls/documents.c server/calls/documents.h \
	server/calls/drawings.c server/calls/drawings.h \
	server/calls/events.c server/calls/events.h \
	server/calls/examples.c server/calls/examples.h \
	server/calls/files.c server/calls/files.h \
	server/calls/form.c server/calls/form.h \
	server/calls/jobs.c server/calls/jobs.h \
	server/calls/metrics.c server/calls/metrics.h \
	server/calls/outputs.c \
	server/calls/table.c server/calls/table.h \
	server/calls/webhooks.c server/calls/webhooks.h \
	server/listener.c server/listener.h \
	server/settings.c server/settings.h
# Files as the log names them: from the top of the source tree, wherever that is.
QG_PREFIX_MAP = -fmacro-prefix-map='$(srcdir)/='
libserver_a_CPPFLAGS = $(AM_CPPFLAGS) $(QG_PREFIX_MAP) $(SQLITE_CFLAGS) $(MICROHTTPD_CFLAGS) $(GNUTLS_CFLAGS) $(ZLIB_CFLAGS) $(CURL_CFLAGS) \
	-DQG_WEB_DIR='"$(webdir)"' -DQG_SCHEMA_DIR='"$(schemadir)"' \
	-DQG_STATE_DIR='"$(localstatedir)/lib/quietgear"' \
	-DQG_CONFIG_FILE='"$(sysconfdir)/quietgear/quietgeard.conf"'
SERVER_LIBS = libserver.a $(SCHEMA_LIBS) $(CORE_LIBS) $(SQLITE_LIBS) $(MICROHTTPD_LIBS) $(GNUTLS_LIBS) $(ZLIB_LIBS) $(CURL_LIBS)

quietgeard_SOURCES = server/main.c
quietgeard_CPPFLAGS = $(AM_CPPFLAGS) $(QG_PREFIX_MAP)
quietgeard_LDADD = $(SERVER_LIBS)

webdir = $(pkgdatadir)/web

# The settings with their defaults, to be copied to $(sysconfdir)/quietgear/.
dist_doc_DATA = server/quietgeard.conf
