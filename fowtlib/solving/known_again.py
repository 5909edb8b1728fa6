"""What was computed once from the equations of a flat model, kept on disk where these are known again."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import casadi as ca
import numpy as np

from fowtlib.flattening import FlatDAE
from fowtlib.flattening.kept import switched_on
from fowtlib.flattening.own_code import Unknown, digest_of_own_code
from fowtlib.language.cache import cached
from fowtlib.language.externals import LibraryFunction
from fowtlib.language.tables import SplineFunction


def kept_or_found(dae: FlatDAE, name: str, parts: Iterable[str | np.ndarray], find: Callable[[], Any]) -> Any:
    """What `find` gives, as in `cached`, or another process has found of the same equations and the same parts.

    parts: all else that it is made from. Without a key of the model (see flattening.kept), or with Python code or a
    library of somebody else in its equations, it is found every time.
    """
    known = known_by(dae)
    return cached(name, [*known, *parts], find) if known else find()


def known_by(dae: FlatDAE) -> list[str]:
    """Texts that are the same for the same equations and the same code that computes with them; none where unknown."""
    functions = [external.function for external in dae.externals]
    if not (dae.key and switched_on() and all(map(_known, functions))):
        return []
    try:
        code = digest_of_own_code("fowtlib.solving")
    except Unknown:
        return []
    libraries = [str(function.path) for function in functions if isinstance(function, LibraryFunction)]
    return [dae.key, code, *libraries]


def _known(function: ca.Function) -> bool:
    """Whether its content is known: of numbers, or compiled here, so that its path holds a digest of what it holds."""
    compiled = isinstance(function, LibraryFunction) and function.source is not None
    return compiled or isinstance(function, SplineFunction)
