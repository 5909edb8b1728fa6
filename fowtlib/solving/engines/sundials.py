"""The functions of SUNDIALS IDA that come with CasADi, and where its memory has the function of its linear solver.

Any program may give IDA a linear solver of its own; the words for it are fields of its memory, whose layout CasADi's
wheel does not tell. So they are found: its Krylov solver, when it is attached, writes five functions of the library one
after the other, to begin, set up, solve, look after and free, and a pointer to its own memory behind them.
"""

from __future__ import annotations

import ctypes as c
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import casadi as ca

# in the order of ida_calls in ida.c
CALLS = (
    "IDACreate", "IDAFree", "IDASetErrHandlerFn", "IDASetUserData", "IDAInit", "IDAReInit", "IDASStolerances",
    "IDASetId", "IDASetSuppressAlg", "IDASetMaxNumSteps", "IDASetStopTime", "IDASpgmr", "IDASpilsSetPreconditioner",
    "IDACalcIC", "IDASolve", "IDAGetCurrentOrder", "IDAGetCurrentStep", "IDAGetIntegratorStats", "N_VNew_Serial",
    "N_VDestroy_Serial", "N_VGetArrayPointer",
)  # fmt: skip
SOLVER, SOLVE = 5, 2  # functions of a linear solver, and which of them solves


@dataclass(frozen=True)
class Sundials:
    """Addresses of CALLS, and the number of the word with the function that solves, and that of the Krylov solver."""

    library: c.CDLL
    calls: tuple[int, ...]
    place: int
    krylov: int


class _Symbol(c.Structure):
    """Dl_info of the dynamic loader."""

    _fields_ = [("file", c.c_char_p), ("base", c.c_void_p), ("name", c.c_char_p), ("address", c.c_void_p)]


@cache
def sundials() -> Sundials | None:
    """IDA as it comes with CasADi; None where it is another one than that of SUNDIALS 2, or cannot be looked into."""
    for path in sorted(Path(ca.__file__).parent.glob("libcasadi_integrator_idas.*")):
        try:
            library = c.CDLL(str(path))
            calls = tuple(c.cast(getattr(library, name), c.c_void_p).value or 0 for name in CALLS)
            found = _solve_place(library, c.CDLL(None))
        except (OSError, AttributeError, TypeError):  # TypeError: a platform whose C library has no name
            continue
        if found:
            return Sundials(library, calls, *found)
    return None


def _solve_place(library: c.CDLL, system: c.CDLL) -> tuple[int, int] | None:
    """By what attaching the Krylov solver changes in IDA's memory."""
    size_of = getattr(system, "malloc_usable_size", None) or system.malloc_size
    size_of.argtypes, size_of.restype = [c.c_void_p], c.c_size_t
    system.dladdr.argtypes = [c.c_void_p, c.POINTER(_Symbol)]
    residual = c.CFUNCTYPE(c.c_int, c.c_double, *4 * [c.c_void_p])(lambda *arguments: 0)
    library.IDACreate.restype = library.N_VNew_Serial.restype = c.c_void_p
    memory, vector = c.c_void_p(library.IDACreate()), c.c_void_p(library.N_VNew_Serial(c.c_long(1)))
    try:
        if not memory or not vector or library.IDAInit(memory, residual, c.c_double(0.0), vector, vector):
            return None
        count = size_of(memory) // c.sizeof(c.c_void_p)
        words = (c.c_size_t * count).from_address(memory.value or 0)
        before = list(words)
        if library.IDASpgmr(memory, c.c_int(0)):
            return None
        changed = [i for i in range(count) if words[i] != before[i]]
        first = changed[0] if changed else 0
        if changed != list(range(first, first + SOLVER + 1)) or any(before[i] for i in changed):
            return None
        here = c.cast(library.IDASpgmr, c.c_void_p).value
        inside = [_base(system, words[i]) == _base(system, here) for i in changed]
        return (first + SOLVE, words[first + SOLVE]) if inside == SOLVER * [True] + [False] else None
    finally:
        library.IDAFree(c.byref(memory))
        library.N_VDestroy_Serial(vector)


def _base(system: c.CDLL, address: int | None) -> int | None:
    """Where the library of an address begins."""
    symbol = _Symbol()
    return symbol.base if system.dladdr(address, c.byref(symbol)) else None
