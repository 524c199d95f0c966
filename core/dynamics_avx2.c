/* The batched integrator for AVX2; see dynamics_kernel.h. */
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#pragma GCC target("avx2")
#endif
#define QG_RUN_BLOCK qg_run_block_avx2
#include "core/dynamics_kernel.h"
