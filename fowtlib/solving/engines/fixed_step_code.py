"""The compiled functions of a FlatDAE for the fixed-step engine, and the tables that its C runtime reads.

The tunable parameters stay arguments of the code (behind the inputs and discrete variables in q), so that a change of
parameters finds the library again.
"""

from __future__ import annotations

import ctypes as c
import json
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np

from fowtlib.flattening import FlatDAE
from fowtlib.language.cache import cached, sources
from fowtlib.language.externals import LibraryFunction
from fowtlib.language.native import Library, begin_library, compiler, load_library
from fowtlib.language.tables import SplineFunction
from fowtlib.solving.engines.c_lanes import for_this_processor, prologue, word_here
from fowtlib.solving.engines.c_text import WRITERS, Program, c_program
from fowtlib.solving.engines.reduction import Reduction, reduction
from fowtlib.solving.engines.statements import Depends
from fowtlib.solving.engines.symmetry import cyclic_unknowns
from fowtlib.solving.engines.turning_frames import TurningFrame, turning_frames
from fowtlib.solving.known_again import known_by

DOUBLES, INTEGERS = c.POINTER(c.c_double), c.POINTER(c.c_int)
CASADI = c.CFUNCTYPE(c.c_int, c.POINTER(DOUBLES), c.POINTER(DOUBLES), c.c_void_p, DOUBLES, c.c_int)

OUT = ["first", "second"]
W = 4  # the number of w among the arguments of the functions


class Spline(c.Structure):
    """fs_spline."""

    _fields_ = [
        ("arguments", c.c_int), ("outputs", c.c_int), ("count", c.c_int * 2), ("knots", DOUBLES * 2),
        ("coefficients", DOUBLES), ("low", c.c_double * 2), ("high", c.c_double * 2), ("uniform", c.c_int),
        ("periodic", c.c_int),
    ]  # fmt: skip


class External(c.Structure):
    """fs_external."""

    _fields_ = [
        *((name, c.c_int) for name in ("inputs", "outputs", "first_input", "first_output")), ("colind", INTEGERS),
        ("row", INTEGERS), ("entries", c.c_int), ("value", c.c_void_p), ("slope", c.c_void_p),
        *((name, c.c_int) for name in ("value_memory", "slope_memory", "arguments", "results", "integers", "reals")),
        ("spline", c.POINTER(Spline)),
    ]  # fmt: skip


class Moving(c.Structure):
    """fs_moving."""

    _fields_ = [("first", INTEGERS), ("piece", INTEGERS)]


class CyclicSymmetry(c.Structure):
    """fs_symmetry."""

    _fields_ = [
        *((name, c.c_int) for name in ("state", "parts", "unknowns", "rows")), ("unknown", INTEGERS), ("row", INTEGERS),
    ]  # fmt: skip


class Frame(c.Structure):
    """fs_frame."""

    _fields_ = [("unknowns", c.c_int), ("rows", c.c_int), ("unknown", INTEGERS), ("row", INTEGERS)]


class Model(c.Structure):
    """fs_model."""

    _fields_ = [
        *((name, c.c_int) for name in ("states", "algebraics", "given", "inputs", "outputs", "externals", "levels",
                                       "scratch")),
        ("level_start", INTEGERS), ("external", c.POINTER(External)), ("level_inputs", c.POINTER(c.c_void_p)),
        ("residual", c.c_void_p), ("pieces", c.c_void_p), ("piece_start", INTEGERS), ("place", INTEGERS),
        ("of_stage", Moving), ("at_point", Moving), ("free_rates", c.c_int), ("substituted", c.c_int),
        ("free_rate", INTEGERS), ("order", INTEGERS), ("source", INTEGERS), ("x_nominal", DOUBLES),
        ("z_nominal", DOUBLES), ("symmetries", c.c_int), ("symmetry", c.POINTER(CyclicSymmetry)), ("frames", c.c_int),
        ("frame", c.POINTER(Frame)), ("axes", c.c_void_p), ("inside", c.c_int),
        ("inside_state", INTEGERS), ("stage_steps", c.c_int), ("stage_step", INTEGERS),
    ]  # fmt: skip


