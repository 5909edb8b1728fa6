"""External functions: computations outside of the equations, with declared inputs, outputs and Jacobian."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import cached_property, partial
from pathlib import Path
from typing import Any
from weakref import WeakSet, WeakValueDictionary

import casadi as ca
import numpy as np

from fowtlib.language.equations import external
from fowtlib.language.errors import ParameterError, SimulationError, StructureError, did_you_mean
from fowtlib.language.native import Library, begin_library, compiler, load_library, no_compiler, open_library, say_once
from fowtlib.language.to_come import ToCome

_INTERFACE = Path(__file__).parent / "casadi_interface.c"
Compute = Callable[[np.ndarray], Any]

_functions: WeakValueDictionary[tuple[str, Path | None], LibraryFunction | _Python] = WeakValueDictionary()
_kept_points: WeakSet[_Last] = WeakSet()


def with_interface(name: str, sparsity: ca.Sparsity, text: str) -> str:
    """C text for the `source` of an ExternalFunction: what computes, with CasADi's C interface in front of it.

    text defines `EXPORT int FUNCTION()(arg, res, iw, w, mem)` and `EXPORT int JACOBIAN()(...)`, both as CasADi calls
    them, which need no scratch memory; `FUNCTION(_more)` names what else it exports, INPUTS and OUTPUTS are the lengths
    of the columns. sparsity: of the Jacobian, whose entries JACOBIAN() writes in its order, by columns.
    """
    outputs, inputs = sparsity.shape
    numbers = [str(number) for number in (outputs, inputs, *sparsity.colind(), *sparsity.row())]
    rows = "\n".join(", ".join(numbers[i : i + 24]) + "," for i in range(0, len(numbers), 24))
    macros = f"#define NAME {name}\n#define INPUTS {inputs}\n#define OUTPUTS {outputs}\n"
    pattern = f"typedef long long int casadi_int;\nstatic const casadi_int pattern[] = {{\n{rows}\n}};\n"
    return macros + pattern + _INTERFACE.read_text(encoding="utf-8") + text


class ExternalFunction:
    """A function outside of the equations; the flat model calls it as a whole and is torn there.

    inputs and outputs: names and lengths, such as {"velocity": 3, "pitch": 1}; both are passed as one column in that
    order. Give one implementation, or source with python beside it:
    - library: path of a shared library with CasADi's C interface for `name` (one input, one output) and, as
      `jac_<name>`, its Jacobian, which may be sparse;
    - source: C text of such a library, compiled once (see native.py and with_interface); what it exports stands
      behind EXPORT. here: gives text to put in front of it where it is compiled for this machine alone, as what its
      processor can do; an FMU has the source without. beside: it is compiled beside what is done until it is called;
    - python: function of the input column (NumPy) that returns the output column, with jacobian: a function that
      returns d outputs / d inputs, (n_out, n_in), of which only the entries of `sparsity` (a CasADi Sparsity) are
      taken when that is given. Without a jacobian it is taken by finite differences. Beside a source it is what runs
      where there is no compiler, slowly, which is said once.

    explain: gives, once, the reason for which the library refused its last call (returned other than 0) or python
    raised, as a sentence for the user; "" when there is none. It is asked before every calculation with a plant, too.
    `library` is the path of the shared library in use, None where it runs as Python.

    Called in equations() with its inputs by name, it gives its outputs by name: `loads(velocity=v, pitch=b)["force"]`.
    """

    def __init__(
        self,
        name: str,
        inputs: Mapping[str, int],
        outputs: Mapping[str, int],
        *,
        library: str | Path | None = None,
        source: str | None = None,
        here: Callable[[], str] | None = None,
        beside: bool = False,
        python: Compute | None = None,
        jacobian: Compute | None = None,
        sparsity: ca.Sparsity | None = None,
        explain: Callable[[], str] | None = None,
    ):
        if (library is not None) + (source is not None or python is not None) != 1:
            raise ParameterError(f"external function {name}: give either library or python, or source.")
        self.name = name
        self.inputs, self.outputs = dict(inputs), dict(outputs)
        self.sizes = (sum(self.inputs.values()), sum(self.outputs.values()))
        self._explain = explain or str  # str() is empty
        if source is not None and (compiler() or python is None):
            text = here() + source if here else source
            self._made = partial(self._compiled, text, source)
            if beside:
                begin_library(text, name)
                return
        elif library is not None:
            self._made = partial(_from_library, name, Path(library), None)
        else:
            if source is not None:
                say_once(f"external functions run as Python code, slowly: {no_compiler()}")
            self._made = partial(_Python, name, self.sizes, python, jacobian, sparsity, source is not None)
        _ = self.function  # what is wrong is said now

    def _compiled(self, text: str, source: str) -> LibraryFunction:
        library, self._opened = load_library(text, self.name)  # held, so that it stays the one that was checked
        return _from_library(self.name, library, source)

    @cached_property
    def function(self) -> LibraryFunction | _Python:
        """The function as CasADi calls it; one that is compiled beside is waited for."""
        function = self._made()
        function.explain = self._explain
        given = (function.numel_in(0), function.numel_out(0))
        if given != self.sizes:
            raise ParameterError(
                f"external function {self.name}: {given[0]} inputs and {given[1]} outputs in its library, "
                f"{self.sizes[0]} and {self.sizes[1]} declared."
            )
        _functions[self.name, function.path if isinstance(function, LibraryFunction) else None] = function
        return function

    def __deepcopy__(self, memo: Any) -> ExternalFunction:
        return self  # it has no state of its own

    @property
    def library(self) -> Path | None:
        """The shared library of the function; None where it is Python."""
        return self.function.path if isinstance(self.function, LibraryFunction) else None

    def __call__(self, **values: Any) -> dict[str, ca.SX]:
        for key in values:
            if key not in self.inputs:
                raise StructureError(
                    f"external function {self.name} has no input '{key}'{did_you_mean(key, self.inputs)}"
                )
        columns = []
        for key, size in self.inputs.items():
            if key not in values:
                raise StructureError(f"external function {self.name} needs its input '{key}'.")
            column = ca.vec(ca.densify(ca.SX(values[key])))
            if column.shape[0] != size:
                raise StructureError(
                    f"external function {self.name}: input '{key}' has {column.shape[0]} elements, {size} declared."
                )
            columns.append(column)
        made = self.function if "function" in vars(self) else ToCome(self.name, *self.sizes, lambda: self.function)
        result = external(made, ca.vertcat(*columns))
        ends = np.cumsum([0, *self.outputs.values()]).tolist()
        return dict(zip(self.outputs, ca.vertsplit(ca.vec(result), ends), strict=True))


def runs_as_python(function: ca.Function) -> bool:
    """Whether Python code stands in for the C code of an external function, for want of a compiler."""
    return getattr(function, "stands_in", False)


def says_why(function: ca.Function) -> bool:
    """Whether an external function has words of its own for where it has no value."""
    return isinstance(function, _Python) or getattr(function, "explain", str) is not str


class LibraryFunction(ca.Function):
    """A function of a shared library that holds it and knows its path, for engines that call the library themselves.

    source: its C text, where it was compiled from that; else the text may lie beside the library.
    """

    def __init__(self, function: ca.Function, path: Path, opened: Library, source: str | None = None):
        super().__init__(function)
        self.path, self.opened, self.source = path, opened, source

    def __deepcopy__(self, memo: Any) -> LibraryFunction:
        return self


@contextmanager
def refusals_explained() -> Iterator[None]:
    """SimulationError with the words of the external function, in place of CasADi's error about a call that failed."""
    functions = list(_functions.values())
    for function in functions:
        function.explain()  # what was said before is not about what comes now
    for last in _kept_points:
        last.point = None
    try:
        yield
    except RuntimeError:
        reasons = [reason for function in functions if (reason := function.explain())]
        if not reasons:
            raise
        raise SimulationError(" ".join(reasons)) from None


