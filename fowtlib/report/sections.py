"""The sections of the report of a batch, each from what it sees of the batch."""

from __future__ import annotations

import platform
import shlex
import sys
from importlib.metadata import version
from typing import Any

import numpy as np

from fowtlib.analysis import (
    Spectrum,
    average,
    lifetime_equivalent_load,
    over_cases,
    power_spectrum,
    ultimate_loads,
)
from fowtlib.language.errors import ModelError
from fowtlib.report import drawings
from fowtlib.report.content import Cell, Link, Section, Table, anchor, drawn, number
from fowtlib.report.view import ENDS, View, words

AROUND = 60.0  # s before and after an extreme
HIGHEST = 0.5  # Hz in spectra
MOST_IN_MATRIX = 12  # loads in the ultimate load matrix
SEGMENTS = 4  # of a record, for its spectrum


def cases(view: View) -> Section:
    """What was run."""
    labels = list(dict.fromkeys(key for row in view.rows for key in row.case.labels))
    rows = [
        [row.name, row.case.group, *(row.case.labels.get(key) for key in labels), row.simulated, row.seconds,
         row.case.weight, row.case.safety_factor, row.state]
        for row in view.rows
    ]  # fmt: skip
    heads = ["case", "group", *labels, "simulated [s]", "took [s]", "weight", "safety factor", "state"]
    table = Table(heads, rows, folded=f"All {len(rows)} cases", anchors=[case_anchor(row.name) for row in view.rows])
    spans = []
    for key in labels:
        values = [row.case.labels[key] for row in view.rows if key in row.case.labels]
        if all(isinstance(value, (int, float)) for value in values):
            spans.append(f"{key} {min(values):g} to {max(values):g} ({len(set(values))} values)")
    return Section("What was run", [f"The cases differ in {'; '.join(spans)}."] if spans else [], tables=[table])


def over_the_label(view: View) -> Section | None:
    """Operating curves."""
    if not view.label:
        return None
    section = Section(f"Results over {words(view.label)}")
    section.sentences = ["Dots are means of the cases, bars reach from the least to the largest value of each, and "
                         "the line joins the means over all cases of one value."]  # fmt: skip
    for name in view.shown:
        groups: dict[str, list[list[float]]] = {}
        for row in view.done:
            told = row.statistics.get(name)
            if told and np.isfinite(view.label_of(row)):
                entry = [view.label_of(row), told["mean"], told["min"], told["max"]]
                groups.setdefault(row.case.group, []).append(entry)
        arrays = {group: np.array(entries) for group, entries in groups.items()}
        if not arrays:
            continue
        everything, unit = np.concatenate(list(arrays.values())), view.units[name]
        places = np.unique(everything[:, 0])
        means = np.array([everything[everything[:, 0] == place, 1].mean() for place in places])
        top = int(means.argmax())
        caption = (f"{words(name)}: the mean over cases is largest at {words(view.label)} {places[top]:g}, "
                   f"{number(means[top])} {unit}, and least at {places[int(means.argmin())]:g}, "
                   f"{number(means.min())} {unit}.")  # fmt: skip
        picture = drawings.over_label(words(name), unit, view.label_words, arrays)
        section.figures.append(drawn(picture, caption, f"over-{anchor(name)}"))
    return section


def statistics(view: View) -> Section:
    """Mean and deviation over all cases, by weight."""
    rows = []
    for name in view.units:
        having = {row.name: row for row in view.done if name in row.statistics}
        weights = {key: row.case.weight for key, row in having.items()}
        kept = {key: {"channels": {name: row.statistics[name]}} for key, row in having.items()}
        told = over_cases(kept, weights if any(weights.values()) else None)[name]
        largest = max(row.statistics[name]["std"] for row in having.values())
        rows.append([name, told["unit"], told["mean"], told["std"], told["total_std"], largest, told["cases"]])
    heads = ["result", "unit", "mean", "deviation within cases", "deviation of all", "largest deviation", "cases"]
    sentence = "Each case counts by its weight; the deviation within cases is about the mean of each."
    return Section("Statistics", [sentence], tables=[Table(heads, rows)])


