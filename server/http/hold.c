/* The memory that clients hold. See hold.h. */
#include "server/http/hold.h"

#include <assert.h>

bool qg_hold_take(struct qg_hold *hold, size_t bytes) {
    size_t held = atomic_load(&hold->held);
    do {
        bool fits = held <= hold->allowance && bytes <= hold->allowance - held;
        if (!fits && held > hold->allowance / 8)
            return false;
    } while (!atomic_compare_exchange_weak(&hold->held, &held, held + bytes));
    return true;
}

void qg_hold_force(struct qg_hold *hold, size_t bytes) {
    atomic_fetch_add(&hold->held, bytes);
}

void qg_hold_give(struct qg_hold *hold, size_t bytes) {
    size_t before = atomic_fetch_sub(&hold->held, bytes);
    assert(before >= bytes);
    (void)before;
}
