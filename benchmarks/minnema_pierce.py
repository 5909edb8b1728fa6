"""OpenFAST's unsteady airfoils at rest as polars of the NREL 5 MW: a table of docs/unsteady_airfoils.md.

The model of Minnema and Pierce has the normal force C_n = C_na (a - a_0) ((1 + sqrt(f)) / 2)^2 and the chordwise C_c =
C_na (a - a_0) a g, with f and g from the polar, but at most 1: where the polar has more than these lines, the lines are
what the model has.

python benchmarks/minnema_pierce.py
"""

from __future__ import annotations

import os
import tempfile
from dataclasses import dataclass, replace
from pathlib import Path
from typing import ClassVar

import numpy as np
from pages import fill, markdown

import fowtlib as fw
from fowtlib.components.aero import AIRFOIL_MODELS, Airfoil, AirfoilModel, BladeElementRotor, RigidRotor, read_blade
from fowtlib.modelfile import data_path

PAGE = Path(__file__).parents[1] / "docs" / "unsteady_airfoils.md"
DECK = {"DU21_A17": (-4.2, 6.2047, 0.006), "DU25_A17": (-3.2, 6.4462, 0.006), "DU30_A17": (-2.2, 7.3326, 0.008),
        "DU35_A17": (-1.2, 7.1838, 0.012), "DU40_A17": (-3.2, 7.4888, 0.03),
        "NACA64_A17": (-4.432, 6.0031, 0.0065)}  # fmt: skip
"""alpha0 [deg], C_nalpha [1/rad] and Cd0 of the airfoil files of rosco 2.10.6 (Apache-2.0), which are OpenFAST's."""
CUTOUT = 45.0  # [deg]: beyond, OpenFAST takes the polar
WINDS = {8.0: (9.086, 7.65), 11.4: (11.94, 10.02)}  # [m/s]: speed [rpm] and tilt [deg] of the rotor of oc3_spar
MOMENT = "blade_root_flapwise_moment_1"
LAGS = {"wake_share": (0.3, 0.7), "wake_decay": (0.14, 0.53)}  # OpenFAST's
HELD = """
static inline void flow(int station, const double *in, double step, double *value, double (*slope)[FLOW_INPUTS]) {
    double v[6], d[6];
    (void)step;
    airfoil(station, in[FLOW_ANGLE], 3, 6, v, d);
    for (int i = 0; i < 3; i++) value[i] = v[3 + i];
    for (int i = 0; slope && i < 3; i++) slope[i][FLOW_ANGLE] = d[3 + i];
}
"""


@dataclass(frozen=True)
class Held(AirfoilModel):
    """Loads of other polars than those that momentum balances: those of `at_rest`."""

    source: ClassVar[str] = str(Path(tempfile.gettempdir()) / f"held_{os.getpid()}.c")

    def cubics(self, foil: Airfoil) -> np.ndarray:
        """The polar, and the one that makes the loads."""
        return np.concatenate([foil.cubics, at_rest(foil).cubics], axis=1)


def at_rest(foil: Airfoil) -> Airfoil:
    """The polar that the model has in equilibrium; the moment is that of the polar."""
    if foil.name not in DECK:
        return foil
    zero, slope, drag_0 = DECK[foil.name]
    a, (lift, drag, moment) = foil.angle, foil.coefficients.T
    normal = lift * np.cos(a) + (drag - drag_0) * np.sin(a)
    chordwise = lift * np.sin(a) - (drag - drag_0) * np.cos(a)
    line = slope * (a - np.radians(zero))
    inside = np.abs(np.degrees(a)) < CUTOUT
    normal = np.where(inside & (normal * line > line**2), line, normal)
    chordwise = np.where(inside & (line * a > 0) & (chordwise > line * a), line * a, chordwise)
    both = normal * np.cos(a) + chordwise * np.sin(a), normal * np.sin(a) - chordwise * np.cos(a) + drag_0
    return Airfoil(foil.name, a, np.column_stack([*both, moment]))


