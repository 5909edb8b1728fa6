"""Results under the names of OpenFAST's output channels, and back.

The axes agree: x downwind, y to the left looking downwind, z up; angles and moments about these axes; a moment is what
the part above or outboard does to the part below or inboard. Blade axes of OpenFAST: z to the tip, x downwind, y to the
trailing edge at zero pitch; b pitches with the blade (RootM..b), c does not (OoPDefl, IPDefl). So no sign is turned.
Sources: J. Jonkman and M. Buhl, FAST User's Guide, NREL/EL-500-38230 (2005), sections on coordinate systems and output
parameters; OutListParameters.xlsx of OpenFAST for AeroDyn, HydroDyn, InflowWind and MoorDyn.
"""

from __future__ import annotations

import re
from collections.abc import Collection
from dataclasses import dataclass

from fowtlib.language.errors import UnitError
from fowtlib.language.units import conversion, parse_unit


@dataclass(frozen=True)
class Channel:
    """A result with the unit in which people read it, and its channel with the unit that OpenFAST writes.

    `#` stands for a number: of a blade, of a mooring line. others: names that other versions of OpenFAST use. only: a
    model has one of them, and a longer name is another quantity (yaw_error is no yaw of the platform).
    """

    result: str
    unit: str
    name: str
    written_unit: str
    others: tuple[str, ...] = ()
    only: bool = False
    turns: bool = False  # an angle that OpenFAST keeps between 0 and 360 deg


CHANNELS = (
    Channel("wind_speed", "m/s", "Wind1VelX", "m/s"),
    Channel("wave_elevation", "m", "Wave1Elev", "m", only=True),
    Channel("surge", "m", "PtfmSurge", "m", only=True),
    Channel("sway", "m", "PtfmSway", "m", only=True),
    Channel("heave", "m", "PtfmHeave", "m", only=True),
    Channel("roll", "deg", "PtfmRoll", "deg", only=True),
    Channel("pitch", "deg", "PtfmPitch", "deg", only=True),
    Channel("yaw", "deg", "PtfmYaw", "deg", only=True),
    Channel("rotor_speed", "rpm", "RotSpeed", "rpm"),
    Channel("azimuth", "deg", "Azimuth", "deg", turns=True),
    Channel("generator_speed", "rpm", "GenSpeed", "rpm"),
    Channel("generator_torque", "N m", "GenTq", "kN m"),
    Channel("generator_power", "kW", "GenPwr", "kW"),
    Channel("aero_power", "kW", "RtAeroPwr", "W", others=("RtFldPwr",)),
    Channel("thrust", "kN", "RtAeroFxh", "N", others=("RtFldFxh",)),
    Channel("blade_pitch", "deg", "BldPitch1", "deg"),
    Channel("blade_pitch_#", "deg", "BldPitch#", "deg"),
    Channel("blade_root_flapwise_moment_#", "kN m", "RootMyb#", "kN m"),
    Channel("blade_root_edgewise_moment_#", "kN m", "RootMxb#", "kN m"),
    Channel("blade_root_pitching_moment_#", "kN m", "RootMzb#", "kN m", others=("RootMzc#",)),
    Channel("blade_tip_out_of_plane_#", "m", "OoPDefl#", "m", others=("TipDxc#",)),
    Channel("blade_tip_in_plane_#", "m", "IPDefl#", "m", others=("TipDyc#",)),
    Channel("shaft_bending_moment", "kN m", "LSSTipM", "kN m"),  # of LSSTipMys and LSSTipMzs; OpenFAST has no magnitude
    Channel("tower_base_fore_aft_moment", "kN m", "TwrBsMyt", "kN m"),
    Channel("tower_base_side_side_moment", "kN m", "TwrBsMxt", "kN m"),
    Channel("tower_base_torsion", "kN m", "TwrBsMzt", "kN m"),
    Channel("tower_top_fore_aft_displacement", "m", "TTDspFA", "m"),
    Channel("tower_top_side_side_displacement", "m", "TTDspSS", "m"),
    Channel("fairlead_tension_#", "kN", "FAIRTEN#", "N"),
)


@dataclass(frozen=True)
class Named:
    """A series by another name: what to multiply it with, and the unit it then has; turns as in Channel."""

    name: str
    unit: str
    factor: float = 1.0
    turns: bool = False


def channel_of(result: str, unit: str) -> Named:
    """The channel of a result in `unit`; of an unknown one, or one of another dimension, its own name and unit.

    What tells rotors apart follows the channel: rotor_speed_left is RotSpeed_left, blade_pitch_2_left (or
    blade_pitch_left_2) is BldPitch2_left. Element [i] of a vector is number i + 1.
    """
    words = re.sub(r"\[(\d+)\]", lambda found: f"_{int(found[1]) + 1}", result)
    for entry in sorted(CHANNELS, key=lambda entry: -len(entry.result)):
        found = _match(entry.result, words, entry.only) or _number_last(entry.result, words)
        factor = _factor(unit, entry.written_unit) if found else None
        if found and factor is not None:
            number, rest = found
            return Named(entry.name.replace("#", number) + rest, entry.written_unit, factor, entry.turns)
    return Named(result, unit)


def result_of(channel: str, unit: str, beside: Collection[str] = ()) -> Named:
    """The result that a channel of OpenFAST in `unit` holds, in the unit of people; an unknown channel stays as it is.

    beside: the other channels; BldPitch1 without a BldPitch2 is the pitch of all blades.
    """
    collective = "bldpitch2" not in {name.lower()[:9] for name in beside}
    for entry in CHANNELS:
        if entry.result == "blade_pitch" and not collective:
            continue
        for name in (entry.name, *entry.others):
            found = _match(name, channel, entry.only)
            factor = _factor(unit, entry.unit) if found else None
            if found and factor is not None:
                number, rest = found
                return Named(entry.result.replace("#", number) + rest, entry.unit, factor)
    return Named(channel, unit)


def unique(name: str, taken: Collection[str]) -> str:
    """`name`, or with a number behind it if it is taken; capitals do not tell names apart."""
    used = {other.lower() for other in taken}
    number, made = 1, name
    while made.lower() in used:
        number += 1
        made = f"{name}_{number}"
    return made


def _match(pattern: str, name: str, whole: bool) -> tuple[str, str] | None:
    """The number of a pattern in a name, and what follows the pattern: nothing or, unless whole, _ and a word."""
    stem = re.escape(pattern).replace(r"\#", r"(?P<number>\d+)")
    found = re.fullmatch(stem + ("(?P<rest>)" if whole else r"(?P<rest>_\D\w*)?"), name, re.IGNORECASE | re.ASCII)
    return (found.groupdict().get("number") or "", found["rest"] or "") if found else None


def _number_last(pattern: str, name: str) -> tuple[str, str] | None:
    """The same for a word in front of the number: blade_pitch_left_2 as blade_pitch_2_left."""
    if not pattern.endswith("_#"):
        return None
    found = re.fullmatch(re.escape(pattern.removesuffix("_#")) + r"(?P<rest>_\D\w*)_(?P<number>\d+)", name)
    return (found["number"], found["rest"]) if found else None


def _factor(unit: str, wanted: str) -> float | None:
    """From one unit to another; None if that is not possible."""
    try:
        one, out = parse_unit(unit), parse_unit(wanted)
    except UnitError:
        return None
    return conversion(one, out) if one.dimension == out.dimension else None
