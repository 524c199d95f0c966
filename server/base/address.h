/* Addresses and lists of them; where webhooks may go: rules on addresses, and rules on URLs.
 *
 * Whoever may make a webhook decides where this machine sends requests, so without rules a webhook would reach services
 * that trust this machine or its network (server-side request forgery). Two rules hold it back, and both have to agree:
 *
 *   The URL has to match one of the setting webhook-allow: scheme, host and port are those of the rule, its path begins with
 *   the rule's. A host that begins with "*." stands for all hosts below the rest, and not for the rest itself.
 *
 *   The address that is connected to must be a public one, and not of this machine, unless the setting webhook-networks
 *   lists its network. This is judged when the socket is opened, on the very address that is connected to, so it does not
 *   matter what a name resolves to at another time (DNS rebinding), nor how an address is written (2130706433, 0x7f.1,
 *   ::ffff:127.0.0.1).
 *
 * Special addresses are those of IANA's special-purpose registries (RFC 6890 and its updates) that are not globally
 * reachable, with multicast and 6to4. Threads: all functions from any.
 */
#ifndef QG_SERVER_BASE_ADDRESS_H
#define QG_SERVER_BASE_ADDRESS_H

#include <netinet/in.h>
#include <stdbool.h>
#include <stddef.h>
#include <sys/socket.h>

enum { QG_URL_MAX = 1000 };

/* True for a list of networks with blanks or commas between, "10.1.0.0/16 fd00::/8"; "" is none. */
bool qg_networks_is_list(const char *networks);

/* Reads an IPv4 or IPv6 address in numbers, without a port. False when it is none. */
bool qg_address_read(const char *text, struct sockaddr_storage *out);

/* True for a list of networks and of single addresses with blanks or commas between, "10.1.0.0/16 10.2.3.4 unix"; "unix"
 * stands for whoever comes by a socket of the file system; "" is none. */
bool qg_addresses_is_list(const char *list);

/* True when an address, of whatever family, is in such a list. */
bool qg_address_is_listed(const struct sockaddr *address, const char *list);

/* True when a connection to an IPv4 or IPv6 address may be made: it is in one of the networks, or it is neither special nor
 * of this machine. False for all other families. */
bool qg_address_is_allowed(const struct sockaddr *address, const char *networks);

/* True when this machine has an IPv4 or IPv6 address, which is when a socket can be bound to it; whatever else hinders that
 * counts as yes. (Asking for the list of interfaces would take a netlink socket, which the systemd unit forbids.) */
bool qg_address_is_own(const struct sockaddr *address);

/* True for a list of URL rules with blanks or commas between; "" is none. False with errno ENOMEM: memory is short. */
bool qg_url_rules_is_list(const char *rules);

/* Judges a URL by both rules, by the second one as far as it holds an address instead of a name. Returns NULL when it may
 * be used, else words on why not (static); these, when memory is short. */
extern const char qg_url_no_memory[];
const char *qg_url_refusal(const char *url, const char *rules, const char *networks);

#endif