def rigid(wind: float) -> tuple[float, float]:
    """Changes [%] of power and thrust of the stiff rotor, with the induction of the polars, as OpenFAST has it."""
    files = (str(data_path(f"nrel5mw/{name}.csv")) for name in ("blade_aerodynamics", "airfoils"))
    blade = read_blade(*files, 1.5, 63.0)
    held = replace(blade, airfoils={name: at_rest(foil) for name, foil in blade.airfoils.items()})
    speed, tilt = WINDS[wind][0] * np.pi / 30, np.radians(WINDS[wind][1])
    rotors = [RigidRotor(BladeElementRotor(b, dynamic_inflow=True), np.radians(2.5), tilt) for b in (blade, held)]
    induced = rotors[0].quasi_steady(rotors[0].inputs([wind, 0, 0], speed))
    numbers = np.array([rotor.thrust_and_torque([wind, 0, 0], speed, induced=induced) for rotor in rotors])
    thrust, torque = 100 * (numbers[1] / numbers[0] - 1)
    return torque, thrust


def spar(wind: float, airfoils: str | None, word: str) -> tuple[float, float, float]:
    """Mean power and thrust, and deviation of the flapwise moment of oc3_spar: the last 100 of 400 s, steady wind."""
    given = {"wind.kind": "steady", "wind.mean_speed": wind, "sea.spectrum": "still",
             "turbine.aerodynamics.airfoil_model": word}  # fmt: skip
    if airfoils:
        given["turbine.aerodynamics.airfoils"] = airfoils
    result = fw.load("oc3_spar", set=given).compile().simulate(400.0, 0.1)
    last = np.asarray(result.time) > 300.0
    power, thrust, moment = (np.asarray(result[name])[last] for name in ("aero_power", "thrust", MOMENT))
    return power.mean(), thrust.mean(), moment.std()


def write(path: Path) -> str:
    """The airfoils of the model at rest as a CSV."""
    blade = read_blade(
        str(data_path("nrel5mw/blade_aerodynamics.csv")), str(data_path("nrel5mw/airfoils.csv")), 1.5, 63.0
    )
    lines = ["airfoil,angle_of_attack_deg,lift_coefficient,drag_coefficient,moment_coefficient"]
    for name, foil in blade.airfoils.items():
        held = at_rest(foil)
        lines += [f"{name},{np.degrees(a):.10g},{','.join(f'{c:.10g}' for c in row)}"
                  for a, row in zip(held.angle, held.coefficients, strict=True)]  # fmt: skip
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return str(path)


def main() -> None:
    """Fill the page."""
    AIRFOIL_MODELS["attached"] = replace(AIRFOIL_MODELS["attached"], **LAGS)
    AIRFOIL_MODELS["oye"] = Held()  # under a word that it may have
    Path(Held.source).write_text(HELD, encoding="utf-8")
    rows = []
    published = {8.0: ("-5.2 %", "-5.2 %", "-17 %"), 11.4: ("-3.5 %", "-3.5 %", "")}
    with tempfile.TemporaryDirectory() as folder:
        path = write(Path(folder) / "airfoils.csv")
        for wind in WINDS:
            power, thrust = rigid(wind)
            name = f"{wind:g} m/s"
            what = "stiff rotor at the same speed, those polars, induction of the first"
            rows.append((name, what, f"{power:+.1f} %", f"{thrust:+.1f} %", ""))
            reference = spar(wind, None, "steady")
            for what, airfoils, word in (("`oc3_spar`, those polars, induction of the first", None, "oye"),
                                         ("`oc3_spar`, those polars for both", path, "steady"),
                                         ("`oc3_spar`, lags alone", None, "attached"),
                                         ("`oc3_spar`, those polars and lags", path, "attached")):  # fmt: skip
                both = zip(spar(wind, airfoils, word), reference, strict=True)
                rows.append((name, what, *(f"{100 * (a / b - 1):+.1f} %" for a, b in both)))
            rows.append((name, "OpenFAST", *published[wind]))
    text = markdown((("wind", "change by", "power", "thrust", "deviation of the flapwise moment"), rows))
    print(text)
    PAGE.write_text(fill(PAGE.read_text(encoding="utf-8"), "minnema_pierce", text), encoding="utf-8")


if __name__ == "__main__":
    main()
