/* sin, cos, exp, expm1, log and log1p: those of the folder `libm`, in place of the system's.
 *
 * The libraries of C differ in the last bit of these functions, so runs would differ between
 * systems. `hatch_build.py` keeps the compiler from putting in others for them; the linker finds
 * these first. */
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wsign-conversion"
#pragma GCC diagnostic ignored "-Wfloat-conversion"
#pragma GCC diagnostic ignored "-Wparentheses"
#pragma GCC diagnostic ignored "-Wsign-compare"
#pragma GCC diagnostic ignored "-Wunused-const-variable"
#ifndef __clang__ /* which does not know this one */
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#endif

/* All levels take the way without a fused multiply-add. */
#undef __FP_FAST_FMA

#include "libm/libm.h"

#include "libm/__cos.c"
#include "libm/__rem_pio2.c"
#include "libm/__rem_pio2_large.c"
#include "libm/__sin.c"
#include "libm/cos.c"
#include "libm/log1p.c"
#include "libm/sin.c"
/* each with names of its own */
#define ln2_hi expm1_ln2_hi
#define ln2_lo expm1_ln2_lo
#include "libm/exp.c"
#include "libm/exp_data.c"
#include "libm/expm1.c"
#undef N
#undef T
#include "libm/log.c"
#include "libm/log_data.c"
