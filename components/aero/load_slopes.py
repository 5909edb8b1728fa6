"""What each blade element adds to the loads of a rotor by a change of its wind, in steady operation; reader, writer.

Source: J.M. Hegseth, thesis NTNU 2020:356, appendix B; A. Halfpenny, PhD thesis (1998).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike, NDArray

from fowtlib.components.aero.airfoil_models import STEADY
from fowtlib.components.aero.bem import BladeElementRotor
from fowtlib.components.aero.bem_steady import RigidRotor
from fowtlib.language.data_files import number_rows, remembered
from fowtlib.language.errors import ParameterError
from fowtlib.language.similarity import Similarity
from fowtlib.language.whole_files import write_text

COLUMNS = ("wind_speed_m_s", "rotor_speed_rpm", "blade_pitch_deg", "radius_m", "thrust_slope_m3_s", "torque_slope_m4_s",
           "moment_slope_m4_s")  # fmt: skip
RPM = 2 * np.pi / 60

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class LoadSlopes:
    """Slopes of the loads of one blade by the wind at each of its elements, over the wind in which the rotor operates.

    wind_speed (n,) [m/s] does not fall: two rows of the same wind are a jump, such as cutting out, and the second holds
    above it. rotor_speed (n,) [rad/s], blade_pitch (n,) [rad]. radius (r,) [m] from the shaft. thrust [m^3/s],
    torque and moment [m^4/s], (n, r) each: by the wind along the shaft at the element, over the air density, of the
    force along the shaft, of the moment about it that drives, and of the moment that tilts the hub while the blade is
    up. The wake is in equilibrium with each element's own wind. Raises ParameterError.
    """

    wind_speed: Floats
    rotor_speed: Floats
    blade_pitch: Floats
    radius: Floats
    thrust: Floats
    torque: Floats
    moment: Floats
    where: str = ""

    def __post_init__(self):
        for name in ("wind_speed", "rotor_speed", "blade_pitch", "radius", "thrust", "torque", "moment"):
            object.__setattr__(self, name, np.asarray(getattr(self, name), dtype=float))
        falls = np.flatnonzero(np.diff(self.wind_speed) < 0)
        if falls.size:
            i = falls[0]
            raise self._wrong(f"the winds must not fall; {self.wind_speed[i]:g} m/s comes before "
                              f"{self.wind_speed[i + 1]:g} m/s.")  # fmt: skip
        if np.any(np.diff(self.radius) <= 0) or not self.radius[0] > 0:
            raise self._wrong("the radii of the elements must rise from above 0 m.")
        weak = np.flatnonzero((self.thrust.sum(axis=1) <= 0) | (self.moment.sum(axis=1) <= 0))
        if weak.size:
            raise self._wrong(f"at {self.wind_speed[weak[0]]:g} m/s more wind does not add to the thrust, so that no "
                              "wind stands for what the blades feel.")  # fmt: skip

    ending = ".csv"

    def in_similarity(self, similarity: Similarity) -> LoadSlopes:
        """The slopes of the rotor in another scale, in a wind in proportion to the other speeds."""
        similarity.refuse_other_wind("slopes by the wind hold for a wind in proportion to the other speeds")
        units = {"wind_speed": "m/s", "rotor_speed": "rad/s", "radius": "m", "thrust": "m^3/s", "torque": "m^4/s",
                 "moment": "m^4/s"}  # fmt: skip
        return replace(self, **{name: getattr(self, name) * similarity.factor(unit) for name, unit in units.items()})

    def write(self, path: str | Path) -> None:
        """Write a CSV that read_load_slopes reads. Raises WriteError."""
        write_load_slopes(path, self)

    def _wrong(self, message: str) -> ParameterError:
        return ParameterError(f"slopes of the rotor's loads: {message}", where=self.where)

    def at(self, wind_speed: float) -> LoadSlopes:
        """Those of one wind, linear between the rows; ParameterError outside of them."""
        rows = self.wind_speed
        if not rows[0] <= wind_speed <= rows[-1]:
            raise self._wrong(f"they cover winds of {rows[0]:g} to {rows[-1]:g} m/s, and not {wind_speed:.4g} m/s; "
                              "compute them for this wind too (fowt rotor-table --slopes).")  # fmt: skip
        high = max(int(np.searchsorted(rows, wind_speed)), min(1, len(rows) - 1))
        low = max(high - 1, 0)
        share = (wind_speed - rows[low]) / (rows[high] - rows[low]) if rows[high] > rows[low] else 1.0

        def between(values: Floats) -> Floats:
            return ((1 - share) * values[low] + share * values[high])[None]

        speed, pitch, *loads = (between(v) for v in (self.rotor_speed, self.blade_pitch, self.thrust, self.torque,
                                                     self.moment))  # fmt: skip
        return LoadSlopes(np.array([wind_speed]), speed, pitch, self.radius, *loads, where=self.where)


def load_slopes(
    rotor: BladeElementRotor, wind_speed: ArrayLike, rotor_speed: ArrayLike, blade_pitch: ArrayLike, *,
    precone: float = 0.0, progress: Callable[[int, int], None] | None = None,
) -> LoadSlopes:  # fmt: skip
    """The slopes from the blade elements, exact; shaft along the wind, no tilt, rigid blades, quasi-steady airfoils.

    wind_speed [m/s], rotor_speed [rad/s] and blade_pitch [rad] (n,) say how the turbine operates.
    progress(done, all) is called after each.
    """
    steady = replace(rotor, dynamic_inflow=False, airfoil_model=STEADY)
    rigid, stations, nodes = RigidRotor(steady, precone), len(rotor.blade.radius), steady.nodes
    winds, speeds, pitches = (np.asarray(v, dtype=float) for v in (wind_speed, rotor_speed, blade_pitch))
    jacobian, first = steady.external.function.jacobian(), 15 * nodes
    axial = np.zeros(sum(steady.inputs.values()))
    axial[first : first + 3 * nodes : 3] = 1.0  # elements feel their own wind alone
    found = np.empty((3, len(winds), stations))
    radius = np.zeros(stations)
    for k, (wind, speed, pitch) in enumerate(zip(winds, speeds, pitches, strict=True)):
        inputs = rigid.inputs([wind, 0, 0], speed, pitch, hub=(0, 0, 0), air_density=1.0)
        slope = ca.mtimes(jacobian(ca.DM(inputs), ca.DM()), ca.DM(axial)).full().ravel()[: 6 * nodes].reshape(-1, 6)
        place, force, moment = inputs[: 3 * stations].reshape(-1, 3), slope[:stations, :3], slope[:stations, 3:]
        about_hub = moment + np.cross(place, force)
        radius = np.hypot(place[:, 1], place[:, 2])
        found[:, k] = force[:, 0], steady.rotation * about_hub[:, 0], about_hub[:, 1]
        if progress is not None:
            progress(k + 1, len(winds))
    return LoadSlopes(winds, speeds, pitches, radius, *found)


@remembered()
def read_load_slopes(path: str) -> LoadSlopes:
    """Read a CSV with the columns of COLUMNS, one row for each wind and element; lines that start with # are comments.

    The elements of a wind stand together, with the same radii in every wind. Raises ParameterError with path and line.
    """
    rows = np.array(number_rows(path, COLUMNS, "the slopes of the rotor's loads")).reshape(-1, len(COLUMNS))
    starts = np.flatnonzero(np.append(True, np.diff(rows[:, 3]) < 0)) if len(rows) else np.array([])
    count = len(rows) // max(len(starts), 1)
    if not len(rows) or len(rows) % len(starts) or not np.array_equal(starts, count * np.arange(len(starts))):
        raise ParameterError("give the same radii, rising, for every wind.", where=path)
    table = rows.reshape(len(starts), count, -1)
    if not (np.allclose(table[:, :, 3], table[0, :, 3]) and np.all(table[:, :, :3] == table[:, :1, :3])):
        raise ParameterError("give the same radii for every wind, with one rotor speed and one pitch.", where=path)
    wind, speed, pitch = table[:, 0, :3].T
    return LoadSlopes(wind, speed * RPM, np.radians(pitch), table[0, :, 3], *np.moveaxis(table[..., 4:], 2, 0), path)


def write_load_slopes(path: str | Path, slopes: LoadSlopes, about: Sequence[str] = ()) -> None:
    """Write slopes as read_load_slopes reads them; about: lines of comment."""
    lines = [*(f"# {line}" for line in about), ",".join(COLUMNS)]
    for k, wind in enumerate(slopes.wind_speed):
        operation = f"{wind:.10g},{slopes.rotor_speed[k] / RPM:.10g},{np.degrees(slopes.blade_pitch[k]):.10g}"
        for i, radius in enumerate(slopes.radius):
            loads = (slopes.thrust[k, i], slopes.torque[k, i], slopes.moment[k, i])
            lines.append(f"{operation},{radius:.10g}," + ",".join(f"{value:.8g}" for value in loads))
    write_text(path, "\n".join(lines) + "\n")
