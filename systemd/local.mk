# systemd: the units. The paths of the service and of the settings are filled in when they are built, so that they
# follow --prefix.
dist_systemdsystemunit_DATA = systemd/quietgeard.socket
nodist_systemdsystemunit_DATA = systemd/quietgeard.service
# What messages mean, for `journalctl -x`.
catalogdir = $(prefix)/lib/systemd/catalog
dist_catalog_DATA = systemd/quietgear.catalog
sysusersdir = $(prefix)/lib/sysusers.d
tmpfilesdir = $(prefix)/lib/tmpfiles.d
EXTRA_DIST += systemd/quietgear.sysusers systemd/quietgear.tmpfiles.in
EXTRA_DIST += systemd/quietgeard.service.in
CLEANFILES += systemd/quietgeard.service systemd/quietgear.tmpfiles
all-local: systemd/quietgear.tmpfiles

systemd/quietgear.tmpfiles: systemd/quietgear.tmpfiles.in Makefile
	$(AM_V_GEN)$(MKDIR_P) systemd && sed -e 's|@sysconfdir[@]|$(sysconfdir)|g' '$(srcdir)/systemd/quietgear.tmpfiles.in' > $@

systemd/quietgeard.service: systemd/quietgeard.service.in Makefile
	$(AM_V_GEN)$(MKDIR_P) systemd && sed -e 's|@bindir[@]|$(bindir)|g' -e 's|@sysconfdir[@]|$(sysconfdir)|g' \
		'$(srcdir)/systemd/quietgeard.service.in' > $@

install-data-local: systemd/quietgear.tmpfiles
	$(MKDIR_P) '$(DESTDIR)$(sysusersdir)' '$(DESTDIR)$(tmpfilesdir)'
	$(INSTALL_DATA) '$(srcdir)/systemd/quietgear.sysusers' '$(DESTDIR)$(sysusersdir)/quietgear.conf'
	$(INSTALL_DATA) systemd/quietgear.tmpfiles '$(DESTDIR)$(tmpfilesdir)/quietgear.conf'

uninstall-local:
	rm -f '$(DESTDIR)$(sysusersdir)/quietgear.conf' '$(DESTDIR)$(tmpfilesdir)/quietgear.conf'
