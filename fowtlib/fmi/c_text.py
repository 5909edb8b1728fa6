"""The C text of a model for an FMU: its functions, its tables, and the code of its external functions."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path

import casadi as ca

from fowtlib.flattening import FlatDAE
from fowtlib.fmi.c_tables import Tables, column, libraries
from fowtlib.fmi.variables import Variables
from fowtlib.language.errors import CompilerError, StructureError
from fowtlib.language.externals import LibraryFunction
from fowtlib.language.native import EXPORT
from fowtlib.language.processor import processor_text
from fowtlib.language.tables import SplineFunction
from fowtlib.solving.engines import fixed_step
from fowtlib.solving.engines.c_lanes import ANY_PROCESSOR, WIDE, in_wide_vectors, prologue
from fowtlib.solving.engines.c_text import Program, c_program
from fowtlib.solving.engines.fixed_step_code import OUT, kept_text
from fowtlib.solving.engines.reduction import reduction
from fowtlib.solving.engines.turning_frames import turning_frames
from fowtlib.solving.state import State

HIDDEN = """#if defined(__GNUC__) && !defined(_WIN32)
#define EXPORT __attribute__((visibility("hidden")))
#else
#define EXPORT
#endif
"""
"""What stands behind EXPORT is hidden from other libraries, whatever the flags of who compiles the sources: a function
named `starts` or `wind` could else be taken from another library of the same process."""


WIDE_EQUATIONS = """typedef void (*equation)(const double *t, const double *x, const double *z, const double *q,
                         const double *w, double *first, double *second, double *scratch);
static const equation inputs_of_levels[] = {{{inputs}0}};

