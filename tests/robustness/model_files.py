"""Model files to start from, and what strangers and slips may make of them: by structure, by text, by bytes."""

from __future__ import annotations

import random
import re
from collections.abc import Callable, Iterator
from itertools import islice
from pathlib import Path
from typing import Any

import yaml

LONG = 60_000  # letters; what is longer is not changed once more
ROOT = Path(__file__).parents[2]
Document = dict[str, Any]

NUMBERS = ["0", "-1", "1e18", "1e308", "1e400", "-1e-320", ".inf", "-.inf", ".nan", "nan", "inf m",
           "99999999999999999999", "0.0000000001", "1e18 m", "3 m/s^9", "1e309 kg", "7_000", "0x10", "1e", "--1", "1.2.3",
           "١٢", "½"]  # fmt: skip
WORDS = ["", " ", "~", "null", "true", "no", "a.b.c", "..", "x[0]", "x[99999999999]", "{name}", "{}", "m" * 300,
         "*a", "&a", "!!python/object:os.system", "!tag x", "\u0000", "\ud7ff", "\u202e", "é" * 40,
         "data:../../etc/passwd", "/dev/zero", "/proc/self/mem", "../" * 60, "motion", "World", "PointMass", "Sea",
         "oc3_spar_rigid.yaml", "C:\\x", "a" * 5000, "%s%n", "'", '"', "#", ": :", "- -", "\t", "$(true)", "`true`", "con", "class", "each"]  # fmt: skip
FORMULAS = ["1/0", "10**10**10", "9**9**9**9", "2^1e9", "-" * 400 + "1", "(" * 200 + "1" + ")" * 200, "1" + "+1" * 240,
            "sqrt(-1)", "exp(1e9)", "log(0)", "pi[0]", "a[0]", "sin(1 m)", "1 m + 1 kg", "max(1)",
            "min(1,2,3)", "atan2(0,0)", "x**x**x", "(1", "1)", "1 2", "**", "2*", "1e308*10", "0*1e400", "1 m^1e9",
            "1 m^0.123456789"]  # fmt: skip
KEYS = ["fowtlib", "class", "use", "parameters", "parts", "each", "for", "connect", "ports", "outputs", "simulation",
        "python", "title", "value", "unit", "min", "max", "of", "description", "mass", "r", "n", "name", "solver", "duration",
        "step", "output_step", "tolerance", "world", "sea", "wind", "spectrum", "kind"]  # fmt: skip
UNITS = [
    " m",
    " kg",
    " deg",
    " rpm",
    " furlong",
    " m^99999",
    " m**",
    " %",
    " °",
    " kN*m/s^2/rad",
    " m" * 30,
    " µm",
    " Hz",
]


def seeds() -> dict[str, str]:
    """Texts of model files by name: the shipped ones and those that stand in the tests."""
    found = {f"{path.stem}": path.read_text(encoding="utf-8") for path in sorted((ROOT / "models").glob("*.yaml"))}
    for path in sorted((ROOT / "tests").rglob("test_*.py")):
        texts = re.findall(r'"""(?:\\\n)?(fowtlib: 1\n.*?)"""', path.read_text(encoding="utf-8"), re.S)
        for i, text in enumerate(texts):
            if _is_document(text):
                found[f"{path.stem}_{i}"] = text
    return found


def _is_document(text: str) -> bool:
    try:
        return isinstance(yaml.load(text, yaml.BaseLoader), dict)
    except yaml.YAMLError:
        return False


def mutated(text: str, chance: random.Random) -> bytes:
    """One mutation of a model file, or a few on top of each other."""
    for _ in range(chance.choice((1, 1, 1, 2, 4))):
        if len(text) > LONG:
            break
        kind = chance.random()
        try:
            if kind < 0.6:
                text = _by_structure(text, chance)
            elif kind < 0.8:
                text = chance.choice(TEXTUAL)(text, chance)
            else:
                return by_bytes(text.encode("utf-8", "surrogatepass"), chance)
        except (yaml.YAMLError, RecursionError, ValueError, TypeError):
            text = chance.choice(TEXTUAL)(text, chance)
    return text.encode("utf-8", "surrogatepass")


