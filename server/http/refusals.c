/* Which refusals are news. See refusals.h. */
#include "server/http/refusals.h"

#include <stdio.h>
#include <string.h>

enum { INTERVAL_MS = 3600000 };

bool qg_refusal_is_news(struct qg_refusals *refusals, const struct qg_actor *actor, int64_t now) {
    char who[sizeof refusals->seen[0].who];
    int64_t *place = &refusals->others_until;
    snprintf(who, sizeof who, "%s %s", actor->address, actor->token);
    for (size_t i = QG_REFUSALS_MAX; i-- > 0;) {
        if (refusals->seen[i].until > now && strcmp(refusals->seen[i].who, who) == 0)
            return false;
        if (refusals->seen[i].until <= now)
            place = &refusals->seen[i].until;
    }
    if (*place > now)
        return false;
    for (size_t i = 0; i < QG_REFUSALS_MAX; i++)
        if (place == &refusals->seen[i].until)
            memcpy(refusals->seen[i].who, who, sizeof who);
    *place = now + INTERVAL_MS;
    return true;
}
