"""Plain data -> YAML text as a person would write it: block style, short lists and mappings in one line."""

from __future__ import annotations

from typing import Any

from fowtlib.modelfile.nodes import looks_like_text


def to_text(document: dict[str, Any]) -> str:
    """YAML that `nodes.parse` reads as the same data."""
    import yaml

    class Dumper(yaml.SafeDumper):
        yaml_implicit_resolvers: dict[Any, Any] = {}  # our reader alone says what a plain scalar means

        def ignore_aliases(self, data: Any) -> bool:
            return True

        def increase_indent(self, flow: bool = False, indentless: bool = False) -> None:
            super().increase_indent(flow, False)

    def scalar(dumper: yaml.SafeDumper, value: Any) -> yaml.Node:
        quoted = isinstance(value, str) and not looks_like_text(value)
        text = value if isinstance(value, str) else _word(value)
        return dumper.represent_scalar("tag:yaml.org,2002:str", text, style='"' if quoted else None)

    for kind in (str, bool, int, float, type(None)):
        Dumper.add_representer(kind, scalar)
    return yaml.dump(document, Dumper=Dumper, sort_keys=False, default_flow_style=None, width=110, allow_unicode=True)


def _word(value: bool | float | None) -> str:
    if value is None or isinstance(value, bool):
        return {None: "null", True: "true", False: "false"}[value]
    return {float("inf"): ".inf", float("-inf"): "-.inf"}.get(value, repr(value))
