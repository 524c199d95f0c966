/* The headers that cmocka wants before its own, in one place. */
#ifndef QG_TESTS_SERVER_SUPPORT_H
#define QG_TESTS_SERVER_SUPPORT_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#endif
