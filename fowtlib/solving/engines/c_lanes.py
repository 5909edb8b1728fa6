"""C text of operations, of numbers and of vectors with four lanes (see lanes.py)."""

from __future__ import annotations

from functools import cache

import casadi as ca

from fowtlib.language.native import load_library

OPERATIONS = {
    ca.OP_ASSIGN: "{0}", ca.OP_LIFT: "{0}", ca.OP_ADD: "{0} + {1}", ca.OP_SUB: "{0} - {1}", ca.OP_MUL: "{0} * {1}",
    ca.OP_DIV: "{0} / {1}", ca.OP_NEG: "-{0}", ca.OP_EXP: "exp({0})", ca.OP_LOG: "log({0})",
    ca.OP_POW: "pow({0}, {1})", ca.OP_CONSTPOW: "pow({0}, {1})", ca.OP_SQRT: "sqrt({0})", ca.OP_SQ: "{0} * {0}",
    ca.OP_TWICE: "2.0 * {0}", ca.OP_SIN: "sin({0})", ca.OP_COS: "cos({0})", ca.OP_TAN: "tan({0})",
    ca.OP_ASIN: "asin({0})", ca.OP_ACOS: "acos({0})", ca.OP_ATAN: "atan({0})", ca.OP_LT: "{0} < {1}",
    ca.OP_LE: "{0} <= {1}", ca.OP_EQ: "{0} == {1}", ca.OP_NE: "{0} != {1}", ca.OP_NOT: "!{0}",
    ca.OP_AND: "{0} && {1}", ca.OP_OR: "{0} || {1}", ca.OP_FLOOR: "floor({0})", ca.OP_CEIL: "ceil({0})",
    ca.OP_FMOD: "fmod({0}, {1})", ca.OP_REMAINDER: "remainder({0}, {1})", ca.OP_FABS: "fabs({0})",
    ca.OP_SIGN: "({0} > 0) - ({0} < 0)", ca.OP_COPYSIGN: "copysign({0}, {1})", ca.OP_IF_ELSE_ZERO: "{0} ? {1} : 0",
    ca.OP_ERF: "erf({0})", ca.OP_FMIN: "fmin({0}, {1})", ca.OP_FMAX: "fmax({0}, {1})", ca.OP_INV: "1.0 / {0}",
    ca.OP_SINH: "sinh({0})", ca.OP_COSH: "cosh({0})", ca.OP_TANH: "tanh({0})", ca.OP_ASINH: "asinh({0})",
    ca.OP_ACOSH: "acosh({0})", ca.OP_ATANH: "atanh({0})", ca.OP_ATAN2: "atan2({0}, {1})", ca.OP_LOG1P: "log1p({0})",
    ca.OP_EXPM1: "expm1({0})", ca.OP_HYPOT: "hypot({0}, {1})",
}  # fmt: skip
"""C text of a CasADi operation."""

VECTORS = {
    ca.OP_ADD: "ADD({0}, {1})", ca.OP_SUB: "SUB({0}, {1})", ca.OP_MUL: "MUL({0}, {1})", ca.OP_DIV: "DIV({0}, {1})",
    ca.OP_NEG: "NEG({0})", ca.OP_SQ: "MUL({0}, {0})", ca.OP_TWICE: "ADD({0}, {0})", ca.OP_FMIN: "MIN({0}, {1})",
    ca.OP_FMAX: "MAX({0}, {1})", ca.OP_IF_ELSE_ZERO: "ONLY({0}, {1})",
}  # fmt: skip
"""The same of vectors, for those that need not be carried out lane by lane."""

