/* Drawings of a design: profile data as JSON, or DXF by Accept: image/vnd.dxf; displacement and stress. What each call answers is in drawings.c.
 */
#ifndef QG_SERVER_CALLS_DRAWINGS_H
#define QG_SERVER_CALLS_DRAWINGS_H

#include "server/http/exchange.h"

#define QG_DXF "image/vnd.dxf"

qg_handler qg_post_profile;    /* POST /v1/profile */
qg_handler qg_get_job_profile; /* GET /v1/jobs/{id}/profile */
qg_handler qg_get_job_field;   /* GET /v1/jobs/{id}/field */

#endif