class Options(c.Structure):
    """fs_options."""

    _fields_ = [
        ("step", c.c_double), ("rho_inf", c.c_double), ("tolerance", c.c_double),
        ("at_points", c.c_double), ("keep", c.c_int),
        ("predictor", c.c_int),
    ]  # fmt: skip


def begin_runtime() -> None:
    """Let the runtime be compiled beside what is done until it is needed, where it is not there yet."""
    if compiler():  # else the twin runs, and the text cannot be made either
        begin_library(_runtime_text(), "fixed_step", optimization="-O3")


def _runtime_text() -> str:
    """With the vectors of this processor; what it computes does not depend on their width."""
    texts = [(Path(__file__).parent / name).read_text(encoding="utf-8") for name in ("spline.c", "fixed_step.c")]
    return for_this_processor("".join(texts))


@cache
def runtime() -> Library:
    """The compiled runtime of the engine, the same for all models."""
    _, library = load_library(_runtime_text(), "fixed_step", optimization="-O3")
    pointer, number = c.c_void_p, c.c_double
    signatures = {
        "create": (pointer, [c.POINTER(Model), c.POINTER(Options)]),
        "free": (None, [pointer]),
        "consistent": (c.c_int, [pointer, number, *[pointer] * 3]),
        "observe": (c.c_int, [pointer, pointer, c.c_int, number, *[pointer] * 4]),
        "values": (c.c_int, [pointer, number, *[pointer] * 5]),
        "derivatives": (c.c_int, [pointer, number, *[pointer] * 5]),
        "see": (c.c_int, [pointer, number, *[pointer] * 3]),
        "observe_rows": (c.c_int, [pointer, pointer, c.c_int, c.c_int, *[pointer] * 5]),
        "advance": (c.c_int, [pointer, number, number, c.c_int, *[pointer] * 6]),
        "failure": (None, [pointer] * 5),
        "counts": (None, [pointer] * 2),
        "cuts": (c.c_int, [pointer] * 4),
        "stop": (None, [pointer, c.c_int]),
        "record": (pointer, [pointer] * 2),
        "watch": (None, [pointer, pointer, c.c_int, pointer, c.c_int, pointer, pointer]),
        "image_size": (c.c_size_t, [pointer]),
        "save": (None, [pointer] * 2),
        "restore": (None, [pointer] * 2),
        "fits": (c.c_int, [pointer, pointer, c.c_size_t]),
    }
    for name, (result, arguments) in signatures.items():
        function = getattr(library, f"fs_{name}")
        function.restype, function.argtypes = result, arguments
    return library


