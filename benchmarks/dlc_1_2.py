"""Tables of docs/dlc_1_2.md, DLC 1.2 of the flexible spars, from the folders of their batches; commands: there."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from pages import fill, markdown

import fowtlib as fw
from fowtlib.cases import Batch

PAGE = Path(__file__).parents[1] / "docs" / "dlc_1_2.md"
MEANS = (("generator_power", "mean", "power [kW]"), ("surge", "mean", "surge [m]"),
         ("pitch", "std", "pitch, std [deg]"), ("yaw", "std", "yaw, std [deg]"))  # fmt: skip
LOADS = (("tower_base_fore_aft_moment", "4", "tower base fore-aft"), ("tower_base_side_side_moment", "4", "side-side"),
         ("blade_root_flapwise_moment_1", "10", "blade flapwise"), ("blade_root_edgewise_moment_1", "10", "edgewise"),
         ("arm_root_vertical_moment", "4", "arm root vertical"), ("fairlead_tension_2", "4", "fairlead 2"))  # fmt: skip


def tables(batch: Batch) -> str:
    """What was run, statistics and equivalent loads over the wind speed."""
    rows = batch.rows("done")
    speeds = sorted({row.case.labels["wind_speed"] for row in rows})
    kept = {row.name: batch.statistics(row.name) for row in rows}
    names = list(kept[rows[0].name]["channels"])
    at = {speed: [row for row in rows if row.case.labels["wind_speed"] == speed] for speed in speeds}

    def one(start: str) -> str:
        return next((name for name in names if name.startswith(start)), "")

    def mean(name: str, what: str, members: list) -> float:
        values = np.array([kept[row.name]["channels"][name][what] for row in members])
        return float(np.sqrt((values**2).mean())) if what == "std" else float(values.mean())

    shown = [(one(start), what, title) for start, what, title in MEANS if one(start)]
    first = ("wind [m/s]", *(title for *_, title in shown)), [
        [f"{speed:g}", *(f"{mean(name, what, members):.4g}" for name, what, _ in shown)]
        for speed, members in at.items()
    ]
    loads = [(one(start), m, title) for start, m, title in LOADS if one(start)]
    weights = np.array([row.case.weight for row in rows])
    body = []
    for speed, members in at.items():
        found = [[kept[row.name]["equivalent_loads"][name][m] for row in members] for name, m, _ in loads]
        equal = np.full(len(members), 1 / len(members))
        body.append([f"{speed:g}", *(_load(fw.lifetime_equivalent_load(values, float(m), equal), name)
                                     for values, (name, m, _) in zip(found, loads, strict=True))])  # fmt: skip
    life = [
        fw.lifetime_equivalent_load([kept[row.name]["equivalent_loads"][name][m] for row in rows], float(m), weights)
        for name, m, _ in loads
    ]
    body.append(["life", *(_load(value, name) for value, (name, *_) in zip(life, loads, strict=True))])
    heads = ("wind [m/s]", *(f"{title}, m = {m} [{'kN' if 'tension' in name else 'MN m'}]" for name, m, title in loads))
    spent, simulated = sum(row.processor for row in rows), sum(row.simulated for row in rows)
    worker = {row.worker for row in rows}
    told = (f"{len(rows)} cases, {simulated / 3600:.2f} h simulated in {spent / 60:.1f} min of processor time: "
            f"{simulated / spent:.0f} simulated seconds per second of one core, with fields, starts and statistics; "
            f"{len(worker)} workers.")  # fmt: skip
    return f"{told}\n\n{markdown(first)}\n\n{markdown((heads, body))}"


def _load(value: float, name: str) -> str:
    return f"{value:.4g}" if "tension" in name else f"{value / 1e6:.4g}"


def main() -> None:
    """Fill the page from the folders that are named."""
    page = PAGE.read_text(encoding="utf-8")
    for name, folder in zip(("one rotor", "two rotors"), sys.argv[1:], strict=False):
        page = fill(page, name, tables(Batch.open(folder)))
    PAGE.write_text(page, encoding="utf-8")


if __name__ == "__main__":
    main()
