"""Scalar CasADi functions at many points at once: each operation is carried out for a block of points.

An interpreter of single operations spends most of its time on finding the next one. With sixteen points beside each
other that is shared, and the processor adds several of them at once: a tenth of the time, without compiling the model.
The machine itself is compiled, once for all models. Without a compiler CasADi's own does the work.
"""

from __future__ import annotations

import ctypes as c
from collections.abc import Sequence
from functools import cache

import casadi as ca
import numpy as np

from fowtlib.language.native import Library, compiler, load_library
from fowtlib.solving.engines.c_lanes import OPERATIONS

POINTS = (100, 10, 1)  # at which CasADi's own functions are evaluated in one call
INPUT, OUTPUT, CONSTANT = -1, -2, -3

TEXT = """#include <math.h>
#include <stddef.h>

enum { WIDTH = 16 };
#define EACH _Pragma("GCC ivdep") for (int j = 0; j < WIDTH; j++)
#define EACH_COLUMN _Pragma("GCC ivdep") for (int j = 0; j < columns; j++)

/* A program at points: operation i is code[i], from registers (or what the code says) a[i] and b[i], to out[i]. An
   argument has `stride` numbers for each point; of one that is the same at all points it is 0. work: WIDTH numbers for
   each register. */
EXPORT void columns_run(int points, int count, const int *code, const int *out, const int *first, const int *second,
                        const double *constant, const double *const *argument, const int *stride, int results,
                        double *result, double *work) {
  for (int begin = 0; begin < points; begin += WIDTH) {
    int here = points - begin < WIDTH ? points - begin : WIDTH;
    for (int i = 0; i < count; i++) {
      double *o = work + (size_t)WIDTH * (out[i] < 0 ? 0 : out[i]);
      const double *a = work + (size_t)WIDTH * (first[i] < 0 ? 0 : first[i]);
      const double *b = work + (size_t)WIDTH * (second[i] < 0 ? 0 : second[i]);
      switch (code[i]) {
      case -1: {
        const double *from = argument[first[i]] + second[i];
        int step = stride[first[i]];
        for (int j = 0; j < WIDTH; j++) o[j] = from[(size_t)step * (begin + (j < here ? j : here - 1))];
        break;
      }
      case -2:
        for (int j = 0; j < here; j++) result[(size_t)results * (begin + j) + second[i]] = a[j];
        break;
      case -3:
        for (int j = 0; j < WIDTH; j++) o[j] = constant[i];
        break;
CASES
      }
    }
  }
}

/* Of matrices at points, out += a b: out is (rows, columns), a (rows, inner), b (inner, columns); skip: numbers from
   one point to the next. What is zero in a costs nothing. */
EXPORT void columns_multiply(int points, int rows, int inner, int columns, const double *a, int skip_a, const double *b,
                             int skip_b, double *out, int skip_out) {
  for (size_t p = 0; p < (size_t)points; p++)
    for (int i = 0; i < rows; i++)
      for (int k = 0; k < inner; k++) {
        double factor = a[p * skip_a + (size_t)i * inner + k];
        const double *from = b + p * skip_b + (size_t)k * columns;
        double *to = out + p * skip_out + (size_t)i * columns;
        if (factor == 0.0) continue;
        EACH_COLUMN to[j] += factor * from[j];
      }
}
"""


@cache
def _machine() -> Library:
    cases = "".join(f"      case {code}: EACH o[j] = {text.format('a[j]', 'b[j]')}; break;\n"
                    for code, text in OPERATIONS.items())  # fmt: skip
    _, library = load_library(TEXT.replace("CASES\n", cases), "columns", optimization="-O3")
    pointer, number = c.c_void_p, c.c_int
    library.columns_run.restype = None
    library.columns_run.argtypes = [number, number, *[pointer] * 7, number, *[pointer] * 2]
    library.columns_multiply.restype = None
    library.columns_multiply.argtypes = [*[number] * 4, *[pointer, number] * 3]
    return library


