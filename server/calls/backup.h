/* The call that hands out a copy of the database (store/backup.h).
 *
 * GET /v1/backup            200 and the database as it was when the copy began, as a SQLite file, checked; asks for the scope
 *                          admin. One at a time: 503 while another one is made.
 */
#ifndef QG_SERVER_CALLS_BACKUP_H
#define QG_SERVER_CALLS_BACKUP_H

#include "server/http/exchange.h"

qg_handler qg_get_backup; /* GET /v1/backup */

#endif
