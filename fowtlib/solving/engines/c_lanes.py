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

ANY_PROCESSOR, WIDE = 2, 4  # lanes of a word that every processor has, or can do without; of one with AVX2

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
#define WIDE 1
#define LEAVE __builtin_ia32_vzeroupper(); /* gcc leaves it out at -O1, and what follows would be slow without */
"""
_WIDE_END = """#if defined(__clang__)
#pragma clang attribute pop
#endif
"""
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
#if defined(WIDE) && BYTES == 32
static inline W ROOT(W v) { W r; __asm__("vsqrtpd %1, %0" : "=x"(r) : "x"(v)); return r; }
#elif defined(__x86_64__) && BYTES == 16
static inline W ROOT(W v) { W r; __asm__("sqrtpd %1, %0" : "=x"(r) : "x"(v)); return r; }
#else
#define ROOT(v) WORD(ROOTS)
#endif
/* as those of the C library, without a call, behind which nothing is left in registers */
static inline double fs_least(double v, double u) { double m = v < u ? v : u; return u != u ? v : m; }
static inline double fs_greatest(double v, double u) { double m = v > u ? v : u; return u != u ? v : m; }
#define fmin fs_least
#define fmax fs_greatest
#else /* numbers in the place of a vector */
#define FS_PIECE
NUMBERS
#endif
"""
# The same without the vectors of gcc and clang, lane by lane: N stands for the number of a lane.
_LANES = {
    "ADD(v, u)": "(v).vN + (u).vN", "SUB(v, u)": "(v).vN - (u).vN", "MUL(v, u)": "(v).vN * (u).vN",
    "DIV(v, u)": "(v).vN / (u).vN", "NEG(v)": "-(v).vN", "MIN(v, u)": "fmin((v).vN, (u).vN)",
    "MAX(v, u)": "fmax((v).vN, (u).vN)", "ONLY(c, v)": "(c).vN != 0.0 ? (v).vN : 0.0", "LOAD(p)": "(p)[N]",
    "ONE(v, relation, u)": "(v).vN relation (u).vN", "SIZE(v)": "fabs((v).vN)", "ROOT(v)": "sqrt((v).vN)",
}  # fmt: skip


def _numbers(word: int) -> str:
    """C text of the operations without vectors."""
    lanes = [str(k) for k in range(word)]
    lane = "".join(f"(k) == {k} ? (v).v{k} : " for k in lanes[:-1]) + f"(v).v{lanes[-1]}"
    keep = ", ".join(f"(p)[{k}] = (v).v{k}" for k in lanes)
    return "\n".join([
        f"typedef struct {{ double {', '.join(f'v{k}' for k in lanes)}; }} W;",
        "#define WORD(...) ((W){__VA_ARGS__})", f"#define LANE(v, k) ({lane})", f"#define KEEP(p, v) ({keep})",
        *(f"#define {name} ((W){{{', '.join(form.replace('N', k) for k in lanes)}}})" for name, form in _LANES.items()),
    ])  # fmt: skip


def prologue(word: int) -> str:
    """In front of the text of `c_program` with vectors of so many lanes.

    Without the vectors of gcc and clang there are as many numbers in their place, and where those of the processor are
    narrower the compiler takes several.
    """
    roots = ", ".join(f"sqrt(LANE(v, {k}))" for k in range(word))
    return _PROLOGUE.replace("BYTES", str(8 * word)).replace("NUMBERS", _numbers(word)).replace("ROOTS", roots)


def in_wide_vectors(text: str) -> str:
    """C text for processors with AVX2 alone, without fused multiply-add, which would round less."""
    return f"{_WIDE}{text}{_WIDE_END}"


def for_this_processor(text: str) -> str:
    """C text that the compiler may carry out in the vectors of this processor, and of no narrower one."""
    return in_wide_vectors(text) if word_here() > ANY_PROCESSOR else text


def word_here() -> int:
    """Lanes of a word of this processor."""
    return WIDE if lanes_here() >= WIDE else ANY_PROCESSOR
