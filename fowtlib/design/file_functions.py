"""Functions of a design file: formulas of results, and rules of `fowtlib.design.rules`."""

from __future__ import annotations

import importlib
import inspect
from collections.abc import Callable, Mapping
from typing import Any

import casadi as ca
import numpy as np

from fowtlib.design.terms import Function
from fowtlib.language.errors import ModelError, did_you_mean
from fowtlib.modelfile import formulas
from fowtlib.modelfile.formulas import Formula, Quantity
from fowtlib.modelfile.nodes import Node
from fowtlib.modelfile.specs import check_keys, mapping, text

RULES = "fowtlib.design.rules"
FUNCTION_KEYS = ("formula", "rule", "take", "of", "unit")


def read_functions(node: Node | None) -> list[Function]:
    """The functions below the key `functions`; errors with their lines."""
    found = []
    for name, item in mapping(node, "'functions' is a mapping of names").items() if node is not None else ():
        if isinstance(item.value, str):
            found.append(_formula(name, item, {}, ""))
            continue
        items = mapping(item, f"the function '{name}' is a formula, or a mapping with 'formula' or 'rule'")
        check_keys(items, FUNCTION_KEYS, "a function")
        if ("formula" in items) == ("rule" in items):
            raise item.place.error(f"the function '{name}' has a 'formula' or a 'rule'.")
        given = mapping(items["of"], "'of' is a mapping of names and results") if "of" in items else {}
        unit = text(items, "unit")
        if "rule" in items:
            found.append(_rule(name, items, given, unit))
            continue
        if "take" in items:
            raise items["take"].place.error("'take' is of a rule.")
        found.append(_formula(name, items["formula"], given, unit))
    return found


def _formula(name: str, node: Node, of: Mapping[str, Node], unit: str) -> Function:
    """A formula; its names are results, or those that `of` gives to results.

    Results count as numbers in their own units, so that no unit may stand in a formula.
    """
    if not isinstance(node.value, str):
        raise node.place.error(f"the formula of '{name}' is text, not {node.kind}.")
    for own, item in of.items():
        if not isinstance(item.value, str):
            raise item.place.error(f"'{own}' stands for a result, by its name, not for {item.kind}.")
    results = {own: str(item.value) for own, item in of.items()}
    try:
        parsed = formulas.parse(node.value, results)
    except ModelError as error:
        raise node.place.error(str(error)) from None
    for own, item in of.items():
        if own not in parsed.names:
            raise item.place.error(f"nothing in the formula of '{name}' uses '{own}'.")
    for own in parsed.names:
        results.setdefault(own, own)
    _refuse_units(name, parsed, node)
    return Function(name, _evaluated(parsed, results), tuple(dict.fromkeys(results.values())), unit or "1")


def _refuse_units(name: str, parsed: Formula, node: Node) -> None:
    """Units in a formula would meet results that are in units of their own."""
    trial: Any = np.full(1000, 1.2345678) if "[" in parsed.text else 1.2345678  # with elements where some are taken
    try:
        result = parsed.tree(lambda own: Quantity(trial))
    except ModelError:
        result = Quantity(0.0, formulas.NONE)
    except (ArithmeticError, ValueError, TypeError):
        return  # no number there: of these values, or of elements
    if result.unit is not None:
        raise node.place.error(
            f"the formula of '{name}' has a unit in it; results count as numbers in their own units (pitch in deg), so "
            "write numbers alone, and the unit of what comes out under 'unit'."
        )


def _evaluated(parsed: Formula, results: Mapping[str, str]) -> Callable[[Mapping[str, Any]], Any]:
    def function(values: Mapping[str, Any]) -> Any:
        return parsed.tree(lambda own: Quantity(values[results[own]])).value

    function.text = parsed.text  # type: ignore[attr-defined]
    return function


def _rule(name: str, items: Mapping[str, Node], given: Mapping[str, Node], unit: str) -> Function:
    """A function of fowtlib.design.rules of results, in SI, and numbers, or lists of both.

    `take`: an attribute of what it gives.
    """
    node, rule = items["rule"], text(items, "rule")
    rules = importlib.import_module(RULES)
    known = [one for one in rules.__all__ if inspect.isfunction(getattr(rules, one))]
    if rule not in known:
        raise node.place.error(f"there is no rule '{rule}'{did_you_mean(rule, known, list_up_to=30)}")
    called, take = getattr(rules, rule), text(items, "take")
    arguments = inspect.signature(called).parameters
    for own, item in given.items():
        if own not in arguments:
            raise item.place.error(f"the rule '{rule}' takes no '{own}'{did_you_mean(own, arguments, list_up_to=20)}")
    missing = [own for own, one in arguments.items() if one.default is one.empty and own not in given]
    if missing:
        raise node.place.error(f"the rule '{rule}' needs '{missing[0]}', a result or a number, under 'of'.")
    plain = {own: item.plain() for own, item in given.items()}
    fixed = {own for own, one in arguments.items() if one.annotation in ("str", str)}
    results = [one for own, item in plain.items() if own not in fixed for one in _listed(item) if isinstance(one, str)]

    def function(values: Mapping[str, Any]) -> Any:
        found = called(**{own: item if own in fixed else _filled(item, values) for own, item in plain.items()})
        for word in take.split(".") if take else ():
            if not hasattr(found, word):
                there = list(vars(found)) if hasattr(found, "__dict__") else []
                raise ModelError(f"what the rule '{rule}' gives has no '{word}'{did_you_mean(word, there)}")
            found = getattr(found, word)
        return found

    function.text = f"{rule} {take} {plain}"  # type: ignore[attr-defined]
    return Function(name, function, tuple(dict.fromkeys(results)), unit or "1", si=True)


def _listed(item: Any) -> list[Any]:
    return item if isinstance(item, list) else [item]


def _filled(item: Any, values: Mapping[str, Any]) -> Any:
    """An argument with values in place of the names of results; a list with some is a column of all of them."""
    if not isinstance(item, list):
        return values[item] if isinstance(item, str) else item
    if not any(isinstance(one, str) for one in item):
        return item
    return ca.vertcat(*(values[one] if isinstance(one, str) else one for one in item))
