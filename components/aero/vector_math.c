/* Vectors of LANES numbers and their mathematics. vectors.py repeats this text for each width that a processor may have,
 * with LANE(name) for what belongs to one of them.
 *
 * Written in the vector types of gcc and clang, which are the same on all processors; what they have no words for stands
 * first. The polynomials go through the functions at Chebyshev's points, computed with 60 digits. Largest errors, which
 * tests/aero/test_vector_math.py checks, in units of 2^-53 of the value: sine 2.5, exponential 1.5, arc sine 1.5, angle 2;
 * cosine 2.5 of 2^-53. No number in, no number out; a lane never changes another one. */

typedef double LANE(numbers) __attribute__((vector_size(8 * LANES)));
typedef long long LANE(mask) __attribute__((vector_size(8 * LANES))); /* of a lane all bits, or none */
typedef double LANE(anywhere) __attribute__((vector_size(8 * LANES), aligned(8), may_alias));
#define V LANE(numbers)
#define M LANE(mask)

/* LANES numbers, one in every `stride` of those at p */
#if LANES == 8
#define STRIDED(p, n) (V){(p)[0], (p)[n], (p)[2 * (n)], (p)[3 * (n)], (p)[4 * (n)], (p)[5 * (n)], (p)[6 * (n)], (p)[7 * (n)]}
#elif LANES == 4
#define STRIDED(p, n) (V){(p)[0], (p)[n], (p)[2 * (n)], (p)[3 * (n)]}
#else
#define STRIDED(p, n) (V){(p)[0], (p)[n]}
#endif

INLINE V LANE(load)(const double *p) { return *(const LANE(anywhere) *)p; }
INLINE void LANE(store)(double *p, V x) { *(LANE(anywhere) *)p = x; }
INLINE V LANE(all)(double x) { return x - (V){0}; }

/* Bit l of the result says whether lane l is on. */
INLINE int LANE(bits)(M m) {
#if LANES == 8
    return (unsigned char)__builtin_ia32_cvtq2mask512(m);
#elif LANES == 4
    return __builtin_ia32_movmskpd256((V)m);
#elif defined(__x86_64__)
    return __builtin_ia32_movmskpd((V)m);
#else
    return (m[0] != 0) | (m[1] != 0) << 1;
#endif
}

INLINE V LANE(root)(V x) {
    V r;
#if LANES > 2
    __asm__("vsqrtpd %1, %0" : "=v"(r) : "v"(x));
#elif defined(__x86_64__)
    __asm__("sqrtpd %1, %0" : "=x"(r) : "x"(x));
#else
    __asm__("fsqrt %0.2d, %1.2d" : "=w"(r) : "w"(x));
#endif
    return r;
}

INLINE V LANE(choose)(M m, V a, V b) { return (V)((m & (M)a) | (~m & (M)b)); }
INLINE V LANE(size)(V x) { return (V)((M)x & 0x7fffffffffffffffLL); }
INLINE V LANE(least)(V a, V b) { return LANE(choose)(a < b, a, b); }

/* The other way round: a[k] has the number k of all rows after it. */
INLINE void LANE(transpose)(V *a) {
#ifdef __clang__
#define SHUFFLE __builtin_shufflevector
#else
#define SHUFFLE(a, b, ...) __builtin_shuffle(a, b, (M){__VA_ARGS__})
#endif
#if LANES == 8
    V b[8];
    EACH for (int k = 0; k < 8; k += 2) {
        b[k] = SHUFFLE(a[k], a[k + 1], 0, 8, 2, 10, 4, 12, 6, 14);
        b[k + 1] = SHUFFLE(a[k], a[k + 1], 1, 9, 3, 11, 5, 13, 7, 15);
    }
    EACH for (int k = 0; k < 4; k++) {
        int from = k < 2 ? k : k + 2; /* 0, 1, 4, 5 */
        a[from] = SHUFFLE(b[from], b[from + 2], 0, 1, 8, 9, 4, 5, 12, 13);
        a[from + 2] = SHUFFLE(b[from], b[from + 2], 2, 3, 10, 11, 6, 7, 14, 15);
    }
    EACH for (int k = 0; k < 4; k++) {
        V low = a[k], high = a[k + 4];
        a[k] = SHUFFLE(low, high, 0, 1, 2, 3, 8, 9, 10, 11), a[k + 4] = SHUFFLE(low, high, 4, 5, 6, 7, 12, 13, 14, 15);
    }
#elif LANES == 4
    V b[4] = {SHUFFLE(a[0], a[1], 0, 4, 2, 6), SHUFFLE(a[0], a[1], 1, 5, 3, 7),
              SHUFFLE(a[2], a[3], 0, 4, 2, 6), SHUFFLE(a[2], a[3], 1, 5, 3, 7)};
    a[0] = SHUFFLE(b[0], b[2], 0, 1, 4, 5), a[1] = SHUFFLE(b[1], b[3], 0, 1, 4, 5);
    a[2] = SHUFFLE(b[0], b[2], 2, 3, 6, 7), a[3] = SHUFFLE(b[1], b[3], 2, 3, 6, 7);
#else
    V low = a[0], high = a[1];
    a[0] = SHUFFLE(low, high, 0, 2), a[1] = SHUFFLE(low, high, 1, 3);
#endif
#undef SHUFFLE
}

