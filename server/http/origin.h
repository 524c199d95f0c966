/* Whether a request was meant for this server, and whether a page of another origin sent it.
 *
 * DNS rebinding: a page of evil.example can make a browser believe that evil.example is 127.0.0.1 and then read this server
 * as its own. Such requests carry "Host: evil.example": so the name in Host must be ours. Numeric addresses, localhost and
 * *.localhost are: no name service stands behind them. Others are ours when the settings say so.
 *
 * Cross-site requests: a page elsewhere can make a browser POST here without reading the answer. Browsers add Origin to every
 * such request: on calls that change something it must be ours. Programs send none, which is allowed.
 */
#ifndef QG_SERVER_HTTP_ORIGIN_H
#define QG_SERVER_HTTP_ORIGIN_H

#include <stdbool.h>

/* True for a list of allowed hosts: names separated by commas or blanks; "*" is any. */
bool qg_hosts_are_valid(const char *allowed);

enum qg_host_verdict { QG_HOST_OURS, QG_HOST_FOREIGN, QG_HOST_MALFORMED };

/* Judges a Host field ("name", "name:port", "[::1]:port"). allowed is a list as above. Threads: any. */
enum qg_host_verdict qg_host_judge(const char *host, const char *allowed);

/* True when an Origin field ("http://name:port") is that of the host that the request went to, or of an allowed one. */
bool qg_origin_is_ours(const char *origin, const char *host, const char *allowed);

#endif
