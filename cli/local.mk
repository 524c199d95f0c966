# cli: the command line.
bin_PROGRAMS += quietgear
quietgear_SOURCES = \
	cli/audit.c \
	cli/backup.c \
	cli/client.c \
	cli/commands.h \
	cli/daemon.c cli/daemon.h \
	cli/export.c \
	cli/files.c cli/files.h \
	cli/job.c cli/job.h \
	cli/http.c cli/http.h \
	cli/progress.c cli/progress.h \
	cli/quietgear.c \
	cli/run.c \
	cli/token.c \
	cli/words.c cli/words.h
quietgear_CPPFLAGS = $(AM_CPPFLAGS) $(CJSON_CFLAGS) $(CURL_CFLAGS)
quietgear_LDADD = $(SCHEMA_LIBS) $(CURL_LIBS)