class FixedStepCode:
    """What the runtime needs of one model: compiled functions, externals and tables; made once for a plant.

    observed: paths of variables that can be rebuilt by compiled code, too; see `observe`. columns: of each of them in
    what `observe` gives; size: of all of that; width: with the conditions of the checks behind it. written: its text,
    where that was written before.
    """

    def __init__(self, dae: FlatDAE, observed: Sequence[str] = (), written: Written | None = None):
        self.dae = dae
        self.observed = list(observed)
        ends = np.cumsum([dae.observe_expression(path).numel() for path in self.observed], dtype=int).tolist()
        self.columns = {path: range(first, end) for path, first, end in zip(observed, [0, *ends], ends, strict=False)}
        self.size = ends[-1] if ends else 0
        self.width = self.size + len(dae.checks)
        self.reduction, self.frames, text, self.program, self.scratch = written or write(dae, self.observed)
        self.raised: list[Exception] = []  # by Python code inside of a step
        self._alive: list[Any] = []  # what the tables point to
        self.external_order = [k for level in dae.levels for k in level]
        self.constants = self.doubles([*self.program.constants, 0.0])
        self.path, self.library = load_library(text, "model", optimization=_OPTIMIZATION)
        self.table = self._model()
        self.samples_need_outputs = [dae.needs_outputs(sample.values) for sample in dae.samples]

    def doubles(self, values: Any) -> Any:
        """A pointer to numbers that stay alive as long as the code."""
        return self._kept(np.ascontiguousarray(values, dtype=float), DOUBLES)

    def integers(self, values: Any) -> Any:
        """The same for integers."""
        return self._kept(np.ascontiguousarray(values, dtype=np.intc), INTEGERS)

    def _kept(self, array: np.ndarray, kind: Any) -> Any:
        self._alive.append(array)
        return array.ctypes.data_as(kind)

    def _model(self) -> Model:
        dae, reduced = self.dae, self.reduction
        externals = self._externals()
        inputs = (c.c_void_p * max(len(dae.levels), 1))()
        for level in range(len(dae.levels)):
            inputs[level] = self.address(f"level_{level}")
        self._alive += [externals, inputs]
        starts = np.cumsum([0, *(len(level) for level in dae.levels)])
        of_stage, at_point = self.program.masks
        unknowns = dae.z.shape[0] + len(reduced.free)
        symmetries = cyclic_unknowns(dae, reduced)
        table = (CyclicSymmetry * max(len(symmetries), 1))(*(
            CyclicSymmetry(r.state, len(r.unknowns[0]), len(r.unknowns), len(r.rows),
                           self.integers(np.ravel(r.unknowns)), self.integers(np.ravel(r.rows)))
            for r in symmetries
        ))  # fmt: skip
        frames = (Frame * max(len(self.frames), 1))(*(
            Frame(len(f.unknowns), len(f.rows), self.integers(np.ravel(f.unknowns)), self.integers(np.ravel(f.rows)))
            for f in self.frames
        ))  # fmt: skip
        self._alive += [table, frames]
        return Model(
            states=dae.x.shape[0], algebraics=dae.z.shape[0], given=sum(v.shape[0] for v in (dae.u, dae.d, dae.p)),
            inputs=sum(external.inputs.shape[0] for external in dae.externals), outputs=dae.w.shape[0],
            externals=len(dae.externals), levels=len(dae.levels), scratch=self.scratch,
            level_start=self.integers(starts), external=externals, level_inputs=inputs,
            residual=self.address("model"), pieces=self.address("pieces"),
            piece_start=self.integers(self.program.starts), place=self.integers(self.program.places),
            of_stage=self._moving(of_stage, unknowns + len(reduced.inside)),
            at_point=self._moving(at_point, dae.z.shape[0]),
            free_rates=len(reduced.free), substituted=len(reduced.order),
            free_rate=self.integers(reduced.free), order=self.integers(reduced.order),
            source=self.integers(reduced.source), x_nominal=self.doubles([s.nominal for s in dae.states]),
            z_nominal=self.doubles([a.nominal for a in dae.algebraics]), symmetries=len(symmetries), symmetry=table,
            frames=len(self.frames), frame=frames, axes=self.address("axes"),
            inside=len(reduced.inside), inside_state=self.integers(reduced.inside), stage_steps=len(reduced.steps),
            stage_step=self.integers(reduced.steps),
        )  # fmt: skip

    def observe(self, t: np.ndarray, x: np.ndarray, z: np.ndarray, q: np.ndarray) -> np.ndarray | None:
        """The observed variables, all their elements in a row for each of t; None where an external function fails."""
        rows = [np.ascontiguousarray(values, dtype=float) for values in (t, x, z, q)]
        values = np.empty((len(t), self.size))
        library = runtime()
        instance = library.fs_create(c.byref(self.table), c.byref(Options(1.0, 0.0, 1.0, 1.0, 1, 0)))
        if not instance:
            raise MemoryError("no memory for the fixed-step engine")
        try:
            status = library.fs_observe_rows(instance, self.address("observed"), len(t), self.size,
                                             *(row.ctypes.data for row in rows), values.ctypes.data)  # fmt: skip
        finally:
            library.fs_free(instance)
        return None if status else values

    def _moving(self, masks: list[int], unknowns: int) -> Moving:
        first, pieces = moved_pieces(self.program, len(self.dae.levels), masks, unknowns)
        return Moving(self.integers(first), self.integers(pieces))

    def address(self, name: str) -> int:
        """Where a function or table of the generated code is."""
        return c.cast(getattr(self.library, name), c.c_void_p).value

    # --- externals -----------------------------------------------------------------------------------------------

    def _externals(self) -> Any:
        table = (External * max(len(self.external_order), 1))()
        position = 0
        for place, k in enumerate(self.external_order):
            external = self.dae.externals[k]
            entry = table[place]
            entry.inputs, entry.outputs = external.inputs.shape[0], external.outputs.stop - external.outputs.start
            entry.first_input, entry.first_output = position, external.outputs.start
            position += entry.inputs
            function = external.function
            if isinstance(function, SplineFunction):
                self._spline(entry, function)
            elif isinstance(function, LibraryFunction):
                self._from_library(entry, function)
            else:
                self._through_casadi(entry, function)
        return table

    def _pattern(self, entry: External, pattern: ca.Sparsity) -> None:
        entry.colind, entry.row = self.integers(pattern.colind()), self.integers(pattern.row())
        entry.entries = pattern.nnz()

    def _spline(self, entry: External, function: SplineFunction) -> None:
        data = function.data
        self._pattern(entry, ca.Sparsity.dense(entry.outputs, entry.inputs))
        spline = Spline(
            arguments=len(data.knots), outputs=entry.outputs, coefficients=self.doubles(data.coefficients),
            uniform=data.uniform, periodic=data.periodic,
        )  # fmt: skip
        for a, (knots, (low, high)) in enumerate(zip(data.knots, data.ranges, strict=True)):
            spline.knots[a], spline.count[a] = self.doubles(knots), len(knots) - 4
            spline.low[a], spline.high[a] = low, high
        self._alive.append(spline)
        entry.spline = c.pointer(spline)

    def _from_library(self, entry: External, function: LibraryFunction) -> None:
        """By the function pointers of CasADi's C interface; without jac_<name>, differences are taken."""
        library = function.opened
        name = function.name()
        sizes = [_work(library, name)]
        entry.value, entry.value_memory = _symbol(library, name), _memory(library, name)
        pattern = _slope_pattern(function)
        if pattern is not None:
            slope = f"jac_{name}"
            sizes.append(_work(library, slope))
            entry.slope, entry.slope_memory = _symbol(library, slope), _memory(library, slope)
            self._pattern(entry, pattern)
        entry.arguments, entry.results, entry.integers, entry.reals = np.max(sizes, axis=0).tolist()
        self._alive.append(library)

    def _through_casadi(self, entry: External, function: ca.Function) -> None:
        """Anything else is called back in Python: right, and slow."""
        y = ca.MX.sym("y", entry.inputs)
        jacobian = ca.Function("slope", [y], [ca.jacobian(ca.vec(function(y)), y)])
        self._pattern(entry, jacobian.sparsity_out(0))
        entry.value = self._callback(function, entry.inputs, dense=True)
        entry.slope = self._callback(jacobian, entry.inputs, dense=False)

    def _callback(self, function: ca.Function, inputs: int, dense: bool) -> int:
        def call(arguments: Any, results: Any, integers: Any, reals: Any, memory: Any) -> int:
            try:
                value = function(np.ctypeslib.as_array(arguments[0], (inputs,)))
                numbers = np.array(ca.densify(value) if dense else value.nonzeros(), dtype=float).ravel(order="F")
                np.ctypeslib.as_array(results[0], (numbers.size,))[:] = numbers
            except Exception as error:  # it cannot pass through the C code; the engine raises it
                self.raised.append(error)
                return 1
            return 0

        self._alive.append(CASADI(call))
        return c.cast(self._alive[-1], c.c_void_p).value


