"""Flat models kept on disk: what a model of the same content was flattened to is read, and not found again.

See docs/performance.md. FOWTLIB_KEEP_FLAT=no switches it off. A model is flattened as always where it is small, where
not everything that it is made of can be known again (fingerprint), and where something was said on the way.
"""

from __future__ import annotations

import json
import os
import threading
import time
import warnings
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from fowtlib.flattening.assembler import flatten, flatten_with
from fowtlib.flattening.dae_record import Record, dae_of, record_of, values_now
from fowtlib.flattening.dimensions import DimensionReport, Finding, check_dimensions
from fowtlib.flattening.files_opened import files_opened
from fowtlib.flattening.fingerprint import bound_values, fingerprint
from fowtlib.flattening.flat_dae import FlatDAE
from fowtlib.flattening.hooks import Hooks, hooks_again
from fowtlib.flattening.instances import check_parameters
from fowtlib.flattening.own_code import Unknown
from fowtlib.flattening.scalar_graph import NotArithmetic
from fowtlib.language import cache_folder as store
from fowtlib.language.cache import cached
from fowtlib.language.component import Component
from fowtlib.language.data_files import files_of
from fowtlib.language.errors import ModelError, ParameterError, StructureError

SWITCH = "FOWTLIB_KEEP_FLAT"
FEW = 30  # parts; a smaller model is flattened in the time of reading it
_shown: dict[Any, Any] = {}


def switched_on() -> bool:
    """Whether flat models are kept; ParameterError where the environment variable says neither yes nor no."""
    word = os.environ.get(SWITCH, "yes").lower()
    if word not in ("yes", "no", "1", "0"):
        raise ParameterError(f"{SWITCH} is '{word}'; yes or no is expected.")
    return word in ("yes", "1")


def flat(root: Component, opened: Sequence[str] = ()) -> FlatDAE:
    """As `flatten`: from disk where a model of the same content was flattened before, with the same numbers."""
    if not switched_on() or sum(1 for _ in root.walk()) < FEW:
        return flatten(root, opened)
    store.limit()  # a wrong one is said before the work
    try:
        key, foreign = fingerprint(root, opened)
    except (Unknown, RecursionError):
        return flatten(root, opened)
    return _read(key, root, opened) or _made(key, root, opened, foreign)


def _read(key: str, root: Component, opened: Sequence[str]) -> FlatDAE | None:
    """The model that is kept; None where there is none, or none that can be read."""
    began = time.perf_counter()
    try:
        path = store.find(f"flat_{key}", "json")
        record = json.loads(path.read_bytes()) if path else None
    except (OSError, ValueError):
        return None
    if record is None:
        return None
    for component in root.walk():
        if any(declared.bound for declared in component.parameters.values()):
            check_parameters(component)  # the values of these are not in the key
    try:
        dae = dae_of(record, root, hooks_again(root, record["given_with"]), _values(key, record, root))
    except (ModelError, ValueError, KeyError, IndexError, TypeError, AttributeError, RuntimeError):
        return None

    def write_equations() -> list[tuple[str, str, str]]:
        if fingerprint(root, opened)[0] != key:
            raise StructureError("the model was changed after it was compiled; compile it again to see its equations.")
        return flatten(root, opened).equation_table

    stats = {**dae.stats, "flattening_time": time.perf_counter() - began}
    return replace(dae, write_equations=write_equations, stats=stats, key=key)


def _values(key: str, record: Record, root: Component) -> dict[str, Any]:
    """The values of the parameters in the tree; kept as well, as a rotor's steady operation takes long to find."""

    def found() -> dict[str, Any]:
        return values_now(record, root)

    try:
        return cached("values", [key, bound_values(root)], found)
    except (Unknown, RecursionError, OSError):
        return found()


def _made(key: str, root: Component, opened: Sequence[str], foreign: bool) -> FlatDAE:
    """The model flattened now, and kept if it can be."""
    if threading.current_thread() is not threading.main_thread():
        return flatten(root, opened)  # warnings are caught for all threads
    with warnings.catch_warnings(record=True) as said, files_opened(foreign) as read:
        warnings.simplefilter("always")
        dae, instances = flatten_with(root, opened)
    for item in said:
        warnings.warn_explicit(item.message, item.category, item.filename, item.lineno, registry=_shown)
    if said or not read <= {os.path.realpath(file) for file in files_of(root).values()}:
        return dae
    try:
        hooks = Hooks.of(instances.system, instances.statements)
        _keep(f"flat_{key}", {**record_of(dae, hooks), "given_with": instances.given_with})
    except (NotArithmetic, ValueError, OSError):
        pass
    return replace(dae, key=key)


def dimensions_of(root: Component, dae: FlatDAE) -> DimensionReport:
    """The dimension check of the model that was flattened to `dae`; its report is kept as well."""
    if not dae.key:
        return check_dimensions(root)

    def found() -> list[Any]:
        report = check_dimensions(root)
        return [report.equations, [[item.path, item.source, item.text] for item in report.findings]]

    equations, findings = cached("dimensions", [dae.key], found)
    return DimensionReport(equations, [Finding(*item) for item in findings])


def _keep(name: str, record: Record) -> None:
    text = json.dumps(record, default=lambda value: value.item())
    with store.workshop() as folder:
        fresh = folder / "fresh.json"
        fresh.write_text(text, encoding="utf-8")
        store.keep(name, "json", fresh)
    store.prune()
