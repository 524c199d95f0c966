/* The two protocols between systemd and a service, each a few lines, so that no library is needed for them: sockets
 * handed over by the environment (sd_listen_fds(3)) and state messages to a datagram socket (sd_notify(3)).
 */
#ifndef QG_SERVER_BASE_SYSTEMD_H
#define QG_SERVER_BASE_SYSTEMD_H

/* The listening socket that systemd handed over; -1 when there is none, -2 when there are several. */
int qg_systemd_socket(void);

/* Sends a state ("READY=1") to $NOTIFY_SOCKET; does nothing when that is not set. A failure is logged. */
void qg_systemd_notify(const char *state);

#endif
