# Faults made on purpose: a disk that fails when told to.
EXTRA_DIST += tests/faults/disk.c
CLEANFILES += tests/faults/disk.so
check_DATA = tests/faults/disk.so

tests/faults/disk.so: tests/faults/disk.c
	$(AM_V_CCLD)$(MKDIR_P) tests/faults && $(CC) -D_GNU_SOURCE -std=c17 -O2 $(WARNINGS) -fPIC -shared '$(srcdir)/tests/faults/disk.c' \
		-o $@ -ldl
