"""Say which tests a run has skipped, and why, from the report that pytest writes with --junitxml."""

from __future__ import annotations

import sys
from collections import defaultdict
from pathlib import Path
from xml.etree import ElementTree


def skipped(report: Path) -> dict[str, list[str]]:
    """Names of the skipped tests by reason; those that are expected to fail are none of them."""
    found: dict[str, list[str]] = defaultdict(list)
    for case in ElementTree.parse(report).iter("testcase"):
        for mark in case.iter("skipped"):
            if mark.get("type") != "pytest.xfail":
                found[mark.get("message", "no reason")].append(f"{case.get('classname')}.{case.get('name')}")
    return found


def main(path: str) -> int:
    """Print them."""
    report = Path(path)
    if not report.exists():
        print("the tests did not run to their end: there is no list of those that were skipped")
        return 1
    reasons = skipped(report)
    count = sum(map(len, reasons.values()))
    print(f"{count} test{'s' * (count != 1)} skipped" + (":" if count else "."))
    for reason, names in sorted(reasons.items()):
        print(f"  {reason}")
        for name in names:
            print(f"      {name}")
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
