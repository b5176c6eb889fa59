/* What this library is, as hatch_build.py said when it was compiled, and what the processor can. */
#include "core.h"

#if defined(__x86_64__)
#include <cpuid.h>
#endif

const char *core_compiler(void) { return CORE_COMPILER; }

const char *core_flags(void) { return CORE_FLAGS; }

const char *core_level(void) { return CORE_LEVEL; }

const char *core_model(void) { return CORE_MODEL; }

const char *core_sources(void) { return CORE_SOURCES; }

const char *core_version(void) { return CORE_VERSION; }

#if defined(__x86_64__)

/* Which parts of a processor's state the system saves: XCR0. */
static unsigned saved_state(void)
{
    unsigned low, high;
    __asm__("xgetbv" : "=a"(low), "=d"(high) : "c"(0));
    return low;
}

/* The levels are those of the psABI of x86-64; a level counts only if the system saves its
 * registers, too: bits 1 and 2 of XCR0 for 256 bits, 5 to 7 for 512. */
int core_widest_level(void)
{
    const unsigned basic = bit_SSE3 | bit_SSSE3 | bit_FMA | bit_CMPXCHG16B | bit_SSE4_1 | bit_SSE4_2
                           | bit_MOVBE | bit_POPCNT | bit_OSXSAVE | bit_AVX | bit_F16C;
    const unsigned extended = bit_LAHF_LM | bit_ABM;
    const unsigned v3 = bit_BMI | bit_AVX2 | bit_BMI2;
    const unsigned v4 = bit_AVX512F | bit_AVX512DQ | bit_AVX512CD | bit_AVX512BW | bit_AVX512VL;
    unsigned a, b, c, d;
    if (!__get_cpuid(1, &a, &b, &c, &d) || (c & basic) != basic || (saved_state() & 0x6) != 0x6)
        return 0;
    if (!__get_cpuid(0x80000001, &a, &b, &c, &d) || (c & extended) != extended)
        return 0;
    if (!__get_cpuid_count(7, 0, &a, &b, &c, &d) || (b & v3) != v3)
        return 0;
    return (b & v4) == v4 && (saved_state() & 0xe6) == 0xe6 ? 2 : 1;
}

#else

int core_widest_level(void) { return 0; }

#endif
