"""Time and memory of generating a full wind field: 25 x 25 points, 600 s at 20 Hz, and one wide enough for two rotors.

Run: python benchmarks/wind_field.py [folder for the files]
"""

from __future__ import annotations

import resource
import sys
import tempfile
import time
from pathlib import Path

from fowtlib.components.environment import generate_field

TWO_ROTORS = {"width": 320, "height": 160, "columns": 41, "rows": 21}
CASES = {
    "one rotor, Kaimal": {"width": 160, "height": 160, "columns": 25, "rows": 25},
    "one rotor, von Karman, v and w coherent": {
        **{"width": 160, "height": 160, "columns": 25, "rows": 25},
        **{"spectrum": "von_karman", "lateral_coherence": "iec"},
    },
    "two rotors, Kaimal": TWO_ROTORS,
    "two rotors, Kaimal, 4000 s": {**TWO_ROTORS, "duration": 4000},
}


def main(folder: Path) -> None:
    for name, options in CASES.items():
        path, begin = folder / "field.bts", time.perf_counter()
        grid = generate_field(path, mean_speed=11.4, **options).grid
        elapsed = time.perf_counter() - begin
        peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
        size = f"{grid.columns} x {grid.rows} points, {grid.duration:.0f} s at {1 / grid.dt:.0f} Hz"
        print(f"{name}: {size}: {elapsed:.1f} s, peak {peak:.0f} MB so far, file {path.stat().st_size / 2**20:.0f} MB")


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as scratch:
        main(Path(sys.argv[1] if len(sys.argv) > 1 else scratch))