PROLOGUE = """#include <math.h>
#if defined(__GNUC__)
#define FS_PIECE __attribute__((noinline))
#if defined(FS_WIDE)
#define FS_BYTES 32
#else
#define FS_BYTES 16
#endif
typedef double W __attribute__((vector_size(FS_BYTES), aligned(8), may_alias));
typedef long long M __attribute__((vector_size(FS_BYTES), aligned(8), may_alias));
#define CHOICE(m, a, b) ((W)(((M)(a) & (m)) | ((M)(b) & ~(m))))
#define MIN1(a, b) CHOICE((M)((a) < (b)) | (M)((b) != (b)), a, b)
#define MAX1(a, b) CHOICE((M)((a) > (b)) | (M)((b) != (b)), a, b)
#define ONLY1(c, a) ((W)((M)(a) & (M)((c) != (W){0.0})))
#else
#define FS_PIECE
typedef double W;
#define MIN1(a, b) ((a) < (b) || (b) != (b) ? (a) : (b))
#define MAX1(a, b) ((a) > (b) || (b) != (b) ? (a) : (b))
#define ONLY1(c, a) ((c) != 0.0 ? (a) : 0.0)
#endif
#define ADD1(a, b) ((a) + (b))
#define SUB1(a, b) ((a) - (b))
#define MUL1(a, b) ((a) * (b))
#define DIV1(a, b) ((a) / (b))
#define NEG1(a) (-(a))
#if defined(FS_WIDE)
typedef W V;
#define FOUR(a, b, c, d) ((V){a, b, c, d})
#define LANE(v, k) ((v)[k])
#define LOAD(p) (*(const V *)(p))
#define KEEP(p, v) (*(V *)(p) = (v))
#define EACH(f, v) f(v)
#define EACH2(f, v, u) f(v, u)
#elif defined(__GNUC__)
typedef struct { W a, b; } V;
#define FOUR(p, q, r, s) ((V){{p, q}, {r, s}})
#define LANE(v, k) ((k) < 2 ? (v).a[(k) & 1] : (v).b[(k) & 1])
#define LOAD(p) ((V){*(const W *)(p), *(const W *)((p) + 2)})
#define KEEP(p, v) (*(W *)(p) = (v).a, *(W *)((p) + 2) = (v).b)
#define EACH(f, v) ((V){f((v).a), f((v).b)})
#define EACH2(f, v, u) ((V){f((v).a, (u).a), f((v).b, (u).b)})
#else
typedef struct { W a, b, c, d; } V;
#define FOUR(p, q, r, s) ((V){p, q, r, s})
#define LANE(v, k) ((k) < 2 ? (k) == 0 ? (v).a : (v).b : (k) == 2 ? (v).c : (v).d)
#define LOAD(p) FOUR((p)[0], (p)[1], (p)[2], (p)[3])
#define KEEP(p, v) ((p)[0] = (v).a, (p)[1] = (v).b, (p)[2] = (v).c, (p)[3] = (v).d)
#define EACH(f, v) FOUR(f((v).a), f((v).b), f((v).c), f((v).d))
#define EACH2(f, v, u) FOUR(f((v).a, (u).a), f((v).b, (u).b), f((v).c, (u).c), f((v).d, (u).d))
#endif
#define ALL(a) FOUR(a, a, a, a)
#ifndef FS_LEAVE
#define FS_LEAVE
#endif
#define ADD(v, u) EACH2(ADD1, v, u)
#define SUB(v, u) EACH2(SUB1, v, u)
#define MUL(v, u) EACH2(MUL1, v, u)
#define DIV(v, u) EACH2(DIV1, v, u)
#define NEG(v) EACH(NEG1, v)
#define MIN(v, u) EACH2(MIN1, v, u)
#define MAX(v, u) EACH2(MAX1, v, u)
#define ONLY(v, u) EACH2(ONLY1, v, u)
"""
"""In front of the text of `c_program`: vectors of four lanes in what a processor has, or one by one without."""

WIDE = """#if defined(__x86_64__) && defined(__clang__)
#pragma clang attribute push(__attribute__((target("avx2"))), apply_to = function)
#define FS_WIDE
#elif defined(__x86_64__) && defined(__GNUC__)
#pragma GCC target("avx2")
#define FS_WIDE
#define FS_LEAVE __builtin_ia32_vzeroupper(); /* gcc leaves it out at -O1, and what follows would be slow without */
#endif
"""
PROBE = """#if defined(__x86_64__) && defined(__GNUC__)
#include <cpuid.h>
EXPORT int wide(void) {
  unsigned a, b, c, d, low, high;
  if (!__get_cpuid(1, &a, &b, &c, &d) || (~c & (bit_OSXSAVE | bit_AVX))) return 0;
  __asm__("xgetbv" : "=a"(low), "=d"(high) : "c"(0)); /* does the system keep these registers? */
  return (low & 6) == 6 && __get_cpuid_count(7, 0, &a, &b, &c, &d) && (b & bit_AVX2);
}
#else
EXPORT int wide(void) { return 0; }
#endif
"""


@cache
def for_this_processor() -> str:
    """What stands in front of PROLOGUE for vectors of 32 bytes, where this processor has them; else nothing.

    Without it the code runs on any processor of its kind, as that of an FMU has to.
    """
    _, library = load_library(PROBE, "processor")
    return WIDE if library.wide() else ""