/* Sine and cosine of an angle between 0 and pi/2, by those of its half. */
INLINE void LANE(sine_cosine)(V x, V *sine, V *cosine) {
    V y = 0.5 * x, q = y * y, q2 = q * q, q4 = q2 * q2;
    V p = (-0.16666666666666666 + 0.008333333333330948 * q) + q2 * (-0.00019841269836756774 + 2.7557316101617874e-06 * q)
          + q4 * (-2.505113165023518e-08 + 1.5918115263265974e-10 * q);
    V r = (0.041666666666666664 - 0.0013888888888887398 * q) + q2 * (2.480158729876456e-05 - 2.7557317271145144e-07 * q)
          + q4 * (2.087614614655861e-09 - 1.1382623647474604e-11 * q);
    V s = y + y * q * p, c = (1 - 0.5 * q) + q2 * r;
    *sine = 2 * s * c, *cosine = 1 - 2 * s * s;
}

/* exp(-x) of x from 0 on; beyond 700 that of 700. */
INLINE V LANE(decay)(V x) {
    const double shift = 6755399441055744.0; /* 3 * 2^51: what is added to it becomes a whole number in its last bits */
    x = LANE(least)(x, LANE(all)(700));
    V moved = x * -1.4426950408889634 + shift, n = moved - shift;
    V r = (-x - n * 0.6931471803691238) - n * 1.9082149292705877e-10, r2 = r * r, r4 = r2 * r2;
    V low = (0.5000000000000001 + 0.16666666666666669 * r) + r2 * (0.04166666666662413 + 0.008333333333330062 * r);
    V high = (0.0013888888917213717 + 0.00019841269863053618 * r) + r2 * (2.4801521295954376e-05 + 2.7557268459997064e-06 * r)
             + r4 * (2.7620088445409746e-07 + 2.510038549551032e-08 * r);
    V e = 1 + (r + r2 * (low + r4 * high));
    return (V)((M)e + ((M)moved << 52));
}

/* (asin(y) - y) / y^3 of y * y = q between 0 and 1/4 */
INLINE V LANE(arc_sine_rest)(V q) {
    V q2 = q * q, q4 = q2 * q2, q8 = q4 * q4;
    V a = (0.16666666666666669 + 0.07499999999998433 * q) + q2 * (0.04464285714635543 + 0.030381944138531247 * q);
    V b = (0.02237217294214989 + 0.017352392720869973 * q) + q2 * (0.013971212973552933 + 0.011479177415184906 * q);
    V c = (0.01032281435018578 + 0.005457506718640358 * q) + q2 * (0.01740087944269402 - 0.014851887071247204 * q);
    return a + q4 * b + q8 * (c + q4 * 0.028757851367421566);
}

/* The angle of the point (x, y), as atan2. */
INLINE V LANE(angle)(V y, V x) {
    V up = LANE(size)(y), along = LANE(size)(x);
    M steep = up > along;
    V low = LANE(choose)(steep, along, up), high = LANE(choose)(steep, up, along);
    M middle = low > 0.41421356237309503 * high;
    V over = LANE(choose)(middle, low - high, low), under = LANE(choose)(middle, low + high, high);
    V t = over / LANE(choose)(under > 0, under, 1 + under), q = t * t, q2 = q * q, q4 = q2 * q2;
    V p = (-0.3333333333333333 + 0.19999999999995516 * q) + q2 * (-0.14285714284665682 + 0.11111111015187018 * q)
          + q4 * ((-0.0909090457530649 + 0.07692183125376892 * q) + q2 * (-0.06664510525508936 + 0.05858140904866328 * q)
                  + q4 * ((-0.050854078345894844 + 0.03923044778479309 * q) - q2 * 0.019175404711104935));
    V a = LANE(choose)(middle, LANE(all)(pi / 4), (V){0}) + (t + t * q * p);
    a = LANE(choose)(steep, pi / 2 - a, a);
    a = LANE(choose)(x < 0, pi - a, a);
    return LANE(choose)(y < 0, -a, a);
}
