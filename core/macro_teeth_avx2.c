/* Tooth numbers for AVX2; see macro_teeth_kernel.h. */
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#pragma GCC target("avx2")
#endif
#define QG_TEETH_HITS qg_teeth_hits_avx2
#include "core/macro_teeth_kernel.h"
