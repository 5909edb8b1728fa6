"""C text of operations, of numbers and of vectors (see lanes.py).

Vectors are those that gcc and clang have for any processor, in words of as many lanes as a register holds.
"""

from __future__ import annotations

import casadi as ca

from fowtlib.language.processor import lanes_here

OPERATIONS = {
    ca.OP_ASSIGN: "{0}", ca.OP_LIFT: "{0}", ca.OP_ADD: "{0} + {1}", ca.OP_SUB: "{0} - {1}", ca.OP_MUL: "{0} * {1}",
    ca.OP_DIV: "{0} / {1}", ca.OP_NEG: "-{0}", ca.OP_EXP: "exp({0})", ca.OP_LOG: "log({0})",
    ca.OP_POW: "pow({0}, {1})", ca.OP_CONSTPOW: "pow({0}, {1})", ca.OP_SQRT: "sqrt({0})", ca.OP_SQ: "{0} * {0}",
    ca.OP_TWICE: "2.0 * {0}", ca.OP_SIN: "sin({0})", ca.OP_COS: "cos({0})", ca.OP_TAN: "tan({0})",
    ca.OP_ASIN: "asin({0})", ca.OP_ACOS: "acos({0})", ca.OP_ATAN: "atan({0})", ca.OP_LT: "{0} < {1}",
    ca.OP_LE: "{0} <= {1}", ca.OP_EQ: "{0} == {1}", ca.OP_NE: "{0} != {1}", ca.OP_NOT: "!{0}",
    ca.OP_AND: "{0} && {1}", ca.OP_OR: "{0} || {1}", ca.OP_FLOOR: "floor({0})", ca.OP_CEIL: "ceil({0})",
    ca.OP_FMOD: "fmod({0}, {1})", ca.OP_REMAINDER: "remainder({0}, {1})", ca.OP_FABS: "fabs({0})",
    ca.OP_SIGN: "{0} > 0 ? 1 : {0} < 0 ? -1 : {0}", ca.OP_COPYSIGN: "copysign({0}, {1})",
    ca.OP_IF_ELSE_ZERO: "{0} ? {1} : 0", ca.OP_ERF: "erf({0})",
    ca.OP_FMIN: "fmin({0}, {1})", ca.OP_FMAX: "fmax({0}, {1})", ca.OP_INV: "1.0 / {0}",
    ca.OP_SINH: "sinh({0})", ca.OP_COSH: "cosh({0})", ca.OP_TANH: "tanh({0})", ca.OP_ASINH: "asinh({0})",
    ca.OP_ACOSH: "acosh({0})", ca.OP_ATANH: "atanh({0})", ca.OP_ATAN2: "atan2({0}, {1})", ca.OP_LOG1P: "log1p({0})",
    ca.OP_EXPM1: "expm1({0})", ca.OP_HYPOT: "hypot({0}, {1})",
}  # fmt: skip
"""C text of a CasADi operation."""

ANY_PROCESSOR = 2  # lanes of a word that every processor has, or can do without

VECTORS = {
    ca.OP_ADD: "ADD({0}, {1})", ca.OP_SUB: "SUB({0}, {1})", ca.OP_MUL: "MUL({0}, {1})", ca.OP_DIV: "DIV({0}, {1})",
    ca.OP_NEG: "NEG({0})", ca.OP_SQ: "MUL({0}, {0})", ca.OP_TWICE: "ADD({0}, {0})", ca.OP_FMIN: "MIN({0}, {1})",
    ca.OP_FMAX: "MAX({0}, {1})", ca.OP_IF_ELSE_ZERO: "ONLY({0}, {1})", ca.OP_SQRT: "ROOT({0})",
    ca.OP_FABS: "SIZE({0})", ca.OP_LT: "ONE({0}, <, {1})", ca.OP_LE: "ONE({0}, <=, {1})", ca.OP_EQ: "ONE({0}, ==, {1})",
    ca.OP_NE: "ONE({0}, !=, {1})",
}  # fmt: skip
"""The same of vectors, for those that need not be carried out lane by lane."""