def by_bytes(content: bytes, chance: random.Random) -> bytes:
    """Bits turned, bytes put in, taken out, doubled, cut off."""
    data = bytearray(content)
    for _ in range(chance.choice((1, 1, 2, 8, 64))):
        if not data:
            break
        at = chance.randrange(len(data))
        kind = chance.randrange(7)
        length = min(chance.choice((1, 1, 2, 4, 8, 64, 512)), len(data) - at)
        if kind == 0:
            data[at] ^= 1 << chance.randrange(8)
        elif kind == 1:
            data[at : at + length] = chance.randbytes(length)
        elif kind == 2:
            del data[at : at + length]
        elif kind == 3:
            data[at:at] = data[at : at + length]
        elif kind == 4:
            data[at : at + length] = bytes([chance.choice((0, 255, 127, 128))]) * length
        elif kind == 5:
            data[at:at] = chance.randbytes(length)
        elif chance.random() < 0.3:
            del data[at:]
    return bytes(data)


# --- by structure -----------------------------------------------------------------------------------


def _by_structure(text: str, chance: random.Random) -> str:
    document = yaml.load(text, yaml.BaseLoader)
    places = list(islice(_places(document), 20_000))  # aliases in aliases have no end
    if not places:
        return text
    chance.choice(STRUCTURAL)(document, places, chance)
    return yaml.dump(document, Dumper=_Dumper, sort_keys=False, default_flow_style=None, allow_unicode=True, width=200)


class _Dumper(yaml.SafeDumper):
    """Writes plain scalars without quotes where YAML allows it, so that numbers stay numbers."""

    yaml_implicit_resolvers: dict[Any, Any] = {}


Place = tuple[Any, Any]  # a container and a key of it


def _places(value: Any) -> Iterator[Place]:
    for key, item in list(value.items() if isinstance(value, dict) else enumerate(value)):
        yield value, key
        if isinstance(item, (dict, list)):
            yield from _places(item)


def _leaf(places: list[Place], chance: random.Random) -> Place:
    leaves = [place for place in places if not isinstance(place[0][place[1]], (dict, list))]
    return chance.choice(leaves or places)


def _number(_: Document, places: list[Place], chance: random.Random) -> None:
    owner, key = _leaf(places, chance)
    old = owner[key]
    new = chance.choice(NUMBERS)
    match = re.fullmatch(r"\s*[-+.\deE]+(\s+.*)", old) if isinstance(old, str) else None
    owner[key] = new + (match[1] if match and chance.random() < 0.7 else "")


def _word(_: Document, places: list[Place], chance: random.Random) -> None:
    owner, key = _leaf(places, chance)
    owner[key] = chance.choice(WORDS)


def _formula(_: Document, places: list[Place], chance: random.Random) -> None:
    owner, key = _leaf(places, chance)
    owner[key] = chance.choice(FORMULAS)


def _unit(_: Document, places: list[Place], chance: random.Random) -> None:
    owner, key = _leaf(places, chance)
    owner[key] = str(owner[key]) + chance.choice(UNITS)


def _key(_: Document, places: list[Place], chance: random.Random) -> None:
    owner, key = chance.choice(places)
    if isinstance(owner, dict):
        new = chance.choice([*KEYS, *WORDS]) if chance.random() < 0.8 else key[:-1]
        items = [(new if name == key else name, item) for name, item in owner.items()]
        owner.clear()
        owner.update(items)


def _lose(_: Document, places: list[Place], chance: random.Random) -> None:
    owner, key = chance.choice(places)
    del owner[key]


def _swap(_: Document, places: list[Place], chance: random.Random) -> None:
    (a, i), (b, k) = chance.choice(places), chance.choice(places)
    a[i], b[k] = b[k], a[i]


def _nest(_: Document, places: list[Place], chance: random.Random) -> None:
    owner, key = chance.choice(places)
    deep, value = chance.choice((1, 2, 5, 60, 400)), owner[key]
    for _ in range(deep):
        value = [value] if chance.random() < 0.5 else {chance.choice(KEYS): value}
    owner[key] = value


def _many(_: Document, places: list[Place], chance: random.Random) -> None:
    owner, key = chance.choice(places)
    count = chance.choice((2, 10, 1000, 20_000))
    value = owner[key]
    small = not isinstance(value, (dict, list))
    if isinstance(value, list) and len(value) < 8 and count <= 1000:
        owner[key] = value * count
    elif small:
        owner[key] = [value] * count
    else:
        owner[key] = [value] * min(count, 10)


