# server: quietgeard. Everything but main.c is a library, so that the tests can link it.
bin_PROGRAMS += quietgeard
noinst_LIBRARIES += libserver.a
libserver_a_SOURCES = \
	server/access.c server/access.h \
	server/access_api.c server/access_api.h \
	server/address.c server/address.h \
	server/api.c server/api.h \
	server/attempt.c server/attempt.h \
	server/backup.c server/backup.h server/restore.c \
	server/board.c server/board.h \
	server/clock.c server/clock.h \
	server/cors.c server/cors.h \
	server/design_copy.c server/design_copy.h \
	server/documents.c server/documents.h \
	server/drawings.c server/drawings.h \
	server/encode.c server/encode.h \
	server/events.c server/events.h \
	server/examples.c server/examples.h \
	server/exchange.c server/exchange.h \
	server/field_maker.c server/field_maker.h \
	server/files.c server/files.h \
	server/form.c server/form.h \
	server/guests.c server/guests.h \
	server/http.c server/http.h \
	server/job_copies.c server/job_copies.h \
	server/job_text.c server/job_text.h \
	server/listener.c server/listener.h \
	server/log.c server/log.h \
	server/metrics.c server/metrics.h \
	server/origin.c server/origin.h \
	server/outputs.c \
	server/member.c server/member.h \
	server/problem.c server/problem.h \
	server/routes.c server/routes.h \
	server/retention.c server/retention.h \
	server/runner.c server/runner.h \
	server/secret.c server/secret.h \
	server/sender.c server/sender.h \
	server/settings.c server/settings.h \
	server/store.c server/store.h \
	server/store_access.c server/store_access.h \
	server/store_attempts.c \
	server/store_webhooks.c server/store_webhooks.h \
	server/store_format.c \
	server/store_internal.h \
	server/store_jobs.c \
	server/stream.c server/stream.h \
	server/systemd.c server/systemd.h \
	server/target.c server/target.h \
	server/tls.c server/tls.h \
	server/token.c server/token.h \
	server/watchdog.c server/watchdog.h \
	server/webhook.c server/webhook.h \
	server/webhook_api.c server/webhook_api.h
libserver_a_CPPFLAGS = $(AM_CPPFLAGS) $(SQLITE_CFLAGS) $(MICROHTTPD_CFLAGS) $(GNUTLS_CFLAGS) $(ZLIB_CFLAGS) $(CURL_CFLAGS) \
	-DQG_WEB_DIR='"$(webdir)"' -DQG_SCHEMA_DIR='"$(schemadir)"' \
	-DQG_STATE_DIR='"$(localstatedir)/lib/quietgear"' \
	-DQG_CONFIG_FILE='"$(sysconfdir)/quietgear/quietgeard.conf"'
SERVER_LIBS = libserver.a $(SCHEMA_LIBS) $(CORE_LIBS) $(SQLITE_LIBS) $(MICROHTTPD_LIBS) $(GNUTLS_LIBS) $(ZLIB_LIBS) $(CURL_LIBS)

quietgeard_SOURCES = server/main.c
quietgeard_LDADD = $(SERVER_LIBS)

webdir = $(pkgdatadir)/web

# The settings with their defaults, to be copied to $(sysconfdir)/quietgear/.
dist_doc_DATA = server/quietgeard.conf
