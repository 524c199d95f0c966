/* The batched integrator for any processor; see dynamics_kernel.h. */
#define QG_RUN_BLOCK qg_run_block_baseline
#include "core/dynamics_kernel.h"
