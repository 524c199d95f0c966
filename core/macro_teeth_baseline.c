/* Tooth numbers for any processor; see macro_teeth_kernel.h. */
#define QG_TEETH_HITS qg_teeth_hits_baseline
#include "core/macro_teeth_kernel.h"