/* What is to be called instead of equations.c on a processor that has these vectors; it gives the same numbers. */
EXPORT void wide_equations(const equation **inputs, equation *residual, const equation **all_pieces) {{
  if (widest() < 4) return;
  *inputs = inputs_of_levels;
  *residual = model;
  *all_pieces = pieces;
}}
#else
EXPORT void wide_equations(const void *inputs, const void *residual, const void *all_pieces) {{
  (void)inputs, (void)residual, (void)all_pieces;
}}
#endif
"""


@dataclass
class Sources:
    """Files of the folder sources/, which of them are compiled with which optimization, and the resources."""

    files: dict[str, str] = field(default_factory=dict)
    units: list[tuple[str, str]] = field(default_factory=list)  # file, optimization
    tables: bytes = b""
    resources: dict[str, Path] = field(default_factory=dict)


def c_sources(variables: Variables, start: State, interface: int, identity: tuple[str, str]) -> Sources:
    """All C text of an FMU; interface: 2 or 3; identity: name of the model and its token."""
    dae, sources = variables.plant.dae, Sources()
    refuse_python(dae)
    functions, equations, program, scratch = _functions(variables, dae)
    sources.files["model.c"] = _shortened(functions)
    sources.files["equations.c"] = _shortened(equations)
    sources.files["equations_wide.c"] = _wide_equations(equations, len(dae.levels))
    tables = Tables(variables, start, program, scratch, identity)
    sources.files["tables.h"] = tables.text()
    sources.tables = tables.packed()
    sources.resources = tables.resources
    solving, here = Path(fixed_step.__file__).parent, Path(__file__).parent
    parts = ("spline.c", "fixed_step.c", "fmu.h", "tables.h", "fmu_core.c", f"fmi{interface}.c")
    for name in parts:
        if name != "tables.h":
            folder = solving if name in ("spline.c", "fixed_step.c") else here
            sources.files[name] = (folder / name).read_text(encoding="utf-8")
    includes = "".join(f'#include "{part}"\n' for part in parts)
    sources.files["fmu.c"] = f"#define EXPORT static\n{includes}"
    sources.units = [("fmu.c", "-O3"), *((f"{unit}.c", "-O1") for unit in ("model", "equations", "equations_wide"))]
    by_path = {function.path: function for function in libraries(dae).values()}
    for number, function in enumerate(by_path.values()):
        sources.files[f"external_{number}.c"] = _source_of(function)
        sources.units.append((f"external_{number}.c", "-O2"))
    return sources


def _shortened(text: str) -> str:
    return "#define D const double\n" + text.replace("  const double a", "  D a")


def _wide_equations(equations: str, levels: int) -> str:
    """C text: the equations once more, for processors with AVX2, under other names; see `wide_equations` in it."""
    inputs, seen = [f"level_{k}" for k in range(levels)], re.findall(r"EXPORT void (\w+)\(", equations)
    renamed = "".join(f"#define {name} wide_{name}\n" for name in [*seen, "pieces"])
    return "".join([
        "/* The equations in wider vectors than every processor has, for those that have them. */\n", HIDDEN,
        processor_text(), "#if defined(VECTORS) && defined(__x86_64__)\n", renamed,
        in_wide_vectors('#include "equations.c"\n'),
        WIDE_EQUATIONS.format(inputs="".join(f"{name}, " for name in inputs)),
    ])  # fmt: skip


def refuse_python(dae: FlatDAE) -> None:
    """StructureError where a part of the model is Python code, or a process of its own."""
    for sample in dae.samples:
        if sample.process is not None:
            raise StructureError(
                f"{sample.path or 'the model'}: what is called at its samples runs outside of the equations, and "
                "cannot go into an FMU. Leave the part out, and give its outputs as inputs of the FMU (--input)."
            )
    for external in dae.externals:
        if not isinstance(external.function, SplineFunction | LibraryFunction):
            raise StructureError(
                f"{external.path or 'the model'}: the external function {external.function.name()} is Python code, "
                "which cannot go into an FMU. Give it a C source or a shared library with its source beside it."
            )


def _source_of(function: LibraryFunction) -> str:
    """The C text of a library, or what lies beside it; what it exports is hidden inside of the FMU."""
    if function.source is not None:
        return HIDDEN + function.source
    source = function.path.with_suffix(".c")
    if not source.is_file():
        raise CompilerError(
            f"the external function of the library {function.path} cannot go into an FMU: its source {source} is not "
            "there."
        )
    return HIDDEN + source.read_text(encoding="utf-8").removeprefix(EXPORT)


def _functions(variables: Variables, dae: FlatDAE) -> tuple[str, str, Program, int]:
    """C text of what importers ask for, and its derivatives along a direction; the engine's, its program; scratch."""
    text, program, scratch = kept_text(dae, reduction(dae), variables.observed, turning_frames(dae), WIDE)
    q = ca.vertcat(dae.u, dae.d, dae.p)
    arguments = [dae.t, dae.x, dae.z, q, dae.w]
    checks = ca.vertcat(*[check.condition for check in dae.checks])
    told = ca.vertcat(*[value for check in dae.checks for value in check.values.values()])
    outputs, indicators = column(variables.output_expressions), column([e.indicator for e in dae.events])
    starts = column([q.start for group in (dae.states, dae.algebraics, dae.discretes) for q in group])
    clocks = column([*(s.period for s in dae.samples), *(s.offset for s in dae.samples)])
    initials = ca.densify(dae.initial_equations)
    plain: list[tuple[str, list[ca.SX]]] = [
        ("indicators", [indicators]), ("checks", [checks, told]), ("starts", [starts]), ("clocks", [clocks]),
        ("initials", [initials]),
        *((f"action_{k}", [e.state_values, e.discrete_values]) for k, e in enumerate(dae.events)),
    ]  # fmt: skip
    seeds = [ca.SX.sym(f"d{name}", value.shape[0]) for name, value in zip("xzqw", arguments[1:], strict=True)]
    moved: list[tuple[str, list[ca.SX]]] = [
        *((f"forward_level_{k}", [inputs]) for k, inputs in enumerate(dae.level_inputs)),
        ("forward_model", [dae.ode, dae.alg]), ("forward_outputs", [outputs, indicators]),
        ("forward_initials", [initials]),
    ]  # fmt: skip
    along, direction = ca.vertcat(*arguments[1:]), ca.vertcat(*seeds)
    slopes = [(name, [ca.jtimes(ca.densify(e), along, direction) for e in expressions]) for name, expressions in moved]
    texts = [HIDDEN, prologue(ANY_PROCESSOR)]
    for inside, names, functions in (
        (arguments, [*"txzqw"], plain), ([*arguments, *seeds], [*"txzqw", "dx", "dz", "dq", "dw"], slopes)
    ):  # fmt: skip
        for name, expressions in functions:
            function = ca.Function(name, inside, [ca.densify(e) for e in expressions], {"cse": True})
            alone = c_program(function, [(name, OUT[: len(expressions)])], names, OUT)
            texts.append(alone.text)
            scratch = max(scratch, alone.scratch)
    return "".join(texts), HIDDEN + text, program, scratch
