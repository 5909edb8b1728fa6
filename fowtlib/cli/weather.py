"""The wind and the waves of a model in a line, in the words of `--wind` and `--waves`: the first line of an answer.

One rule for all commands: what `--wind` and `--waves` say, else what the model file says. A command that asks about a
mean position takes the mean of both: the wind steady at its mean speed, the water still.
"""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fowtlib.modelfile.short_forms import WAVES, WIND, Condition, Key, Kind

if TYPE_CHECKING:
    from fowtlib import Model

ALWAYS = ("class", "seed")  # said although they may be those that a part has by itself


def weather(model: Model, arguments: argparse.Namespace, mean_of: Model | None = None, whose: str = "") -> str:
    """`wind steady:8 (given), waves still (mean of the model's)`; "" for a model with neither.

    mean_of: the model before the mean of its wind and waves was taken. whose: where they come from, if known.
    """
    pieces = []
    for condition, word in ((WIND, "wind"), (WAVES, "waves")):
        if condition.part not in model.root.parts:
            continue
        text = _form(condition, model.root.parts[condition.part])
        before = _form(condition, mean_of.root.parts[condition.part]) if mean_of is not None else text
        own = "the model's" if before == text else "mean of the model's"
        source = whose or ("given" if getattr(arguments, word, None) else own)
        pieces.append(f"{word} {text} ({source})")
    return ", ".join(pieces)


def _form(condition: Condition, part: Any) -> str:
    """The kind and what was chosen of it, as the option is written."""
    name = getattr(part, condition.selector)
    kind = condition.kinds.get(name)
    if kind is None:
        return str(name)
    chosen = {
        key: item
        for key, item in kind.keys.items()
        if item.required or _differs(part, item.parameter) or (key in ALWAYS and not _instead(part, kind, key))
    }
    words = [
        _text(item, part.parameter_value(item.parameter)) if key == kind.bare
        else f"{key}={_text(item, part.parameter_value(item.parameter))}"
        for key, item in chosen.items()
    ]  # fmt: skip
    return f"{name}:{','.join(words)}" if words else str(name)


def _instead(part: Any, kind: Kind, key: str) -> bool:
    """True where another key was chosen that makes this one void."""
    return key in kind.either and any(
        _differs(part, kind.keys[other].parameter) for other in kind.either if other != key
    )


def _differs(part: Any, name: str) -> bool:
    """True where a parameter has not the value that its class gives it."""
    default, value = part.parameters[name].default, part.parameter_value(name)
    if callable(default):
        return False
    return value is not None and value != default


def _text(key: Key, value: Any) -> str:
    if value is None:  # what the kind needs and the model does not say; a run refuses it
        return "none"
    if key.unit == "path":
        return Path(value).name
    if isinstance(value, str):
        return value
    if getattr(value, "size", 1) != 1 or isinstance(value, (list, tuple)):
        return "list"  # where one number belongs; a run refuses it
    number = float(value)
    return f"{math.degrees(number) if key.unit == 'deg' else number:.6g}"
