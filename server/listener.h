/* The listening socket, and the port it got.
 */
#ifndef QG_SERVER_LISTENER_H
#define QG_SERVER_LISTENER_H

#include <stdbool.h>
#include <stddef.h>

/* Opens a listening TCP socket on "ADDRESS:PORT" (numeric address, or a name of this machine). -1 and a message when it
 * cannot. */
int qg_listener_open(const char *where, char *message, size_t room);

/* True when only this machine can reach a listening socket by its address: 127.0.0.0/8 and ::1. A socket in the file system
 * is not: whoever hands it over decides who gets there, a proxy perhaps. */
bool qg_listener_is_loopback(int listener);

/* Writes "SCHEME://ADDRESS:PORT" of a listening socket to out, and returns the port; 0 for a socket without one. */
int qg_listener_describe(int listener, const char *scheme, char *out, size_t room);

/* Writes a port number and a newline to a file, so that it is there as a whole or not at all. 0, or errno. */
int qg_listener_write_port(const char *file, int port);

#endif
