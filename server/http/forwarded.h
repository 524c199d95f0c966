/* Who asks when a reverse proxy stands between: X-Forwarded-For, as far as it can be believed.
 *
 * Each proxy appends to the field the address that it was asked from; so the last entry is the word of the host that is
 * connected to us, the last but one the word of the host named last, and so on. Anybody can send the field with entries of his
 * own in it. Therefore it is read from the right, and only as far as the hosts that say it are trusted: the peer, then each
 * host named, have to be in the setting trusted-proxies. The first that is not is the client; what stands left of it is
 * hearsay. An entry that is no address ("unknown", RFC 7239's "_hidden") ends the reading as well: then the host that said it
 * is all that is known. RFC 7239's own field, Forwarded, is not read: few proxies send it, and to believe two fields is to
 * believe the one that a proxy passes on unread.
 */
#ifndef QG_SERVER_HTTP_FORWARDED_H
#define QG_SERVER_HTTP_FORWARDED_H

#include <sys/socket.h>

/* Fills out with the client's address: that of the peer, unless proxies (see qg_addresses_is_list) stand between. field: all
 * lines of X-Forwarded-For in their order, with commas between; NULL is none. Threads: any. */
void qg_forwarded_client(const struct sockaddr *peer, const char *field, const char *proxies,
                         struct sockaddr_storage *out);

#endif