def extremes(view: View) -> Section:
    """The largest and least value of each result, and the case; with the safety factor for loads."""
    rows = []
    for name in view.judged:
        ends = {end: view.extreme(name, end) for end in ENDS}
        place = f"worst-{anchor(name)}" if name in view.shown and view.worst(name)[0].name in view.kept else None
        factored = [row.statistics[name][end] * row.case.safety_factor for end, row in ends.items()]
        told: list[Cell] = []
        for end, row in ends.items():
            found = row.statistics[name]
            told += [found[end], Link(row.name, case_anchor(row.name)), found[f"{end}_time"]]
        rows.append([Link(name, place) if place else name, view.units[name], *told,
                     max(factored, key=abs) if name in view.loads else None])  # fmt: skip
    heads = ["result", "unit", "largest", "in case", "at [s]", "least", "in case", "at [s]", "times safety factor"]
    sentence = "A name leads to the series around the extreme. Loads are multiplied by the safety factor of the case."
    return Section("Extremes", [sentence], tables=[Table(heads, rows)])


def fatigue(view: View) -> Section | None:
    """Damage-equivalent loads: of the life by the weights of the cases, and for each value of the label."""
    counted = [row for row in view.done if row.case.weight] or view.done  # others stand for no time
    weights = np.array([row.case.weight for row in counted])
    shares = weights / max(weights.sum(), 1.0) if weights.any() else equal(len(weights))
    places, rows = view.places(counted), []
    for name in view.loads:
        kept = [view.all[row.name].get("equivalent_loads", {}).get(name) for row in counted]
        if any(loads is None for loads in kept):
            continue
        for exponent in kept[0]:
            loads, m = np.array([loads[exponent] for loads in kept]), float(exponent)
            at = [lifetime_equivalent_load(loads[inside], m, equal(inside.sum())) for inside in places.values()]
            rows.append([name, view.units[name], m, lifetime_equivalent_load(loads, m, shares), *at])
    if not rows:
        return None
    heads = ["load", "unit", "exponent m", "all cases by weight", *places]
    sentence = ("Ranges at 1 Hz, by rainflow counting. The weights of the cases count as shares of the time; the load "
                "of one value is the mean over its cases.")  # fmt: skip
    return Section("Damage-equivalent loads", [sentence], tables=[Table(heads, rows)])


def equal(count: int) -> np.ndarray:
    """Equal shares of so many cases."""
    return np.full(count, 1 / count)


def ultimate(view: View) -> Section | None:
    """The ultimate load matrix, with safety factors and what acts at the same time."""
    channels = view.loads[:MOST_IN_MATRIX]
    having = [row for row in view.done if all(name in row.statistics for name in channels)]
    if not channels or not having:
        return None
    found = ultimate_loads(
        {row.name: view.all[row.name] for row in having}, channels,
        {row.name: row.case.safety_factor for row in having},
        load_cases={row.name: row.case.group or row.name for row in having},
    )  # fmt: skip
    rows = [
        [row.extreme, row.load_case, row.safety_factor, *row.values, Link(row.case, case_anchor(row.case)), row.time]
        for row in found.rows
    ]
    heads = ["extreme", "group", "safety factor",
             *(f"{name} [{unit}]" for name, unit in zip(found.channels, found.units, strict=True)),
             "case", "at [s]"]  # fmt: skip
    sentence = "Each row has the extreme of one load over all cases and the other loads at the same time, all factored."
    return Section("Ultimate loads", [sentence], tables=[Table(heads, rows)])


