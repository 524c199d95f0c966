# systemd: the units. The service's paths are filled in when it is built, so that they follow --prefix.
dist_systemdsystemunit_DATA = systemd/quietgeard.socket
nodist_systemdsystemunit_DATA = systemd/quietgeard.service
EXTRA_DIST += systemd/quietgeard.service.in
CLEANFILES += systemd/quietgeard.service

systemd/quietgeard.service: systemd/quietgeard.service.in Makefile
	$(AM_V_GEN)$(MKDIR_P) systemd && sed -e 's|@bindir[@]|$(bindir)|g' -e 's|@sysconfdir[@]|$(sysconfdir)|g' \
		'$(srcdir)/systemd/quietgeard.service.in' > $@
