"""Cases files with all that they may name: joint distributions of wind and waves, and sites."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path

from fowtlib import cases, metocean
from fowtlib.cases import CaseSet
from fowtlib.cases.conditional import Distribution
from fowtlib.cases.folder import Allowed
from fowtlib.cases.site import Site, is_site_file, site_from
from fowtlib.cases.site import read_site as _of_file

DEFAULT_SITE = "norway_5"


def read_cases(
    path: str | os.PathLike[str],
    *,
    distributions: Mapping[str, Distribution] | None = None,
    text: str | None = None,
    allow: Allowed = (),
) -> CaseSet:
    """The cases of a file; see fowtlib.cases.read_cases. Sites of `distributions` are those of fowtlib.metocean."""
    opened = metocean.open_distribution
    return cases.read_cases(path, distributions=distributions, open_distribution=opened, text=text, allow=allow)


def read_site(source: str | os.PathLike[str], hub_height: float) -> Site:
    """A site for named sets of load cases: a shipped one, a file of a joint distribution, or a file of tables.

    hub_height [m]: where the wind is wanted; a file of tables has its own.
    """
    if is_site_file(Path(source)):
        return _of_file(source)
    joint = metocean.site(source).at(hub_height)
    about = f"{joint.source} The wind is that at {hub_height:g} m."
    return site_from(joint, hub_height, Path(source).stem, joint.title, about)