def worst_cases(view: View) -> Section | None:
    """Series around the extremes of the results that are shown."""
    section = Section("Worst cases")
    causes = [name for name in ("wind_speed", "wave_elevation") if name in view.units]
    for name in view.shown:
        row, end = view.worst(name)
        if row.name not in view.kept:
            continue
        result, told = view.batch.result(row.name), row.statistics[name]
        at = told[f"{end}_time"]
        near = np.abs(result.time - at) <= AROUND
        rows = [
            (words(item), result.unit(item), result.array(item)[near])
            for item in dict.fromkeys([name, *causes]) if item == name or item in result.names
        ]  # fmt: skip
        which, value = "largest" if end == "max" else "least", f"{number(told[end])} {view.units[name]}"
        caption = f"{words(name)}: {which} value {value} at {at:.1f} s of the case {row.name}."
        picture = drawings.around(result.time[near], rows, at)
        section.figures.append(drawn(picture, caption, f"worst-{anchor(name)}", wide=True))
    return section if section.figures else None


def spectra(view: View) -> Section | None:
    """Mean spectra of the cases with equal label."""
    section = Section("Spectra")
    by_name: dict[str, dict[str, Spectrum]] = {name: {} for name in view.shown}
    for key, rows in view.groups().items():
        singles: dict[str, list[Spectrum]] = {name: [] for name in view.shown}
        for row in rows:
            result = view.batch.result(row.name)
            for name, found in singles.items():
                found += _spectrum(result, name)
        for name, found in singles.items():
            same = [single for single in found if single.frequency.shape == found[0].frequency.shape]
            if same:
                by_name[name][key] = average(same)
    for name, found in by_name.items():
        if not found:
            continue
        key, spectrum = max(found.items(), key=lambda item: item[1].std)
        f = spectrum.frequency[1:][int(spectrum.density[1:].argmax())]
        deviation = f"{number(spectrum.std)} {view.units[name]}"
        caption = (f"{words(name)}: most motion at {key}, with a deviation of {deviation} and the peak at {f:.3g} Hz, "
                   f"a period of {1 / f:.3g} s.")  # fmt: skip
        picture = drawings.spectra(words(name), view.units[name], found, HIGHEST)
        section.figures.append(drawn(picture, caption, f"spectrum-{anchor(name)}"))
    section.sentences = [f"One-sided densities (Welch, {SEGMENTS} segments), mean over the cases of one value."]
    return section if section.figures else None


def failures(view: View) -> Section | None:
    """What failed, in its own words."""
    rows = [[row.name, row.message or "no message", row.simulated] for row in view.failed]
    rows += [[row.name, f"warning: {line}", row.simulated] for row in view.done for line in row.warnings.splitlines()]
    if not rows:
        return None
    return Section("Failures and warnings", tables=[Table(["case", "what was said", "simulated [s]"], rows)])


def provenance(view: View, command: str) -> Section:
    """By what the numbers were made, and how to make them again."""
    packages = ", ".join(f"{name} {version(name)}" for name in ("fowtlib", "casadi", "numpy", "scipy"))
    about = view.batch.about
    rows = [
        ["folder", str(view.batch.folder.resolve())],
        *([["cases from", str(about["source"])]] if about.get("source") else []),
        ["software", f"{packages}, Python {platform.python_version()} on {platform.system()} {platform.machine()}"],
        ["run by fowtlib", str(about.get("fowtlib_version", ""))],
        ["this page by", command or shlex.join(["fowt", *sys.argv[1:]])],
    ]
    files = sorted({(path, digest) for row in view.done for path, digest in row.files.items()})
    tables = [Table(["", ""], rows)]
    if files:
        tables.append(Table(["file", "digest"], [list(item) for item in files],
                            folded=f"The {len(files)} files that the results depend on"))  # fmt: skip
    return Section("Provenance", tables=tables)


def case_anchor(name: str) -> str:
    """Where the row of a case is."""
    return f"case-{anchor(name)}"


def _spectrum(result: Any, name: str) -> list[Spectrum]:
    """Of a result; none where it is too short or its points are not equally spaced."""
    if name not in result.names:
        return []
    span = float(result.time[-1] - result.time[0])
    try:
        return [power_spectrum(result[name], segment=2 * span / (SEGMENTS + 1))]
    except ModelError:
        return []