Written = tuple[Reduction, Sequence[TurningFrame], str, Program, int]
_OPTIMIZATION = "-O1"


def write(dae: FlatDAE, observed: Sequence[str]) -> Written:
    """The text of a model for this machine, with its reduction, frames, tables and the scratch memory that it needs."""
    reduced, frames = reduction(dae), turning_frames(dae)
    text, program, scratch = kept_text(dae, reduced, observed, frames, word_here())
    return reduced, frames, for_this_processor(text), program, scratch


def begin(dae: FlatDAE, observed: Sequence[str]) -> Written:
    """Write the text, and let it and the runtime be compiled beside what is done until they are needed."""
    begin_runtime()
    written = write(dae, observed)
    begin_library(written[2], "model", optimization=_OPTIMIZATION)
    return written


def kept_text(
    dae: FlatDAE, reduced: Reduction, observed: Sequence[str], frames: Sequence[TurningFrame], word: int
) -> tuple[str, Program, int]:
    """What `model_text` returns, from the cache where these equations have been written before."""
    known = known_by(dae)
    parts = [*known, json.dumps([word, list(observed)])] if known else _content(dae, reduced, observed, frames, word)

    def make() -> dict[str, Any]:
        text, program, scratch = model_text(dae, reduced, observed, frames, word)
        masks = [[hex(mask) for mask in some] for some in program.masks]
        return {"text": text, "scratch": scratch, "program": {**vars(program), "text": "", "masks": masks}}

    found = cached("text", parts, make)
    program = found["program"]
    program["masks"] = [[int(mask, 16) for mask in some] for some in program["masks"]]
    return found["text"], Program(**program), found["scratch"]


