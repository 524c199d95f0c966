# cli: the command line.
bin_PROGRAMS += quietgear
quietgear_SOURCES = \
	cli/files.c cli/files.h \
	cli/progress.c cli/progress.h \
	cli/quietgear.c
quietgear_LDADD = $(SCHEMA_LIBS)