_WIDE = """#if defined(__clang__)
#pragma clang attribute push(__attribute__((target("avx2"))), apply_to = function)
#else
#pragma GCC target("avx2")
#endif
#define LEAVE __builtin_ia32_vzeroupper(); /* gcc leaves it out at -O1, and what follows would be slow without */
"""
_NARROW = "#ifdef __clang__\n#pragma clang attribute pop\n#endif\n"
_PROLOGUE = """#include <math.h>
#ifndef LEAVE
#define LEAVE
#endif
#ifdef __GNUC__
#define FS_PIECE __attribute__((noinline))
typedef double W __attribute__((vector_size(BYTES), aligned(8), may_alias));
typedef long long M __attribute__((vector_size(BYTES), aligned(8), may_alias));
#define WORD(...) ((W){__VA_ARGS__})
#define LANE(v, k) ((v)[k])
#define LOAD(p) (*(const W *)(p))
#define KEEP(p, v) (*(W *)(p) = (v))
#define ADD(v, u) ((v) + (u))
#define SUB(v, u) ((v) - (u))
#define MUL(v, u) ((v) * (u))
#define DIV(v, u) ((v) / (u))
#define NEG(v) (-(v))
#define CHOICE(m, v, u) ((W)(((M)(v) & (m)) | ((M)(u) & ~(m))))
#define MIN(v, u) CHOICE((M)((v) < (u)) | (M)((u) != (u)), v, u)
#define MAX(v, u) CHOICE((M)((v) > (u)) | (M)((u) != (u)), v, u)
#define ONLY(c, v) ((W)((M)(v) & (M)((c) != (W){0.0})))
#define ONE(v, relation, u) ((W)((M)((v) relation (u)) & (M)(1.0 - (W){0.0})))
#define SIZE(v) ((W)((M)(v) & 0x7fffffffffffffffLL))
#if BYTES == 32
static inline W ROOT(W v) { W r; __asm__("vsqrtpd %1, %0" : "=x"(r) : "x"(v)); return r; }
#elif defined(__x86_64__)
static inline W ROOT(W v) { W r; __asm__("sqrtpd %1, %0" : "=x"(r) : "x"(v)); return r; }
#else
#define ROOT(v) WORD(sqrt((v)[0]), sqrt((v)[1]))
#endif
/* as those of the C library, without a call, behind which nothing is left in registers */
static inline double fs_least(double v, double u) { double m = v < u ? v : u; return u != u ? v : m; }
static inline double fs_greatest(double v, double u) { double m = v > u ? v : u; return u != u ? v : m; }
#define fmin fs_least
#define fmax fs_greatest
#else /* two numbers in the place of a vector */
#define FS_PIECE
typedef struct { double a, b; } W;
#define WORD(p, q) ((W){p, q})
#define LANE(v, k) ((k) ? (v).b : (v).a)
#define LOAD(p) ((W){(p)[0], (p)[1]})
#define KEEP(p, v) ((p)[0] = (v).a, (p)[1] = (v).b)
#define ADD(v, u) ((W){(v).a + (u).a, (v).b + (u).b})
#define SUB(v, u) ((W){(v).a - (u).a, (v).b - (u).b})
#define MUL(v, u) ((W){(v).a * (u).a, (v).b * (u).b})
#define DIV(v, u) ((W){(v).a / (u).a, (v).b / (u).b})
#define NEG(v) ((W){-(v).a, -(v).b})
#define MIN(v, u) ((W){fmin((v).a, (u).a), fmin((v).b, (u).b)})
#define MAX(v, u) ((W){fmax((v).a, (u).a), fmax((v).b, (u).b)})
#define ONLY(c, v) ((W){(c).a != 0.0 ? (v).a : 0.0, (c).b != 0.0 ? (v).b : 0.0})
#define ONE(v, relation, u) ((W){(v).a relation (u).a, (v).b relation (u).b})
#define SIZE(v) ((W){fabs((v).a), fabs((v).b)})
#define ROOT(v) ((W){sqrt((v).a), sqrt((v).b)})
#endif
"""


def prologue(word: int) -> str:
    """In front of the text of `c_program` with vectors of so many lanes: 2 for every processor, 4 for those with AVX2.

    Without the vectors of gcc and clang there are two numbers in their place.
    """
    return wide(word) + _PROLOGUE.replace("BYTES", str(8 * word))


def wide(word: int) -> str:
    """In front of a text: vectors of so many lanes, and no fused multiply-add, which would round less."""
    return _WIDE if word > ANY_PROCESSOR else ""


def narrow(word: int) -> str:
    """Behind a text with `wide` or `prologue` in front."""
    return _NARROW if word > ANY_PROCESSOR else ""


def for_this_processor() -> str:
    """In front of C text with loops that the compiler may carry out in the vectors of this processor, and of no other."""
    return _WIDE if word_here() > ANY_PROCESSOR else ""


def word_here() -> int:
    """Lanes of a word of this processor."""
    return 4 if lanes_here() >= 4 else ANY_PROCESSOR