def _content(
    dae: FlatDAE, reduced: Reduction, observed: Sequence[str], frames: Sequence[TurningFrame], word: int
) -> list[str]:
    """All that the text is made from, of equations that are not known again."""
    function = _function(dae, observed, {})
    patterns = [_slope_pattern(external.function) for external in dae.externals]
    structure = [
        vars(reduced), dae.levels, [y.shape[0] for y in dae.level_inputs], [sample.targets for sample in dae.samples],
        [[external.outputs.start, external.outputs.stop, external.inputs.numel()] for external in dae.externals],
        [pattern and [pattern.shape, pattern.colind(), pattern.row()] for pattern in patterns],
    ]  # fmt: skip
    samples = [ca.Function("sample", _arguments(dae), [ca.densify(sample.values)]) for sample in dae.samples]
    equations = [item.serialize() for item in (function, *samples, _axes(dae, frames), _conditions(dae))]
    return [*sources(__name__, *WRITERS), json.dumps([word, structure]), *equations]


def _arguments(dae: FlatDAE) -> list[ca.SX]:
    return [dae.t, dae.x, dae.z, ca.vertcat(dae.u, dae.d, dae.p), dae.w]


def _function(dae: FlatDAE, observed: Sequence[str], options: dict[str, Any]) -> ca.Function:
    """Inputs of the externals, level by level, ode, alg and variables as one function."""
    variables = ca.vertcat(*[ca.vec(dae.observe_expression(path)) for path in observed])
    results = [ca.densify(e) for e in dae.in_time([*dae.level_inputs, dae.ode, dae.alg, variables])]
    return ca.Function("model", _arguments(dae), results, options)


def _axes(dae: FlatDAE, frames: Sequence[TurningFrame]) -> ca.Function:
    """R of each frame, row by row."""
    rows = ca.densify(ca.vertcat(*[ca.vec(frame.R.T) for frame in frames]))
    return ca.Function("axes", _arguments(dae), [rows], {"cse": True})


def _conditions(dae: FlatDAE) -> ca.Function:
    """Of the checks: 0 where one is broken."""
    conditions = ca.densify(ca.vertcat(*[check.condition for check in dae.checks]))
    return ca.Function("checked", _arguments(dae), dae.in_time([conditions]), {"cse": True})


def moved_pieces(program: Program, levels: int, masks: list[int], unknowns: int) -> tuple[list[int], list[int]]:
    """The pieces that depend on each unknown, one after the other, and where those of each unknown begin."""
    last = program.starts[levels + 1]  # behind the residual
    pieces = [[piece for piece, mask in enumerate(masks[:last]) if mask >> k & 1] for k in range(unknowns)]
    return [0, *np.cumsum([*map(len, pieces)]).tolist()], [piece for some in pieces for piece in some]


