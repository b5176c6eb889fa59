/* Derived from src/internal/libm.h of musl 1.2.3: what the files beside this one use of it. */
#ifndef _LIBM_H
#define _LIBM_H

#include <float.h>
#include <math.h>
#include <stdint.h>

#define hidden __attribute__((visibility("hidden")))

#define WANT_ROUNDING 1
#define TOINT_INTRINSICS 0

#define predict_false(x) __builtin_expect(x, 0)

static inline double eval_as_double(double x) { return x; }

static inline double fp_barrier(double x)
{
	volatile double y = x;
	return y;
}

static inline void fp_force_eval(double x)
{
	volatile double y;
	y = x;
	(void)y;
}

#define FORCE_EVAL(x) fp_force_eval(x)

#define asuint64(f) ((union{double _f; uint64_t _i;}){f})._i
#define asdouble(i) ((union{uint64_t _i; double _f;}){i})._f

#define GET_HIGH_WORD(hi,d) do { (hi) = asuint64(d) >> 32; } while (0)
#define GET_LOW_WORD(lo,d) do { (lo) = (uint32_t)asuint64(d); } while (0)
#define INSERT_WORDS(d,hi,lo) do { (d) = asdouble(((uint64_t)(hi)<<32) | (uint32_t)(lo)); } while (0)
#define SET_LOW_WORD(d,lo) INSERT_WORDS(d, asuint64(d)>>32, lo)

/* names that other libraries of C have too */
#define __sin kept_sin
#define __cos kept_cos
static int __rem_pio2_large(double*,double*,int,int,int);
static int __rem_pio2(double,double*);
static double __sin(double,double,int);
static double __cos(double,double);

/* error handling functions */
static inline double __math_xflow(uint32_t sign, double y) { return fp_barrier(sign ? -y : y) * y; }
static inline double __math_uflow(uint32_t sign) { return __math_xflow(sign, 0x1p-767); }
static inline double __math_oflow(uint32_t sign) { return __math_xflow(sign, 0x1p769); }
static inline double __math_divzero(uint32_t sign) { return fp_barrier(sign ? -1.0 : 1.0) / 0.0; }
static inline double __math_invalid(double x) { return (x - x) / (x - x); }

#endif
