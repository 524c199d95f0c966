/* Tooth numbers for AVX-512; see macro_teeth_kernel.h. */
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#pragma GCC target("avx512f,avx512dq,avx512vl,avx512bw")
#endif
#define QG_TEETH_HITS qg_teeth_hits_avx512
#include "core/macro_teeth_kernel.h"