def model_text(
    dae: FlatDAE, reduced: Reduction, observed: Sequence[str], frames: Sequence[TurningFrame], word: int
) -> tuple[str, Program, int]:
    """C text, its program of the inputs of the externals, level by level, and the residual, and its scratch memory.

    The text defines level_0, level_1, ..., model; observed, which follows a call of these; and, each of them alone,
    sample_0, ... for the sampled parts, axes for the rows of R of the frames, and checked for the conditions of the
    checks. Constants of the program are those of the checks, which may tell where data end: the text is the same for
    all data.
    """
    function = _function(dae, observed, {"cse": True})
    sections = [(f"level_{level}", ["first"]) for level in range(len(dae.levels))] + [("model", ["first", "second"])]
    sections.append(("observed", ["first"]))
    program = c_program(function, sections, list("txzqw"), OUT, dependences(dae, reduced), _known_from(dae), word)
    texts, scratch = [prologue(word), program.text], program.scratch
    for k, sample in enumerate(dae.samples):
        function = ca.Function("sample", _arguments(dae), [ca.densify(sample.values)], {"cse": True})
        alone = c_program(function, [(f"sample_{k}", ["first"])], list("txzqw"), OUT, word=word)
        texts.append(alone.text)
        scratch = max(scratch, alone.scratch)
    alone = c_program(_axes(dae, frames), [("axes", ["first"])], list("txzqw"), OUT, word=word)
    texts.append(alone.text)
    scratch = max(scratch, alone.scratch)
    alone = c_program(_conditions(dae), [("checked", ["first"])], list("txzqw"), OUT, word=word, constants="second")
    program = replace(program, constants=alone.constants)
    return "".join([*texts, alone.text]), program, max(scratch, alone.scratch)


def _known_from(dae: FlatDAE) -> Callable[[int, int], int]:
    """The section from which on an element of an argument is known: outputs of externals behind their level."""
    level = [0] * dae.w.shape[0]
    for number, members in enumerate(dae.levels):
        for k in members:
            outputs = dae.externals[k].outputs
            level[outputs] = [number + 1] * (outputs.stop - outputs.start)
    return lambda argument, element: level[element] if argument == W else 0


def dependences(dae: FlatDAE, reduced: Reduction) -> tuple[Depends, Depends]:
    """The unknowns of a stage, z and the free rates, on which x, z and w depend; and the same with x held."""
    nz = dae.z.shape[0]
    of_x = [1 << unknown for unknown in reduced.unknown_of_states(nz)]
    of_z = [1 << k for k in range(nz)]

    def depends(of_x: list[int]) -> Depends:
        of_w = [0] * dae.w.shape[0]
        for members, expression in zip(dae.levels, dae.level_inputs, strict=True):
            function = ca.Function("inputs", [dae.x, dae.z, dae.w], [expression], {"allow_free": True})
            of_y = [0] * expression.shape[0]
            for argument, known in enumerate((of_x, of_z, of_w)):
                for row, column in zip(*function.jac_sparsity(0, argument).get_triplet(), strict=True):
                    of_y[row] |= known[column]
            first = 0
            for k in members:
                external = dae.externals[k]
                size = external.inputs.numel()
                pattern = _slope_pattern(external.function)
                pattern = pattern or ca.Sparsity.dense(external.outputs.stop - external.outputs.start, size)
                for row, column in zip(*pattern.get_triplet(), strict=True):
                    of_w[external.outputs.start + row] |= of_y[first + column]
                first += size
        table = {1: of_x, 2: of_z, 4: of_w}
        return lambda argument, element: table[argument][element] if argument in table else 0

    return depends(of_x), depends([0] * len(of_x))


def _slope_pattern(function: ca.Function) -> ca.Sparsity | None:
    """Pattern of the Jacobian that the library of a function has; None where it has none, or is no library."""
    if isinstance(function, LibraryFunction) and hasattr(function.opened, f"jac_{function.name()}"):
        return function.jacobian().sparsity_out(0)
    return None


def library_sizes(function: LibraryFunction) -> tuple[list[int], bool]:
    """Arguments, results, integers and reals that a function of a library and its Jacobian need; whether it has one."""
    library, name = function.opened, function.name()
    names = [name] + [f"jac_{name}"] * hasattr(library, f"jac_{name}")
    return np.max([_work(library, each) for each in names], axis=0).tolist(), len(names) > 1


def _symbol(library: c.CDLL, name: str) -> int:
    return c.cast(getattr(library, name), c.c_void_p).value


def _work(library: c.CDLL, name: str) -> list[int]:
    """Arguments, results, integers and reals that a function of CasADi's C interface needs as work."""
    sizes = [c.c_longlong(2), c.c_longlong(1), c.c_longlong(0), c.c_longlong(0)]
    if hasattr(library, f"{name}_work"):
        getattr(library, f"{name}_work")(*(c.byref(size) for size in sizes))
    return [size.value for size in sizes]


def _memory(library: c.CDLL, name: str) -> int:
    return getattr(library, f"{name}_checkout")() if hasattr(library, f"{name}_checkout") else 0
