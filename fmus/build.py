"""Build the FMUs of the recipes into fmus/built, and check each one in fmpy.

python fmus/build.py [NAME ...]      all recipes, or those named; exit status 1 when a check fails

Checked: the archive is valid and below 5 MB; co-simulation, and model exchange where the recipe asks for it, give what
fowtlib gives in this process; the figures expected by the recipe come out.
"""

from __future__ import annotations

import argparse
import shutil
import sys
import time
import warnings
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any

import numpy as np
import yaml

try:
    import fmpy
    from fmpy.simulation import instantiate_fmu
    from fmpy.validation import validate_fmu
except ModuleNotFoundError:
    sys.exit("FMUs are checked by fmpy, which is missing: pip install '.[fmi]'")

import fowtlib as fw
from fowtlib.cli import loading
from fowtlib.language.errors import ModelError
from fowtlib.language.units import from_si, to_si

HERE = Path(__file__).parent
BUILT = HERE / "built"
LARGEST = 5e6
"""Bytes of an archive."""


@dataclass
class Recipe:
    """What is exported and how, and what must come out.

    time: length of the runs [s]; same_within: largest difference from fowtlib, relative to the largest value.
    model_exchange: {time, same_within} of a run by CVode against IDAS.
    expected: results with `value` (with its unit), `within` (a share, or a value with its unit), `from` (the source);
    the mean of the last `over` seconds is compared.
    """

    name: str
    model: str
    time: float
    same_within: float
    expected: list[dict[str, Any]]
    about: str = ""
    fmi: str = "3"
    kind: str = "both"
    step: Any = None
    wind: str | None = None
    waves: str | None = None
    inputs: list[str] = field(default_factory=list)
    set: dict[str, Any] = field(default_factory=dict)
    model_exchange: dict[str, float] | None = None

    @classmethod
    def read(cls, path: Path) -> Recipe:
        """The recipe of a file; a model file is named relative to it."""
        data = yaml.safe_load(path.read_text(encoding="utf-8"))
        keys = {item.name for item in fields(cls)} - {"name"}
        if unknown := set(data) - keys:
            raise ModelError(f"{path}: a recipe has no '{sorted(unknown)[0]}'; it has {', '.join(sorted(keys))}.")
        if missing := {"model", "time", "same_within", "expected"} - set(data):
            raise ModelError(f"{path}: the recipe lacks '{sorted(missing)[0]}'.")
        if data["model"].endswith(".yaml"):
            data["model"] = str((path.parent / data["model"]).resolve())
        return cls(path.stem, **{**data, "fmi": str(data.get("fmi", "3"))})

    def plant(self) -> Any:
        """The compiled model, with the wind, the waves and the parameters of the recipe."""
        settings = [f"{path}={value}" for path, value in self.set.items()]
        given = {"model": self.model, "wind": self.wind, "waves": self.waves}
        return loading.load(argparse.Namespace(**given, settings=settings, allow_python=False)).compile(self.inputs)

    def build(self, folder: Path = BUILT, plant: Any = None) -> Path:
        """Export the model into the folder."""
        folder.mkdir(exist_ok=True)
        path = folder / f"{self.name}.fmu"
        return fw.export_fmu(plant or self.plant(), path, fmi=self.fmi, kind=self.kind, step=self.step)


