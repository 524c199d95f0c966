/* The executor without threads. */
#include "core/executor.h"

static void run_serially(void *self, size_t n, qg_piece *piece, void *context) {
    (void)self;
    for (size_t item = 0; item < n; item++)
        piece(context, item, 0);
}

const struct qg_executor qg_serial_executor = {.self = NULL, .workers = 1, .run = run_serially};
