"""The tables of a model for the C code of an FMU: sizes, names, start values, splines, externals, events, checks."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np

from fowtlib.flattening import FlatDAE
from fowtlib.fmi.variables import Variable, Variables
from fowtlib.language.errors import StructureError
from fowtlib.language.externals import LibraryFunction
from fowtlib.language.tables import SplineFunction
from fowtlib.solving import event_rules as rules
from fowtlib.solving.engines import fixed_step
from fowtlib.solving.engines.c_text import Program
from fowtlib.solving.engines.fixed_step_code import OUT, library_sizes, moved_pieces
from fowtlib.solving.engines.reduction import reduction
from fowtlib.solving.engines.symmetry import cyclic_unknowns
from fowtlib.solving.engines.turning_frames import turning_frames
from fowtlib.solving.initial import initial_matching
from fowtlib.solving.state import State

LONG = 2000  # numbers of a table that goes to resources/ and not into the C text
VALUES = [f"const double *{name}" for name in "txzqw"]
SEEDS = [f"const double *d{name}" for name in "xzqw"]


def libraries(dae: FlatDAE) -> dict[str, LibraryFunction]:
    """The external functions of libraries by name."""
    found: dict[str, LibraryFunction] = {}
    for external in dae.externals:
        function = external.function
        if not isinstance(function, LibraryFunction):
            continue
        if found.setdefault(function.name(), function).path != function.path:
            raise StructureError(
                f"{external.path}: two different libraries have the same function {function.name()}; name one anew."
            )
    return found


def column(values: Sequence[ca.SX]) -> ca.SX:
    """One dense column."""
    return ca.densify(ca.vertcat(*values)) if values else ca.SX(0, 1)


def event_rules() -> Iterator[tuple[str, str]]:
    """Names and C texts of the rules that the FMU core shares with the run of a simulation."""
    for name, value in vars(rules).items():
        if name.isupper():
            text = ", ".join(map(repr, value)) if isinstance(value, tuple) else repr(value)
            yield f"RULE_{name}", text


class Tables:
    """The text of tables.h, and the long tables that go to the resources."""

    def __init__(self, variables: Variables, start: State, program: Program, scratch: int,
                 identity: tuple[str, str]):  # fmt: skip
        self.variables, self.dae, self.start, self.scratch = variables, variables.plant.dae, start, scratch
        self.binding = variables.plant.binding(start.parameters)
        self.program = program
        self.identity = identity
        self.lines: list[str] = []
        self.stored: list[tuple[np.ndarray, int]] = []  # long tables and their columns
        self.uses: list[str] = []
        self.splines: list[str] = []
        self.spline_of: list[int] = []
        self.resources: dict[str, Path] = {}
        self.reduction = reduction(self.dae)
        self.order = [k for level in self.dae.levels for k in level]

    def packed(self) -> bytes:
        """What lies in resources/tables.bin; see fmu_unpack in fmu_core.c."""
        return b"".join(_packed(values, columns) for values, columns in self.stored)

    def text(self) -> str:
        """Tables.h."""
        dae, variables = self.dae, self.variables
        entries = self._externals()
        bound = self.binding.p[sum(item.symbol.numel() for item in dae.parameters.values()) :]
        files = self._files()
        kept, states = initial_matching(dae)
        checked = ca.vertcat(*[c.condition for c in dae.checks], *[v for c in dae.checks for v in c.values.values()])
        told = sum(len(check.values) for check in dae.checks)
        observed = [dae.observe_expression(path).numel() for path in variables.observed]
        sizes = {
            "NX": dae.x.shape[0], "NZ": dae.z.shape[0], "NU": dae.u.shape[0], "ND": dae.d.shape[0],
            "NP": dae.p.shape[0] - bound.size, "BOUND": bound.size, "BREAKS": len(self.binding.breaks),
            "NQ": sum(v.shape[0] for v in (dae.u, dae.d, dae.p)), "NW": dae.w.shape[0],
            "NY": sum(e.inputs.shape[0] for e in dae.externals), "EXTERNALS": len(dae.externals),
            "SPLINES": len(self.splines), "OUTPUTS": len(variables.output_expressions), "EVENTS": len(dae.events),
            "OBSERVED": sum(observed),
            "SAMPLES": len(dae.samples), "CHECKS": len(dae.checks), "MESSAGE_VALUES": told,
            "INITIALS": dae.initial_equations.shape[0], "SCRATCH": self.scratch,
            "STORED": sum(len(values) for values, _ in self.stored), "TABLES": len(self.stored),
            "TABLE_USES": len(self.uses), "FILES": len(files), "FREE_RATES": len(self.reduction.free),
            "KEEP": fixed_step.KEEP, "PREDICTOR": fixed_step.PREDICTOR,
            "INDICATORS_NEED_OUTPUTS": int(dae.needs_outputs(column([e.indicator for e in dae.events]))),
            "CHECKS_NEED_OUTPUTS": int(dae.needs_outputs(checked)),
        }  # fmt: skip
        first = {f"FIRST_{group.upper()}": variables.first[group] for group in variables.first if group != "time"}
        settings = variables.settings
        called = [dae.externals[k] for k in self.order]
        names = [f"{{{_text(item.function.name())}, {_text(item.path)}}}" for item in called]
        head = [
            "/* The tables of a model, made by fowtlib. */\n",
            f"#define MODEL_NAME {_text(self.identity[0])}\n#define MODEL_TOKEN {_text(self.identity[1])}\n",
            f"#define NEWTON_FACTOR {fixed_step.NEWTON!r}\n#define POINT_FACTOR {fixed_step.AT_POINTS!r}\n",
            *(f"#define {name} {value}\n" for name, value in event_rules()),
            f"#define OUTPUT_STEP {_number(settings.output_step)}\n#define START_TIME {_number(self.start.t)}\n",
            "enum { " + ", ".join(f"{key} = {value}" for key, value in {**sizes, **first}.items()) + " };\n",
            self._prototypes(),
        ]
        rates = [f"der({s.path})" for s in dae.states]
        rows = [*dae.residual_paths, *(rates[i] for i in self.reduction.free), *rates]
        body = [
            self._quantities("fmu_states", variables.group("state")),
            self._quantities("fmu_inputs", variables.group("input")),
            self._quantities("fmu_parameters", variables.group("parameter")),
            self._quantities("fmu_solver", variables.group("solver")),
            _doubles("fmu_bound", bound), _doubles("fmu_breaks", self.binding.breaks),
            _texts("fmu_rows", rows), _texts("fmu_initial_paths", dae.initial_paths),
            _doubles("fmu_x_nominal", [s.nominal for s in dae.states]),
            _doubles("fmu_z_nominal", [a.nominal for a in dae.algebraics]),
            _doubles("fmu_z_start", self.start.z), _integers("fmu_initial_row", kept),
            _integers("fmu_output_place", variables.output_places),
            _integers("fmu_initial_state", states), *self.lines,
            _table("fs_external", "fmu_externals", entries), _table("fs_spline", "fmu_splines", self.splines),
            _integers("fmu_spline_of", self.spline_of), self._stored(),
            _table("fmu_table_use", "fmu_table_uses", self.uses),
            _table("fmu_external_name", "fmu_external_names", names), _table("fmu_file", "fmu_files", files),
            self._model(), self._events(), self._samples(), self._checks(),
        ]  # fmt: skip
        return "".join([*head, *body])

    def _prototypes(self) -> str:
        dae = self.dae
        plain = ["model", "axes", "observed", "indicators", "checks", "starts", "clocks", "initials"]
        plain += [f"level_{k}" for k in range(len(dae.levels))] + [f"sample_{k}" for k in range(len(dae.samples))]
        plain += [f"action_{k}" for k in range(len(dae.events))]
        moved = ["forward_model", "forward_outputs", "forward_initials"]
        forward = [f"forward_level_{k}" for k in range(len(dae.levels))]
        results = ", ".join(f"double *{name}" for name in [*OUT, "scratch"])
        values, seeds = ", ".join(VALUES), ", ".join(SEEDS)
        lines = [f"void {name}({values}, {results});\n" for name in plain] + ["extern const fs_code pieces[];\n"]
        lines.append("void wide_equations(const fs_code **inputs, fs_code *residual, const fs_code **all_pieces);\n")
        lines += [f"void {name}({values}, {seeds}, {results});\n" for name in moved + forward]
        lines.append(_table("fmu_forward_code", "fmu_forward_levels", forward))
        for name in libraries(dae):
            call = "(const double **arg, double **res, fs_int *iw, double *w, int mem);\n"
            lines.append(f"int {name}{call}int jac_{name}{call}")
        return "".join(lines)

    def _quantities(self, name: str, items: Sequence[Variable]) -> str:
        rows = [
            f"{{{_text(v.name)}, {_text('' if v.unit == '1' else v.unit)}, {_text(v.doc)}, {_number(v.start or 0.0)}, "
            f"{_number(-math.inf if v.low is None else v.low)}, {_number(math.inf if v.high is None else v.high)}}}"
            for v in items
        ]
        return _table("fmu_quantity", name, rows)

    def _model(self) -> str:
        dae, r = self.dae, self.reduction
        starts = np.cumsum([0, *(len(level) for level in dae.levels)])
        levels = [f"level_{k}" for k in range(len(dae.levels))]
        of_stage, at_point = self.program.masks
        moved = dae.z.shape[0] + len(r.free) + len(r.inside)
        moving = (("fmu_stage", of_stage, moved), ("fmu_point", at_point, dae.z.shape[0]))
        lines = [_integers("fmu_piece_start", self.program.starts), _integers("fmu_place", self.program.places)]
        for name, masks, unknowns in moving:
            first, pieces = moved_pieces(self.program, len(dae.levels), masks, unknowns)
            lines += [_integers(f"{name}_first", first), _integers(f"{name}_piece", pieces)]
        symmetries = cyclic_unknowns(dae, r)
        for k, symmetry in enumerate(symmetries):
            lines.append(_integers(f"fmu_symmetry_{k}_unknown", np.ravel(symmetry.unknowns)))
            lines.append(_integers(f"fmu_symmetry_{k}_row", np.ravel(symmetry.rows)))
        rows = [
            f"{{{symmetry.state}, {len(symmetry.unknowns[0])}, {len(symmetry.unknowns)}, {len(symmetry.rows)}, "
            f"fmu_symmetry_{k}_unknown, fmu_symmetry_{k}_row}}"
            for k, symmetry in enumerate(symmetries)
        ]
        lines.append(_table("fs_symmetry", "fmu_symmetry", rows))
        frames = turning_frames(dae)
        for k, frame in enumerate(frames):
            lines.append(_integers(f"fmu_frame_{k}_unknown", np.ravel(frame.unknowns)))
            lines.append(_integers(f"fmu_frame_{k}_row", np.ravel(frame.rows)))
        rows = [
            f"{{{len(frame.unknowns)}, {len(frame.rows)}, fmu_frame_{k}_unknown, fmu_frame_{k}_row}}"
            for k, frame in enumerate(frames)
        ]
        lines.append(_table("fs_frame", "fmu_frame", rows))
        return "".join([
            *lines, _integers("fmu_level_start", starts), _integers("fmu_free_rate", r.free),
            _integers("fmu_order", r.order), _integers("fmu_source", r.source),
            _integers("fmu_inside_state", r.inside), _integers("fmu_stage_step", r.steps),
            _table("fs_code", "fmu_level_inputs", levels),
            "static const fs_model fmu_model = {.states = NX, .algebraics = NZ, .given = NQ, .inputs = NY, "
            f".outputs = NW, .externals = EXTERNALS, .levels = {len(dae.levels)}, .scratch = SCRATCH, "
            ".level_start = fmu_level_start, .external = fmu_externals, .level_inputs = fmu_level_inputs, "
            ".residual = model, .pieces = pieces, .piece_start = fmu_piece_start, .place = fmu_place, "
            ".of_stage = {fmu_stage_first, fmu_stage_piece}, .at_point = {fmu_point_first, fmu_point_piece}, "
            ".free_rates = FREE_RATES, "
            f".substituted = {len(r.order)}, .free_rate = fmu_free_rate, .order = fmu_order, .source = fmu_source, "
            ".x_nominal = fmu_x_nominal, .z_nominal = fmu_z_nominal, "
            f".symmetries = {len(symmetries)}, .symmetry = fmu_symmetry, "
            f".frames = {len(frames)}, .frame = fmu_frame, .axes = axes, .inside = {len(r.inside)}, "
            f".inside_state = fmu_inside_state, .stage_steps = {len(r.steps)}, .stage_step = fmu_stage_step}};\n",
        ])  # fmt: skip

    def _events(self) -> str:
        lines, rows = [], []
        for k, event in enumerate(self.dae.events):
            lines.append(_integers(f"fmu_event_{k}_x", event.state_targets))
            lines.append(_integers(f"fmu_event_{k}_d", event.discrete_targets))
            sizes = f"{len(event.state_targets)}, {len(event.discrete_targets)}"
            rows.append(f"{{{_text(event.path)}, {sizes}, fmu_event_{k}_x, fmu_event_{k}_d, action_{k}}}")
        return "".join(lines) + _table("fmu_event", "fmu_events", rows)

    def _samples(self) -> str:
        lines, rows = [], []
        for k, sample in enumerate(self.dae.samples):
            lines.append(_integers(f"fmu_sample_{k}_d", sample.targets))
            sizes = f"{len(sample.targets)}, {int(self.dae.needs_outputs(sample.values))}"
            rows.append(f"{{{_text(sample.path)}, {sizes}, fmu_sample_{k}_d, sample_{k}}}")
        return "".join(lines) + _table("fmu_sample", "fmu_samples", rows)

    def _checks(self) -> str:
        lines, rows = [], []
        for k, check in enumerate(self.dae.checks):
            lines.append(_texts(f"fmu_check_{k}", list(check.values)))
            is_error = int(check.level != "warning")
            message = _text(self.binding.words(check.message).rstrip("."))
            rows.append(f"{{{_text(check.path)}, {message}, {is_error}, {len(check.values)}, fmu_check_{k}}}")
        return "".join(lines) + _table("fmu_check", "fmu_checks", rows)

    # --- externals ---------------------------------------------------------------------------------------------------

    def _externals(self) -> list[str]:
        rows, position = [], 0
        for place, k in enumerate(self.order):
            external = self.dae.externals[k]
            function, ny = external.function, external.inputs.shape[0]
            nw = external.outputs.stop - external.outputs.start
            places = f".first_input = {position}, .first_output = {external.outputs.start}"
            common = f".inputs = {ny}, .outputs = {nw}, {places}"
            position += ny
            if isinstance(function, SplineFunction):
                pattern, rest = ca.Sparsity.dense(nw, ny), ""
                self.spline_of.append(self._spline(function, nw))
            else:
                pattern, rest = self._library(function)
                self.spline_of.append(-1)
            self.lines.append(_integers(f"fmu_colind_{place}", pattern.colind()))
            self.lines.append(_integers(f"fmu_row_{place}", pattern.row()))
            rest += f", .colind = fmu_colind_{place}, .row = fmu_row_{place}, .entries = {pattern.nnz()}"
            rows.append(f"{{{common}{rest}}}")
        return rows

    def _library(self, function: LibraryFunction) -> tuple[ca.Sparsity, str]:
        name = function.name()
        sizes, has_slope = library_sizes(function)
        if not has_slope:
            raise StructureError(
                f"the external function {name} has no jac_{name} in its library, and an FMU gives exact derivatives."
            )
        kinds = ("arguments", "results", "integers", "reals")
        work = ", ".join(f".{kind} = {size}" for kind, size in zip(kinds, sizes, strict=True))
        return function.jacobian().sparsity_out(0), f", .value = {name}, .slope = jac_{name}, {work}"

    def _spline(self, function: SplineFunction, outputs: int) -> int:
        data, number = function.data, len(self.splines)
        knots = [self._array(number, part, values, 1) for part, values in enumerate(data.knots)]
        coefficients = self._array(number, 2, data.coefficients, outputs)
        lows, highs = ([_number(r[i]) for r in data.ranges] for i in (0, 1))
        counts = ", ".join(str(len(k) - 4) for k in data.knots)
        self.splines.append(
            f"{{.arguments = {len(data.knots)}, .outputs = {outputs}, .count = {{{counts}}}, "
            f".knots = {{{', '.join(knots)}}}, .coefficients = {coefficients}, .low = {{{', '.join(lows)}}}, "
            f".high = {{{', '.join(highs)}}}, "
            f".uniform = {int(data.uniform)}, .periodic = {int(data.periodic)}}}"
        )
        return number

    def _array(self, spline: int, part: int, values: Any, columns: int) -> str:
        """The name of a constant array; null for a long one, which is read from the resources."""
        values = np.asarray(values, dtype=float).ravel()
        if len(values) > LONG:
            known = (k for k, (there, _) in enumerate(self.stored) if np.array_equal(there, values))
            table = next(known, len(self.stored))
            if table == len(self.stored):
                self.stored.append((values, columns))
            self.uses.append(f"{{{spline}, {part}, {table}}}")
            return "0"
        self.lines.append(_doubles(f"fmu_spline_{spline}_{part}", values))
        return f"fmu_spline_{spline}_{part}"

    def _stored(self) -> str:
        first, rows = 0, []
        for values, columns in self.stored:
            rows.append(f"{{{first}, {len(values)}, {columns}}}")
            first += len(values)
        return _table("fmu_stored", "fmu_tables", rows)

    def _files(self) -> list[str]:
        """The files that external functions read, which go to the resources; each with a function that opens it."""
        found: dict[tuple[str, float], tuple[str, tuple[float | int, ...]]] = {}
        for record in self.dae.bound.values():
            source = self.binding.sources.get(record.path)
            for function in record.functions if source is not None else ():
                path, values = source.file_for(function)
                found[function.name, float(source.numbers[0])] = self._resource(path), values
        rows = []
        for k, ((name, number), (inside, values)) in enumerate(found.items()):
            kinds = "".join(f", {'int' if isinstance(value, int) else 'double'}" for value in values)
            passed = "".join(f", {int(v) if isinstance(v, int) else _number(v)}" for v in values)
            opened = f"{name}_open({_number(number)}, path{passed})"
            self.lines.append(
                f"int {name}_open(double, const char *{kinds});\nconst char *{name}_problem(void);\n"
                f"static int fmu_open_{k}(const char *path) {{ return {opened}; }}\n"
            )
            rows.append(f"{{{_text(inside)}, fmu_open_{k}, {name}_problem}}")
        return rows

    def _resource(self, path: Path) -> str:
        """The name of a file among the resources."""
        inside = next((key for key, known in self.resources.items() if known == path), "")
        inside = inside or f"{len(self.resources)}_{path.name}"
        self.resources[inside] = path
        return inside


def _packed(values: np.ndarray, columns: int) -> bytes:
    """The bytes of the second differences of the numbers as integers, column by column, lowest bytes first."""
    bits = values.view(np.int64).reshape(-1, columns)
    for _ in range(2):
        bits = np.diff(bits, axis=0, prepend=np.zeros((1, columns), np.int64))
    return np.ascontiguousarray(bits.T.astype("<i8")).view(np.uint8).reshape(-1, 8).T.tobytes()


def _text(value: str) -> str:
    """A string of C, in UTF-8."""
    return json.dumps(value, ensure_ascii=False).replace("??", '?""?')  # no trigraphs


def _number(value: float) -> str:
    if math.isnan(value):
        return "NAN"
    if math.isinf(value):
        return "INFINITY" if value > 0 else "-INFINITY"
    return repr(float(value))


def _table(kind: str, name: str, rows: Sequence[str]) -> str:
    if not rows:
        return f"static const {kind} {name}[1] = {{0}};\n"
    inside = ",\n  ".join(rows)
    return f"static const {kind} {name}[{len(rows)}] = {{\n  {inside}}};\n"


def _doubles(name: str, values: Any) -> str:
    numbers = [_number(v) for v in np.asarray(values, dtype=float).ravel().tolist()] or ["0"]
    lines = [", ".join(numbers[i : i + 6]) for i in range(0, len(numbers), 6)]
    return f"static const double {name}[{len(numbers)}] = {{" + ",\n  ".join(lines) + "};\n"


def _integers(name: str, values: Any) -> str:
    numbers = [str(int(v)) for v in np.asarray(values).ravel().tolist()] or ["0"]
    lines = [", ".join(numbers[i : i + 20]) for i in range(0, len(numbers), 20)]
    return f"static const int {name}[{len(numbers)}] = {{" + ",\n  ".join(lines) + "};\n"


def _texts(name: str, values: Sequence[str]) -> str:
    inside = ",\n  ".join(_text(v) for v in values) or "0"
    return f"static const char *const {name}[{max(len(values), 1)}] = {{{inside}}};\n"
