/* The batched integrator for AVX-512; see dynamics_kernel.h. */
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#pragma GCC target("avx512f,avx512dq,avx512vl,avx512bw")
#endif
#define QG_RUN_BLOCK qg_run_block_avx512
#include "core/dynamics_kernel.h"