class Check:
    """One FMU against its recipe; `rows` are what was looked at, as (what, found, expected, is it so)."""

    def __init__(self, recipe: Recipe, folder: Path = BUILT):
        self.recipe, self.plant = recipe, recipe.plant()
        self.path = recipe.build(folder, self.plant)
        self.rows: list[tuple[str, str, str, bool]] = []

    def run(self) -> Check:
        """All checks."""
        recipe, self.rows = self.recipe, []
        problems = validate_fmu(str(self.path))
        self._add("valid", "; ".join(problems) or "yes", "yes", not problems)
        size = self.path.stat().st_size
        self._add("size of the archive", f"{size / 1e6:.2f} MB", f"< {LARGEST / 1e6:.0f} MB", size < LARGEST)
        self.unpacked = fmpy.extract(str(self.path))
        try:
            self.described = fmpy.read_model_description(self.unpacked)
            self._add("instantiated in", f"{self._instantiation():.2f} s of processor time", "", True)
            if recipe.kind != "me":
                rows = self._simulate("CoSimulation", recipe.time)
                self._compare("co-simulation", rows, self._native(recipe.time, "fixed"), recipe.same_within)
                self._expected(rows)
            if wanted := recipe.model_exchange:
                rows = self._simulate("ModelExchange", wanted["time"])
                self._compare("model exchange", rows, self._native(wanted["time"], "idas"), wanted["same_within"])
        finally:
            shutil.rmtree(self.unpacked)
        return self

    @property
    def passed(self) -> bool:
        """True when everything is as expected."""
        return all(row[-1] for row in self.rows)

    def _add(self, what: str, found: str, expected: str, good: bool) -> None:
        self.rows.append((what, found, expected, good))

    def _instantiation(self) -> float:
        begun = time.process_time()
        kind = "ModelExchange" if self.recipe.kind == "me" else "CoSimulation"
        fmu = instantiate_fmu(self.unpacked, self.described, kind)
        needed = time.process_time() - begun
        fmu.freeInstance()
        return needed

    def _simulate(self, kind: str, duration: float) -> np.ndarray:
        more = {"record_events": False, "relative_tolerance": 1e-8} if kind == "ModelExchange" else {}
        wanted = [v.name for v in self.described.modelVariables if v.causality == "output"]
        return fmpy.simulate_fmu(
            self.unpacked, model_description=self.described, fmi_type=kind, stop_time=duration,
            output_interval=self._interval(), output=wanted, **more,
        )  # fmt: skip

    def _interval(self) -> float:
        return float(self.described.defaultExperiment.stepSize)

    def _native(self, duration: float, solver: str) -> Any:
        options = {"step": self.recipe.step} if solver == "fixed" else {"tolerance": 1e-8}
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)  # the FMU says the same
            return self.plant.simulate(duration, self._interval(), solver=solver, **options)

    def _compare(self, what: str, rows: np.ndarray, native: Any, within: float) -> None:
        """The largest difference of any result, relative to its largest value, which counts as 0.001 (SI) at least."""
        worst, where = -1.0, ""
        for name in self.plant.outputs:
            path, unit, _ = self.plant.outputs[name]
            factor = from_si(1.0, self.plant.describe(path)[0], unit)
            values = np.asarray(native[name]) / factor
            elements = {name: values} if values.ndim == 1 else {f"{name}[{i}]": v for i, v in enumerate(values.T)}
            scale = max(np.max(np.abs(values)), 1e-3)
            for element, reference in elements.items():
                difference = np.max(np.abs(rows[element] - reference)) / scale
                if not difference <= worst:  # also when it is not a number
                    worst, where = difference, element
        self._add(f"{what}, {rows['time'][-1]:g} s", f"{worst:.1e} ({where})", f"< {within:g}", bool(worst < within))

    def _expected(self, rows: np.ndarray) -> None:
        for item in self.recipe.expected:
            path, unit, _ = self.plant.outputs[item["result"].partition("[")[0]]
            si = self.plant.describe(path)[0]
            late = rows["time"] >= rows["time"][-1] - item["over"] - 1e-9
            found = float(np.mean(rows[item["result"]][late]))
            value, within = to_si(item["value"], si, "value"), item["within"]
            allowed = within * abs(value) if isinstance(within, float) else to_si(within, si, "within")
            text = f"{item['value']} +- {within if isinstance(within, str) else f'{100 * within:g} %'}"
            shown = f"{from_si(found, si, unit):.5g} {unit}"
            self._add(item["result"], shown, f"{text} ({item['from']})", abs(found - value) <= allowed)


def main(names: list[str]) -> int:
    """Build and check; the exit status."""
    files = {path.stem: path for path in sorted((HERE / "recipes").glob("*.yaml"))}
    if unknown := [name for name in names if name not in files]:
        print(f"there is no recipe '{unknown[0]}'; there are {', '.join(files)}.", file=sys.stderr)
        return 2
    failed = []
    for name in names or files:
        print(f"{name}: building", flush=True)
        try:
            check = Check(Recipe.read(files[name])).run()
        except Exception as error:  # one FMU that fails does not keep the others from being checked
            print(f"  FAILED: {type(error).__name__}: {error}\n", flush=True)
            failed.append(name)
            continue
        width = max(len(row[0]) for row in check.rows)
        for what, found, expected, good in check.rows:
            print(f"  {'ok  ' if good else 'FAIL'}  {what:{width}}  {found:32}  {expected}".rstrip(), flush=True)
        print()
        if not check.passed:
            failed.append(name)
    print(f"failed: {', '.join(failed)}" if failed else f"all is as expected; the archives are in {BUILT}")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
