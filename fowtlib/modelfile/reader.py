"""The keys of one component of a model file -> its `Spec`, with `each` blocks repeated."""

from __future__ import annotations

from collections.abc import Iterator

from fowtlib.language.errors import did_you_mean
from fowtlib.language.unit_grammar import is_common_name
from fowtlib.modelfile.nodes import Node
from fowtlib.modelfile.specs import (
    Connection,
    Declared,
    Document,
    OutputSpec,
    Spec,
    Value,
    Variables,
    as_list,
    check_keys,
    identifier,
    mapping,
    substituted,
    text,
    text_node,
    words,
)

PART_KEYS = ("class", "use", "parameters", "parts", "each", "connect", "ports")
DEFINITION_KEYS = ("fowtlib", "title", "description", "python", *PART_KEYS)
MODEL_KEYS = (*DEFINITION_KEYS, "outputs", "simulation", "events")
EACH_KEYS = ("for", "parts", "connect", "each", "ports", "outputs")
PARAMETER_KEYS = ("value", "unit", "description", "min", "max")
OUTPUT_KEYS = ("of", "unit", "description")


class ComponentReader:
    """Reads the keys of components; the document collects outputs, which `each` blocks at the top may add."""

    def __init__(self, document: Document):
        self.document = document

    def component(self, spec: Spec, items: dict[str, Node], variables: Variables, top_level: bool = False) -> None:
        """Put what the keys of a component say into `spec`."""
        for key, node in items.items():
            if key == "class":
                spec.class_name = Value(text_node(node, "the name of a class"), variables)
            elif key == "use":
                spec.use = Value(text_node(node, "the name of a definition file"), variables)
            elif key == "parameters":
                self.parameters(spec, node, variables)
            elif key in ("parts", "connect", "ports"):
                getattr(self, key)(spec, node, variables)
            elif key == "each":
                for block in as_list(node):
                    self.each(spec, block, variables, top_level)
            elif top_level and isinstance(node.value, dict) and {"class", "use"} & set(node.value):
                self.part(spec, key, node, variables)
            elif top_level and not ({"class", "use"} & set(items)):
                hint = did_you_mean(key, MODEL_KEYS, list_up_to=0)
                raise node.place.error(f"'{key}' is not a key of a model file{hint} A part needs 'class' or 'use'.")
            else:
                spec.values[key] = Value(node, variables)
        self._check_used(items)
        if spec.class_name and spec.use:
            raise spec.use.place.error("give 'class' or 'use', not both; 'use' takes the class from the definition.")

    @staticmethod
    def _check_used(items: dict[str, Node]) -> None:
        """Every declared parameter is used by something beside its own declaration."""
        declared = items["parameters"].value if "parameters" in items else {}
        places = {key: node for key, node in items.items() if key != "parameters"}
        used = {word for node in (*places.values(), *declared.values()) for word in words(node)}
        for name, node in declared.items():
            if name not in used:
                raise node.place.error(f"nothing uses the parameter '{name}'.")

    def parts(self, spec: Spec, node: Node, variables: Variables) -> None:
        for key, item in mapping(node, "'parts' is a mapping: name: {class: ...}").items():
            self.part(spec, key, item, variables)

    def part(self, spec: Spec, key: str, node: Node, variables: Variables) -> None:
        self.document.repeat(node.place)
        name = identifier(substituted(key, variables, node.place), "part", node.place)
        if name in spec.parts:
            first = spec.parts[name].place
            raise node.place.error(f"the part '{name}' is given twice; the first is in line {first.line}.")
        if isinstance(node.value, str):
            example = f"{key}: {{class: {node.value}}}"
            raise node.place.error(f"a part is a mapping; write '{example}', or 'use' for a definition file.")
        inner = Spec(node.place)
        self.component(inner, mapping(node, f"the part '{name}' is a mapping with 'class' or 'use'"), variables)
        spec.parts[name] = inner

    def parameters(self, spec: Spec, node: Node, variables: Variables) -> None:
        for name, item in mapping(node, "'parameters' is a mapping: name: value").items():
            identifier(name, "parameter", item.place)
            if is_common_name(name) or name in PART_KEYS or name == "pi":
                what = "the name of a unit" if is_common_name(name) else "a word of the model file"
                raise item.place.error(f"a parameter cannot be called '{name}', which is {what}; choose a longer name.")
            spec.parameters[name] = self._declared(name, item, variables)

    def _declared(self, name: str, node: Node, variables: Variables) -> Declared:
        if not isinstance(node.value, dict):
            return Declared(Value(node, variables))
        check_keys(node.value, PARAMETER_KEYS, f"parameter '{name}'")
        if "value" not in node.value:
            raise node.place.error(f"the parameter '{name}' has no 'value'.")
        bounds = {key: Value(node.value[key], variables) for key in ("min", "max") if key in node.value}
        value = Value(node.value["value"], variables)
        return Declared(value, text(node.value, "unit"), text(node.value, "description"), **bounds)

    def connect(self, spec: Spec, node: Node, variables: Variables) -> None:
        for item in as_list(node):
            self.document.repeat(item.place)
            ends = item.value if isinstance(item.value, list) else []
            if len(ends) < 2 or not all(isinstance(end.value, str) for end in ends):
                raise item.place.error("a connection is a list of two ports (or more): [body.frame_b, tower.frame_a].")
            names = tuple(substituted(end.value, variables, end.place) for end in ends)
            spec.connections.append(Connection(names, item.place))

    def ports(self, spec: Spec, node: Node, variables: Variables) -> None:
        for key, item in mapping(node, "'ports' is a mapping: name: port of a part").items():
            name = identifier(substituted(key, variables, item.place), "port", item.place)
            if not isinstance(item.value, str):
                raise item.place.error(f"the port '{name}' stands for a port of a part, such as body.frame_a.")
            if name in spec.ports:
                raise item.place.error(f"the port '{name}' is given twice.")
            spec.ports[name] = (substituted(item.value, variables, item.place), item.place)

    def each(self, spec: Spec, block: Node, outer: Variables, top_level: bool) -> None:
        """Repeat what is in the block for every mapping of its `for`."""
        items = mapping(block, "'each' is a list of blocks with 'for' and 'parts' or 'connect'")
        allowed = [key for key in EACH_KEYS if top_level or key != "outputs"]
        check_keys(items, allowed, "'each'")
        if "for" not in items:
            raise block.place.error("the block has no 'for'; write 'for: [{name: left}, {name: right}]'.")
        for variables in self._rounds(items, outer):
            self.document.repeat(block.place)
            for key in ("parts", "connect", "ports"):
                if key in items:
                    getattr(self, key)(spec, items[key], variables)
            for inner in as_list(items["each"]) if "each" in items else ():
                self.each(spec, inner, variables, top_level)
            if "outputs" in items:
                self.outputs(items["outputs"], variables)

    @staticmethod
    def _rounds(items: dict[str, Node], outer: Variables) -> Iterator[Variables]:
        used = {word for key, node in items.items() if key != "for" for word in words(node)}
        first: dict[str, Node] | None = None
        for item in as_list(items["for"]):
            given = mapping(item, "'for' is a list of mappings, such as {name: left, side: 1}")
            first = first if first is not None else given
            if set(given) != set(first):
                both = f"{_listed(given)} and {_listed(first)}"
                raise item.place.error(f"the mappings of 'for' have different keys: {both}.")
            for name, node in given.items():
                identifier(name, "variable", node.place)
                if isinstance(node.value, (list, dict)) or node.value is None:
                    raise node.place.error(f"'{name}' is {node.kind}; a variable of 'for' is a number or text.")
            yield {**outer, **given}
        for name, node in (first or {}).items():
            if name not in used:
                raise node.place.error(f"nothing in the block uses '{name}'.")

    def outputs(self, node: Node, variables: Variables) -> None:
        """Named results: `name: path` or `name: {of: path, unit: deg, description: ...}`."""
        for key, item in mapping(node, "'outputs' is a mapping: name: path of a variable").items():
            self.document.repeat(item.place)
            name = identifier(substituted(key, variables, item.place), "output", item.place)
            entries = item.value if isinstance(item.value, dict) else {"of": item}
            check_keys(entries, OUTPUT_KEYS, f"output '{name}'")
            if not text(entries, "of"):
                raise item.place.error(f"the output '{name}' has no 'of', the path of a variable.")
            if name in self.document.outputs:
                raise item.place.error(f"the output '{name}' is given twice.")
            path = substituted(text(entries, "of"), variables, item.place)
            description = substituted(text(entries, "description"), variables, item.place)
            self.document.outputs[name] = OutputSpec(path, item.place, text(entries, "unit"), description)


def _listed(items: dict[str, Node]) -> str:
    return ", ".join(items) or "none"