def _alias(document: Document, places: list[Place], chance: random.Random) -> None:
    """The same data in many places; YAML writes aliases for it. Rarely in itself."""
    source, key = chance.choice(places)
    value = source[key]
    for _ in range(chance.choice((1, 3, 9))):
        owner, name = chance.choice(places)
        owner[name] = value
    if isinstance(value, (dict, list)) and chance.random() < 0.3:
        for _ in range(chance.choice((3, 12))):
            value = [value] * 6
        source[key] = value


def _each(document: Document, places: list[Place], chance: random.Random) -> None:
    """`each` in `each`: rounds multiply."""
    count, deep = chance.choice((2, 10, 100)), chance.choice((1, 2, 4, 8))
    name = "p" + "".join(f"_{{v{i}}}" for i in range(deep))
    block: Document = {
        "for": [{f"v{deep - 1}": str(k)} for k in range(count)],
        "parts": {name: {"class": "PointMass", "mass": "1"}},
    }
    for i in reversed(range(deep - 1)):
        block = {"for": [{f"v{i}": str(k)} for k in range(count)], "each": [block]}
    document["each"] = [block]


def _chain(document: Document, places: list[Place], chance: random.Random) -> None:
    """Parameters that use each other again and again."""
    count = chance.choice((5, 40, 400))
    power = chance.choice(("{0}+{0}", "{0}*{0}", "{0}+1", "{0}**{0}", "max({0},{0})"))
    chain = {"q0": "1"} | {f"q{i}": power.format(f"q{i - 1}") for i in range(1, count)}
    document["parameters"] = chain | (
        document.get("parameters") if isinstance(document.get("parameters"), dict) else {}
    )
    owner, key = _leaf(places, chance)
    owner[key] = f"q{count - 1}"


def _declare(document: Document, places: list[Place], chance: random.Random) -> None:
    value = chance.choice([["1", ["2"]], [["1"]], {"value": "1"}, "1", [], {}, *NUMBERS, *WORDS[:12]])
    document.setdefault("parameters", {})
    if isinstance(document["parameters"], dict):
        document["parameters"]["qq"] = {"value": "3", "unit": "m"} | {
            chance.choice(("min", "max", "value", "unit", "description")): value
        }
        owner, key = _leaf(places, chance)
        owner[key] = "qq"


STRUCTURAL = [_number, _number, _number, _word, _word, _formula, _unit, _key, _key, _lose, _lose, _swap, _nest, _many, _alias,
              _each, _chain, _declare]  # fmt: skip


# --- by text ----------------------------------------------------------------------------------------


def _line_lost(text: str, chance: random.Random) -> str:
    lines = text.splitlines()
    del lines[chance.randrange(len(lines)) :][: chance.choice((1, 3))]
    return "\n".join(lines)


def _line_doubled(text: str, chance: random.Random) -> str:
    lines = text.splitlines()
    at = chance.randrange(len(lines))
    return "\n".join([*lines[:at], *([lines[at]] * chance.choice((2, 2, 3000))), *lines[at + 1 :]])


def _indented(text: str, chance: random.Random) -> str:
    lines = text.splitlines()
    at = chance.randrange(len(lines))
    lines[at] = chance.choice((" ", "  ", "\t", "    ")) + lines[at] if chance.random() < 0.6 else lines[at].lstrip()
    return "\n".join(lines)


def _piece(text: str, chance: random.Random) -> str:
    at, length = chance.randrange(len(text) + 1), chance.choice((0, 1, 5, 40))
    put = chance.choice(
        [*WORDS, *NUMBERS, *FORMULAS, "[" * 3000, "{a: " * 1500, "&x [*x]", "\n---\n", "\n...\n", "? ", "|\n", ">-\n"]
    )
    return text[:at] + put + text[at + length :]


def _other_word(text: str, chance: random.Random) -> str:
    """A word becomes another one of the same file."""
    found = list(re.finditer(r"[\w.]+", text))
    if len(found) < 2:
        return text
    a, b = chance.choice(found), chance.choice(found)
    return text[: a.start()] + b[0] + text[a.end() :]


TEXTUAL: list[Callable[[str, random.Random], str]] = [
    _line_lost,
    _line_doubled,
    _indented,
    _piece,
    _piece,
    _other_word,
    _other_word,
]
