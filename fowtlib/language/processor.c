/* Whether there are vectors for this compiler and processor, VECTORS; words for text in them; how wide the processor's are.
 *
 * gcc for Windows keeps too few bytes of the stack aligned for wide ones, and other compilers have other ones. */
#if defined(__GNUC__) && (defined(__x86_64__) || defined(__aarch64__)) && !(defined(_WIN32) && !defined(__clang__))
#define VECTORS
#define INLINE static inline __attribute__((always_inline))
#define APART static __attribute__((noinline))
#ifdef __clang__
#define EACH
#else
#define EACH _Pragma("GCC unroll 24") /* a loop over lanes or rows, which is not to be one */
#endif

#ifdef __x86_64__
#include <cpuid.h>

/* Lanes of the widest vectors that the processor has and the system keeps. */
static int widest(void) {
    unsigned a, b, c, d, low, high;
    if (!__get_cpuid(1, &a, &b, &c, &d) || !(c & bit_OSXSAVE) || !(c & bit_FMA)) return 2;
    __asm__("xgetbv" : "=a"(low), "=d"(high) : "c"(0));
    if ((low & 0x06) != 0x06 || !__get_cpuid_count(7, 0, &a, &b, &c, &d) || !(b & bit_AVX2)) return 2;
    int wide = (b & bit_AVX512F) && (b & bit_AVX512DQ) && (b & bit_AVX512VL) && (low & 0xe6) == 0xe6;
    return wide ? 8 : 4;
}
#else
static int widest(void) { return 2; }
#endif
#endif
