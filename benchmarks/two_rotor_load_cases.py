"""Load cases LC 1.1 to LC 1.8 of the two-rotor spar with complete turbines, for docs/load_cases.md.

Wind and waves: O. El Beshbichi, PhD thesis, University of Stavanger (2023), table 4.9. A run starts with the platform
near its mean place, at rest with unbent blades, tower and arms.
"""

from __future__ import annotations

from dataclasses import dataclass

from pages import Table

from fowtlib.solving.results import Statistics

# the thesis has neither the drag of tower and arms nor the tower's dam in the wind at the blades
BARE = "--set tower_drag_coefficient=0 --set tower_flow.active=false"
DURATION, SETTLE = 1500.0, 300.0  # s
RESULTS = ("yaw", "pitch", "surge", "generator_power_left", "generator_power_right", "rotor_speed_left",
           "blade_pitch_left", "wire_tension_left", "fairlead_tension_2")  # fmt: skip


@dataclass(frozen=True)
class LoadCase:
    """wind speed [m/s], Hs [m], Tp [s]; surge [m] and pitch [deg] at the start."""

    name: str
    speed: float
    height: float
    period: float
    surge: float
    pitch: float
    spectrum: str = "kaimal"

    @property
    def key(self) -> str:
        """Name of the run and, with .bts, of its wind field."""
        return f"two_rotors_{self.spectrum}_{self.speed:g}"

    def field_command(self, file: str) -> str:
        """Command that makes the wind."""
        return (
            f"fowt wind-field {file} --speed {self.speed:g} --class B --shear 0.14 --spectrum {self.spectrum}"
            f" --width 300 --height 150 --time {DURATION + 60:g}"
        )

    def command(self, file: str) -> str:
        """Command of the run."""
        start = "platform.motion"
        return (
            f"fowt run two_rotor_spar --start file --wind field:{file}"
            f" --waves jonswap:Hs={self.height:g},Tp={self.period:g},seed=1"
            f" --set {start}.surge_start={self.surge:g} --set '{start}.pitch_start={self.pitch:g} deg'"
            f" --set {start}.heave_start=-2 {BARE} --time {DURATION:g} --solver fixed"
        )


KAIMAL = (
    LoadCase("1.1", 5, 2.10, 9.74, 5, 1), LoadCase("1.2", 8, 2.55, 9.86, 12, 2.1),
    LoadCase("1.3", 10, 2.88, 9.98, 17, 3.1), LoadCase("1.4", 12, 3.24, 10.12, 17, 3.3),
    LoadCase("1.5", 14, 3.62, 10.29, 14.5, 2.6), LoadCase("1.6", 18, 4.44, 10.66, 11.5, 2),
    LoadCase("1.7", 22, 5.32, 11.06, 10, 1.7), LoadCase("1.8", 25, 6.02, 11.38, 9, 1.5),
)  # fmt: skip
HEADS = ("load case", "wind [m/s]", "waves [m], [s]", "yaw [deg]", "pitch [deg]", "surge [m]", "power, left [kW]",
         "power, right [kW]", "rotor, left [rpm]", "blade pitch, left [deg]", "left wire [kN]",
         "upwind line [kN]")  # fmt: skip


def table(found: dict[LoadCase, Statistics]) -> Table:
    """Mean and standard deviation of RESULTS after SETTLE in each case."""
    rows = []
    for case, statistics in found.items():
        values = [f"{statistics[name].mean:.4g} and {statistics[name].std:.4g}" for name in RESULTS]
        rows.append((case.name, f"{case.speed:g}", f"{case.height:g}, {case.period:g}", *values))
    return HEADS, rows
