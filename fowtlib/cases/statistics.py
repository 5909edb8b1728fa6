"""Statistics of one case, as plain data for the registry."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from fowtlib.solving.results import Result


def statistics_of(result: Result) -> dict[str, Any]:
    """See fowtlib.analysis.case_statistics; of fewer than three points there are none."""
    from fowtlib.analysis import case_statistics

    return case_statistics(result) if result.time.size >= 3 else {}
