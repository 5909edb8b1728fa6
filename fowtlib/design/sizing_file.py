"""`read_sizing`: targets and free sizes as a file, with the line in every error. Its layout: docs/sizing.md."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from fowtlib.design.sizing import Sized, size
from fowtlib.language.data_files import require_file
from fowtlib.language.errors import ModelError, ModelFileError
from fowtlib.modelfile import files, load
from fowtlib.modelfile.nodes import Node, parse, read_text
from fowtlib.modelfile.permit import permit_for
from fowtlib.modelfile.specs import check_keys, check_version, mapping, text

KEY, VERSION = "fowtlib_sizing", 1
FIRST_LINE = f"a file of targets begins with '{KEY}: {VERSION}'"
KEYS = (KEY, "title", "description", "model", "set", "free", "targets", "objective")

Loader = Callable[[Path], Any]


@dataclass(frozen=True, eq=False)
class SizingFile:
    """What a file asks for; model: as it is loaded, with what the file sets."""

    path: Path
    title: str
    model: Any
    free: Mapping[str, Any]
    targets: Mapping[str, Any]
    objective: str | Mapping[str, float] | None
    top: Node = field(repr=False)

    def found(self) -> Sized:
        """The sizes; errors have the line of the name that they begin with or are about."""
        try:
            return size(self.model, self.free, self.targets, objective=self.objective)
        except ModelError as error:
            raise self._located(error) from None

    def _located(self, error: ModelError) -> ModelError:
        against = getattr(error, "against", ())
        for key in ("targets", "free"):
            for name, node in self.top.value[key].value.items():
                if name in against or (not against and f"'{name}'" in error.message):
                    return error.at(str(node.place))
        return error.at(self.top.place.file)


def read_sizing(source: str | os.PathLike[str], *, load_model: Loader | None = None) -> SizingFile:
    """The targets of a file; load_model: in place of `fw.load`.

    Raises ModelFileError: the file and line, what is wrong, what to do.
    """
    path = Path(source)
    if not files.is_file(path):
        here = [item.name for item in sorted(path.parent.glob("*.y*ml"))] if path.parent.is_dir() else []
        raise files.no_file(source, here)
    require_file(path, ModelFileError)
    name = files.shown(path)
    top = parse(read_text(path, name), name, FIRST_LINE)
    items = mapping(top, f"{FIRST_LINE}, and is a mapping")
    check_version(items, top.place, KEY, VERSION, FIRST_LINE)
    check_keys(items, KEYS, "a file of targets")
    for key in ("model", "free", "targets"):
        if key not in items:
            raise top.place.error(f"the key '{key}' is missing.")
    plain = {}
    for key in ("free", "targets", "set"):
        nodes = mapping(items[key], f"'{key}' is a mapping of names and values") if key in items else {}
        plain[key] = {name: node.plain() for name, node in nodes.items()}
    objective = items["objective"].plain() if "objective" in items else None
    if objective is not None and not isinstance(objective, (str, dict)):
        raise items["objective"].place.error("'objective' is the name of a result, or results with their factors.")
    model = _model(path, items, plain["set"], load_model or load)
    return SizingFile(path, text(items, "title") or path.stem, model, plain["free"], plain["targets"], objective, top)


def _model(path: Path, items: Mapping[str, Node], given: Mapping[str, Any], load_model: Loader) -> Any:
    name = text(items, "model")
    try:
        permit = permit_for(path, files.models_folder(), (), trust=False)
        beside = files.data_place(name, path.absolute().parent, permit) if name.endswith(".yaml") else None
        model = load_model(beside if beside is not None and files.is_file(beside) else Path(name))
        return model.with_parameters(given) if given else model
    except ModelError as error:
        raise error.at(str(items["model"].place)) from None
