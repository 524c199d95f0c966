/* What is done to a finished reply before it is sent: entity tags and 304 (RFC 9110 13), gzip (RFC 9110 8.4).
 */
#ifndef QG_SERVER_HTTP_ENCODE_H
#define QG_SERVER_HTTP_ENCODE_H

#include "server/http/exchange.h"

/* The entity tag of a text, with its quotes: a hash of its bytes, so equal texts have equal tags, also after a restart. */
enum { QG_ETAG_ROOM = 24 };
void qg_etag(char etag[QG_ETAG_ROOM], const struct qg_text *text);

/* Gives a 200 whose body is a text an entity tag, unless it has one or is not to be stored, and turns it into a 304 without a
 * body when if_none_match (may be NULL) names it. For GET and HEAD only. */
void qg_reply_revalidate(struct qg_reply *reply, const char *if_none_match);

/* Compresses the body, text or stream, unless it is short or an event stream. The client has said that it takes gzip. The
 * entity tag becomes a weak one: the bytes differ from those that are sent without. When memory is short the reply stays as
 * it is. */
void qg_reply_compress(struct qg_reply *reply);

#endif