class Program:
    """A scalar (SX) function with one dense column as its result, at many points.

    places: where each result stands in a row of `width` numbers, of which the others are zero.
    """

    def __init__(self, function: ca.Function, places: np.ndarray | None = None, width: int = 0):
        self.function = function
        self.places = np.arange(function.numel_out(0)) if places is None else places
        self.width = function.numel_out(0) if places is None else width
        self.sizes = [function.numel_in(i) for i in range(function.n_in())]
        self._arrays: list[np.ndarray] | None = None

    def __call__(self, arguments: Sequence[np.ndarray]) -> np.ndarray:
        """Rows of results at n points. arguments: rows (n, size), or one column (size,) that is the same for all."""
        n = max((len(value) for value in arguments if value.ndim == 2), default=1)
        if not compiler() or not self._translated():
            rows = np.zeros((n, self.width))
            rows[:, self.places] = mapped(self.function, arguments, n)
            return rows
        values = [np.ascontiguousarray(value, dtype=float) for value in arguments]
        strides = np.array([size if value.ndim == 2 else 0 for value, size in zip(values, self.sizes, strict=True)],
                           dtype=np.intc)  # fmt: skip
        pointers = (c.c_void_p * len(values))(*(value.ctypes.data for value in values))
        found, work = np.zeros((n, self.width)), np.empty(16 * (self.function.sz_w() + 1))
        codes, out, first, second, constants = self._arrays or []
        _machine().columns_run(
            n, len(codes), *(array.ctypes.data for array in (codes, out, first, second, constants)), pointers,
            strides.ctypes.data, self.width, found.ctypes.data, work.ctypes.data,
        )  # fmt: skip
        return found

    def _translated(self) -> bool:
        """Whether the machine knows all operations; its program is made when it is first wanted."""
        if self._arrays is not None:
            return len(self._arrays[0]) > 0 or not len(self.places)
        function, count = self.function, self.function.n_instructions()
        table, constants = np.zeros((4, count), dtype=np.intc), np.zeros(count)
        for k in range(count):
            code, inside, outside = (function.instruction_id(k), function.instruction_input(k),
                                     function.instruction_output(k))  # fmt: skip
            if code == ca.OP_OUTPUT:
                table[:, k] = OUTPUT, -1, inside[0], self.places[outside[1]]
            elif code == ca.OP_INPUT:
                table[:, k] = INPUT, outside[0], inside[0], inside[1]
            elif code == ca.OP_CONST:
                table[:, k] = CONSTANT, outside[0], -1, -1
                constants[k] = function.instruction_constant(k)
            elif code in OPERATIONS:
                table[:, k] = code, outside[0], inside[0], inside[1] if len(inside) > 1 else -1
            else:
                self._arrays = [np.zeros(0, dtype=np.intc)] * 4 + [np.zeros(0)]
                return False
        self._arrays = [*(np.ascontiguousarray(row) for row in table), constants]
        return True


def add_product(out: np.ndarray, a: np.ndarray, b: np.ndarray) -> None:
    """`out += a @ b` of matrices at many points (n, ., .), whose rows lie one behind the other."""
    if not compiler():
        out += a @ b
        return
    n, rows, inner = a.shape
    skips = [value.strides[0] // value.itemsize for value in (a, b, out)]
    _machine().columns_multiply(n, rows, inner, b.shape[2], a.ctypes.data, skips[0], b.ctypes.data, skips[1],
                                out.ctypes.data, skips[2])  # fmt: skip


def mapped(function: ca.Function, arguments: Sequence[np.ndarray], n: int) -> np.ndarray:
    """Rows of the dense result of any CasADi function at n points; arguments as those of a Program."""
    same = [i for i, value in enumerate(arguments) if value.ndim == 1]
    found, first = [], 0
    for size in POINTS:
        if (n - first) // size:
            many = function.map(f"{function.name()}_{size}", "serial", size, same, []) if same else function.map(size)
        for _ in range((n - first) // size):
            part = slice(first, first + size)
            columns = [value if value.ndim == 1 else value[part].T for value in arguments]
            found.append(np.array(many(*columns)).reshape(-1, size, order="F").T)
            first += size
    return np.concatenate(found) if found else np.zeros((0, function.numel_out(0)))
