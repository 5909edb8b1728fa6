"""The sections of the report of a batch, each from what it sees of the batch."""

from __future__ import annotations

import platform
import shlex
import sys
from importlib.metadata import version
from typing import Any

import numpy as np

from fowtlib.analysis import Spectrum, average, lifetime_equivalent_load, power_spectrum, ultimate_loads
from fowtlib.language.errors import ModelError
from fowtlib.report import drawings
from fowtlib.report.content import Link, Section, Table, anchor, drawn, number
from fowtlib.report.view import View, words

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
            told = view.channels[row.name].get(name)
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
    weights = np.array([row.case.weight for row in view.done])
    rows = []
    for name in view.units:
        told = [view.channels[row.name].get(name) for row in view.done]
        held = np.array([item is not None for item in told])
        shares = weights[held] / weights[held].sum() if weights[held].sum() > 0 else np.full(held.sum(), 1 / held.sum())
        mean, std = (np.array([item[key] for item in told if item]) for key in ("mean", "std"))
        overall = float(shares @ mean)
        within, total = (float(np.sqrt(shares @ values)) for values in (std**2, std**2 + (mean - overall) ** 2))
        rows.append([name, view.units[name], overall, within, total, float(std.max()), int(held.sum())])
    heads = ["result", "unit", "mean", "deviation within cases", "deviation of all", "largest deviation", "cases"]
    sentence = "Each case counts by its weight; the deviation within cases is about the mean of each."
    return Section("Statistics", [sentence], tables=[Table(heads, rows)])


def extremes(view: View) -> Section:
    """The largest and least value of each result, and the case; with the safety factor for loads."""
    rows = []
    for name in view.judged:
        high, low = view.extreme(name, "max"), view.extreme(name, "min")
        if high is None or low is None:
            continue
        worst = view.worst(name)
        place = f"worst-{anchor(name)}" if name in view.shown and view.batch.path(worst[0].name) else None
        factored = [told[end] * row.case.safety_factor for (row, told), end in ((high, "max"), (low, "min"))]
        design = max(factored, key=abs) if name in view.loads else None
        rows.append([
            Link(name, place) if place else name, view.units[name],
            high[1]["max"], Link(high[0].name, case_anchor(high[0].name)), high[1].get("max_time"),
            low[1]["min"], Link(low[0].name, case_anchor(low[0].name)), low[1].get("min_time"), design,
        ])  # fmt: skip
    heads = ["result", "unit", "largest", "in case", "at [s]", "least", "in case", "at [s]", "times safety factor"]
    sentence = "A name leads to the series around the extreme. Loads are multiplied by the safety factor of the case."
    return Section("Extremes", [sentence], tables=[Table(heads, rows)])


def fatigue(view: View) -> Section | None:
    """Damage-equivalent loads: of the life by the weights of the cases, and for each value of the label."""
    rows, places = [], view.places()
    weights = np.array([row.case.weight for row in view.done])
    shares = weights / weights.sum() if weights.sum() > 0 else np.full(len(weights), 1 / len(weights))
    for name in view.loads:
        kept = [view.all[row.name].get("equivalent_loads", {}).get(name) for row in view.done]
        if any(loads is None for loads in kept):
            continue
        for exponent in kept[0]:
            loads = np.array([loads[exponent] for loads in kept])
            m = float(exponent)
            by_place = [float(np.mean(loads[inside] ** m) ** (1 / m)) for inside in places.values()]
            rows.append([name, view.units[name], m, lifetime_equivalent_load(loads, m, shares), *by_place])
    if not rows:
        return None
    heads = ["load", "unit", "exponent m", "all cases by weight", *places]
    sentence = ("Ranges at 1 Hz, by rainflow counting. The weights of the cases count as shares of the time; the load "
                "of one value is the mean over its cases.")  # fmt: skip
    return Section("Damage-equivalent loads", [sentence], tables=[Table(heads, rows)])


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
        row, told, end = view.worst(name)
        path = view.batch.path(row.name)
        if path is None:
            continue
        result = view.batch.result(row.name)
        at = told.get(f"{end}_time")
        if at is None:
            values = result.array(name)
            at = float(result.time[int(values.argmax() if end == "max" else values.argmin())])
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
    groups = view.groups()
    section = Section("Spectra")
    results = {row.name: view.batch.result(row.name) for rows in groups.values() for row in rows}
    for name in view.shown if results else ():
        found: dict[str, Spectrum] = {}
        for key, rows in groups.items():
            singles = [single for row in rows if (single := _spectrum(results[row.name], name)) is not None]
            same = [single for single in singles if single.frequency.shape == singles[0].frequency.shape]
            if same:
                found[key] = average(same)
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


def _spectrum(result: Any, name: str) -> Spectrum | None:
    """Of a result; None where it is too short or its points are not equally spaced."""
    if name not in result.names:
        return None
    span = float(result.time[-1] - result.time[0])
    try:
        return power_spectrum(result[name], segment=2 * span / (SEGMENTS + 1))
    except ModelError:
        return None
