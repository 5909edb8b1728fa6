"""From asking for another case of a compiled plant to its first step: processor time, without the making of a mean.

Run: OPENBLAS_NUM_THREADS=1 python benchmarks/second_case.py
"""

from __future__ import annotations

import statistics
import time
import warnings

import fowtlib as fw

CASES = 15


def case(k: int) -> dict[str, float | int | str]:
    """Another wind, sea and heading for each number."""
    return {
        "wind.kind": "kaimal", "wind.mean_speed": 12.0, "wind.seed": k, "sea.spectrum": "jonswap", "sea.seed": k,
        "sea.significant_wave_height": 4 + 0.1 * k, "sea.peak_period": 9 + 0.2 * k, "sea.heading": 0.05 * k,
    }  # fmt: skip


def main() -> None:
    warnings.simplefilter("ignore")
    for name in ("oc3_spar_rigid", "oc3_spar", "two_rotor_spar"):
        plant = fw.load(name).compile()
        for start in ("turning", None):
            times = []
            for k in range(CASES):
                began = time.process_time()
                plant.simulate(0.1, 0.1, solver="fixed", parameters=case(k), start=start)
                times.append(time.process_time() - began)
            later = times[1:]
            print(f"{name}, start {start or 'of the file'}: first {times[0]:.2f} s, later", end=" ")
            print(f"{statistics.median(later):.3f} s ({min(later):.3f} to {max(later):.3f})")


if __name__ == "__main__":
    main()