def _from_library(name: str, path: Path, source: str | None) -> LibraryFunction:
    if not path.is_file():
        raise ParameterError(f"external function {name}: there is no library {path}.")
    try:
        path = path.resolve()
        return LibraryFunction(ca.external(name, str(path)), path, open_library(path), source)
    except (RuntimeError, OSError) as error:
        reason = [line for line in str(error).splitlines() if line.strip()][-1].strip()
        raise ParameterError(f"external function {name}: {path} cannot be used: {reason}") from None


class _Last:
    """A function of one array that is not called again for the point it was called for last.

    CasADi asks for the blocks of a Jacobian one by one, and for values at the point of a Jacobian. What is kept is
    forgotten when a calculation with a plant begins, because the data behind a handle may be others by then.
    """

    def __init__(self, function: Compute):
        self.function = function
        self.point: np.ndarray | None = None
        self.value: Any = None
        _kept_points.add(self)

    def __call__(self, point: np.ndarray) -> Any:
        if self.point is None or not np.array_equal(point, self.point):
            self.point = None
            self.value = self.function(point)
            self.point = point.copy()
        return self.value


class _Python(ca.Callback):
    """A Python function as a CasADi function; slow, for prototypes and as the twin of a library."""

    def __init__(self, name: str, sizes: tuple[int, int], compute: Compute, jacobian: Compute | None,
                 sparsity: ca.Sparsity | None, stands_in: bool):  # fmt: skip
        self.stands_in = stands_in
        ca.Callback.__init__(self)
        self.sizes, self.compute = sizes, _Last(self._values(compute))
        self.slope = _Last(jacobian) if jacobian else None
        self.sparsity = sparsity or ca.Sparsity.dense(sizes[1], sizes[0])
        self._derivative: _PythonJacobian | None = None
        self.construct(name, {} if jacobian else {"enable_fd": True})

    def __deepcopy__(self, memo: Any) -> _Python:
        return self

    def _values(self, compute: Compute) -> Compute:
        return lambda point: np.asarray(compute(point), dtype=float).reshape(self.sizes[1], 1).copy()

    def get_n_in(self) -> int:
        return 1

    def get_n_out(self) -> int:
        return 1

    def get_sparsity_in(self, i: int) -> ca.Sparsity:
        return ca.Sparsity.dense(self.sizes[0], 1)

    def get_sparsity_out(self, i: int) -> ca.Sparsity:
        return ca.Sparsity.dense(self.sizes[1], 1)

    def eval(self, arguments: list[ca.DM]) -> list[np.ndarray]:
        return [self.compute(arguments[0].full().ravel())]

    def has_jacobian(self, *_: Any) -> bool:
        return self.slope is not None

    def get_jacobian(self, name: str, inames: Any, onames: Any, options: Any) -> ca.Function:
        self._derivative = _PythonJacobian(name, self.sizes, self.slope, self.sparsity)
        return self._derivative


class _PythonJacobian(ca.Callback):
    """d outputs / d inputs of a Python function: inputs are its input and its output."""

    def __init__(self, name: str, sizes: tuple[int, int], slope: Compute | None, sparsity: ca.Sparsity):
        ca.Callback.__init__(self)
        self.sizes, self.slope, self.sparsity = sizes, slope, sparsity
        self.construct(name, {})

    def get_n_in(self) -> int:
        return 2

    def get_n_out(self) -> int:
        return 1

    def get_sparsity_in(self, i: int) -> ca.Sparsity:
        return ca.Sparsity.dense(self.sizes[i], 1)

    def get_sparsity_out(self, i: int) -> ca.Sparsity:
        return self.sparsity

    def eval(self, arguments: list[ca.DM]) -> list[ca.DM]:
        slope = np.asarray(self.slope(arguments[0].full().ravel()), dtype=float)
        rows, columns = self.sparsity.get_triplet()
        return [ca.DM(self.sparsity, slope.reshape(self.sizes[1], self.sizes[0])[rows, columns])]
