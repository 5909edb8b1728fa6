"""The house keeps its floors: who may import whom, no circles, what a package lists, how long a component may be."""

from __future__ import annotations

import ast
import json
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path

import networkx as nx

ROOT = Path(__file__).parent.parent
FOLDERS = {"fowtlib": ROOT / "fowtlib", "fowtlib.components": ROOT / "components", "fowtlib.models": ROOT / "models"}

# Each floor may import itself and the floors below. Packages that share a floor may not import each other.
# "fowtlib" stands for what a user imports: the modules at the top of the package.
FLOORS = [
    {"fowtlib.language"},
    {"fowtlib.flattening"},
    {"fowtlib.solving"},
    {"fowtlib.fmi", "fowtlib.modelfile", "fowtlib.analysis", "fowtlib.cases", "fowtlib.control", "fowtlib.design",
     "fowtlib.frequency", "fowtlib.metocean", "fowtlib.report", "fowtlib.view"},
    {"fowtlib"},
    {"fowtlib.cli"},
]
KNOWS_NO_PHYSICS = 3  # the first floors must not import a part or a model
EVERYBODY_S = "fowtlib.analysis"  # works on arrays; every room of its floor may use it
# who reads and runs cases, or reads designs, needs the model; who writes about them needs the cases; a design asks for
# responses
NEIGHBOURS = {
    ("fowtlib.cases", "fowtlib.modelfile"), ("fowtlib.report", "fowtlib.cases"),
    ("fowtlib.design", "fowtlib.frequency"), ("fowtlib.design", "fowtlib.modelfile"),
}  # fmt: skip
LIBRARY = "fowtlib.components"
LIBRARY_MAY_IMPORT = {
    "fowtlib.language",
    LIBRARY,
    "numpy",
    "scipy",
    "casadi",  # only to make the Function that external() takes
    "capytaine",  # the optional pre-processor of hydrodynamic databases
    "fmpy",  # the optional runner of FMUs, which are sampled parts
}
SLOW_OR_OPTIONAL = {"matplotlib", "yaml", "jinja2", "pandas", "pint", "xarray", "rich", "networkx", "capytaine", "fmpy"}
LONGEST_COMPONENT = 60
LONGEST_WITH_HELPERS = 110
DATA = {".yaml", ".csv", ".nc", ".json", ".md", ".c", ".h", ".html", ".js", ".jinja"}


def modules() -> Iterator[tuple[str, Path]]:
    """Every module of the project as (dotted name, file)."""
    for package, folder in FOLDERS.items():
        for path in sorted(folder.rglob("*.py")):
            parts = path.relative_to(folder).with_suffix("").parts
            if parts[-1] == "__init__":
                parts = parts[:-1]
            yield ".".join((package, *parts)), path


def imports(path: Path, module: str, types: bool = True) -> Iterator[tuple[int, str]]:
    """Every import of a file as (line, dotted name), also inside functions and by name; `from a import b` gives a.b.

    types: also those for a type checker alone.
    """
    package = module if path.name == "__init__.py" else module.rpartition(".")[0]
    tree = ast.parse(path.read_text())
    unseen = set()
    if not types:
        for node in ast.walk(tree):
            if isinstance(node, ast.If) and isinstance(node.test, ast.Name) and node.test.id == "TYPE_CHECKING":
                unseen.update(id(inner) for statement in node.body for inner in ast.walk(statement))
    for node in ast.walk(tree):
        if id(node) in unseen:
            continue
        if isinstance(node, ast.Call) and _name(node.func) in ("import_module", "__import__"):
            yield from ((node.lineno, a.value) for a in node.args if isinstance(a, ast.Constant) and a.value)
        if isinstance(node, ast.Import):
            yield from ((node.lineno, alias.name) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = node.module or ""
            if node.level:
                anchor = package.split(".")[: len(package.split(".")) - node.level + 1]
                base = ".".join([*anchor, *([base] if base else [])])
            yield from ((node.lineno, f"{base}.{alias.name}") for alias in node.names)


def _name(function: ast.expr) -> str:
    return function.attr if isinstance(function, ast.Attribute) else getattr(function, "id", "")


def within(name: str, package: str) -> bool:
    return name == package or name.startswith(package + ".")


def floor_of(name: str) -> tuple[int, str] | None:
    """Floor number and package of a module; None for a part, a model or somebody else's package."""
    if within(name, LIBRARY) or within(name, "fowtlib.models"):
        return None
    found = [(number, package) for number, names in enumerate(FLOORS) for package in names if within(name, package)]
    return max(found, key=lambda pair: len(pair[1]), default=None)


def test_no_floor_imports_a_higher_one_or_a_neighbour():
    wrong = []
    for module, path in modules():
        here = floor_of(module)
        if here is None:
            continue
        for line, name in imports(path, module):
            there = floor_of(name)
            if there is not None:
                beside = there[0] == here[0] and there[1] != here[1] and there[1] != EVERYBODY_S
                beside = beside and (here[1], there[1]) not in NEIGHBOURS
                bad = there[0] > here[0] or beside
            else:
                bad = here[0] < KNOWS_NO_PHYSICS and name.startswith("fowtlib.")
            if bad:
                wrong.append(f"{path.relative_to(ROOT)}:{line}: {module} imports {name}")
    assert not wrong, "\n".join(wrong)


def import_graph(room: str, types: bool) -> nx.DiGraph:
    """Modules of a package with an edge for each import between them; a name in a module counts as the module."""
    inside = {module: path for module, path in modules() if within(module, room)}
    graph = nx.DiGraph()
    for module, path in inside.items():
        for line, name in imports(path, module, types):
            while name and name not in inside:
                name = name.rpartition(".")[0]
            if name and name != module:
                graph.add_edge(module, name, line=line)
    return graph


def test_no_room_has_a_circle_of_imports():
    """Neither at the top of modules nor inside of functions; of the library, types alone may be named both ways."""
    circles = []
    for room, types in (("fowtlib", True), (LIBRARY, False)):
        graph = import_graph(room, types)
        if room == "fowtlib":
            graph.remove_nodes_from([module for module in list(graph) if within(module, LIBRARY)])
            graph.remove_nodes_from(["fowtlib"])  # what a user imports comes from everywhere
        assert graph.number_of_edges() > 50
        for members in nx.strongly_connected_components(graph):
            if len(members) > 1:
                edges = graph.subgraph(members).edges(data="line")
                circles += [f"{a} imports {b} (line {line})" for a, b, line in sorted(edges)]
    assert not circles, "\n".join(circles)


def test_an_import_inside_of_a_function_and_one_by_name_are_seen(tmp_path):
    file = tmp_path / "module.py"
    file.write_text(
        "import importlib\nfrom typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from fowtlib.fmi import export\n"
        "def f():\n    from fowtlib.cli import app\n    return importlib.import_module('fowtlib.view')\n"
    )
    found = {name for _, name in imports(file, "fowtlib.solving.module")}
    assert {"fowtlib.fmi.export", "fowtlib.cli.app", "fowtlib.view"} <= found
    assert "fowtlib.fmi.export" not in {name for _, name in imports(file, "fowtlib.solving.module", types=False)}


def test_components_import_only_the_language_and_data_readers():
    allowed = LIBRARY_MAY_IMPORT | set(sys.stdlib_module_names)
    wrong = [
        f"{path.relative_to(ROOT)}:{line}: imports {name}"
        for module, path in modules()
        if within(module, LIBRARY)
        for line, name in imports(path, module)
        if not any(within(name, package) for package in allowed)
    ]
    assert not wrong, "\n".join(wrong)


def test_every_package_is_listed_and_every_listed_package_exists():
    with open(ROOT / "pyproject.toml", "rb") as file:
        setuptools = tomllib.load(file)["tool"]["setuptools"]
    assert sorted(setuptools["packages"]) == sorted(module for module, path in modules() if path.name == "__init__.py")
    assert setuptools["package-dir"] == {
        name: str(folder.relative_to(ROOT)) for name, folder in FOLDERS.items() if name != "fowtlib"
    }


def test_no_package_is_an_empty_promise():
    """A package holds more than its docstring."""
    empty = [
        str(path.parent.relative_to(ROOT))
        for _, path in modules()
        if path.name == "__init__.py"
        and not any(other != path and other.suffix in DATA | {".py"} for other in path.parent.rglob("*"))
    ]
    assert not empty, f"packages that hold nothing: {', '.join(empty)}"


def test_the_wheel_carries_the_models_and_their_data():
    """What setuptools would put into a wheel, asked from its own build step, without building one."""
    script = """
import json
from setuptools import Distribution
distribution = Distribution()
distribution.parse_config_files()
build = distribution.get_command_obj("build_py")
build.ensure_finalized()
build.manifest_files = {}
folders = [(package, build.get_package_dir(package)) for package in distribution.packages]
print(json.dumps([name for folder in folders for name in build.find_data_files(*folder)]))
"""
    run = subprocess.run([sys.executable, "-W", "ignore", "-c", script], cwd=ROOT, capture_output=True, text=True)
    assert run.returncode == 0, run.stderr

    carried = {str(Path(name)) for name in json.loads(run.stdout.splitlines()[-1])}
    data = {
        str(path.relative_to(ROOT))
        for folder in FOLDERS.values()
        for path in folder.rglob("*")
        if path.suffix in DATA and "__pycache__" not in path.parts
    }
    assert data <= carried, f"files a wheel would lack: {sorted(data - carried)}"


def test_import_is_light():
    """`import fowtlib` draws in nothing slow: no plotting, YAML, tables or unit package."""
    script = "import sys, fowtlib; print(*{name.partition('.')[0] for name in sys.modules})"
    run = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert not SLOW_OR_OPTIONAL & set(run.stdout.split())


def component_classes() -> Iterator[tuple[str, ast.ClassDef]]:
    """Every class of the component library as (place, definition)."""
    for module, path in modules():
        if within(module, LIBRARY):
            for node in ast.walk(ast.parse(path.read_text())):
                if isinstance(node, ast.ClassDef):
                    yield f"{path.relative_to(ROOT)}:{node.lineno}: {node.name}", node


def test_every_public_component_has_a_docstring():
    silent = [place for place, node in component_classes() if node.name[0] != "_" and not ast.get_docstring(node)]
    assert not silent, "\n".join(silent)


def statement_lines(node: ast.ClassDef) -> int:
    """Lines of a class that hold statements: no docstrings, comments or blank lines."""
    lines: set[int] = set()
    for inner in ast.walk(node):
        if not isinstance(inner, ast.stmt):
            continue
        if isinstance(inner, ast.Expr) and isinstance(inner.value, ast.Constant) and isinstance(inner.value.value, str):
            continue
        last = inner.end_lineno if not getattr(inner, "body", None) else inner.body[0].lineno - 1
        lines.update(range(inner.lineno, max(inner.lineno, last) + 1))
    return len(lines)


Functions = dict[str, ast.FunctionDef]


def library_functions() -> dict[str, Functions]:
    """By module of the component library: its functions by name, and those that it imports from the library."""
    trees = {module: ast.parse(path.read_text()) for module, path in modules() if within(module, LIBRARY)}
    own = {name: {n.name: n for n in tree.body if isinstance(n, ast.FunctionDef)} for name, tree in trees.items()}
    imported = {
        name: {
            (alias.asname or alias.name): own[item.module][alias.name]
            for item in ast.walk(tree) if isinstance(item, ast.ImportFrom) and item.module in own
            for alias in item.names if alias.name in own[item.module]
        }
        for name, tree in trees.items()
    }  # fmt: skip
    return {name: imported[name] | own[name] for name in trees}


def helpers(node: ast.AST, argument: str, functions: Functions, found: Functions) -> None:
    """Collect functions that take the component, as their first argument, from a method or from another of them."""
    for call in ast.walk(node):
        if isinstance(call, ast.Call) and isinstance(call.func, ast.Name) and call.args:
            function = functions.get(call.func.id)
            if function is not None and function.args.args and _name(call.args[0]) == argument:
                _take(function, functions, found)


def _take(function: ast.FunctionDef, functions: Functions, found: Functions) -> None:
    if function.name not in found:
        found[function.name] = function
        helpers(function, function.args.args[0].arg, functions, found)


def lengths() -> list[tuple[int, int, str]]:
    """Statement lines of each component, with the functions that take it and without; and its place; longest first."""
    functions, rows = library_functions(), []
    for module, path in modules():
        if not within(module, LIBRARY):
            continue
        for node in ast.walk(ast.parse(path.read_text())):
            if not isinstance(node, ast.ClassDef) or not any(
                isinstance(item, ast.FunctionDef) and item.name in ("equations", "build") for item in node.body
            ):
                continue
            found: Functions = {}
            helpers(node, "self", functions[module], found)
            for function in functions[module].values():
                given = function.args.args[0].annotation if function.args.args else None
                if given is not None and ast.unparse(given).strip("'\"") == node.name:
                    _take(function, functions[module], found)
            own = statement_lines(node)
            whole = own + sum(statement_lines(function) for function in found.values())
            rows.append((whole, own, f"{path.relative_to(ROOT)}:{node.lineno}: {node.name}"))
    return sorted(rows, reverse=True)


def test_a_component_is_short():
    """A class with equations fits one page, and two with the functions that take it; a longer one is made of parts."""
    long = [
        f"{place} has {own} lines of statements, {whole} with the functions that take it"
        for whole, own, place in lengths()
        if (own > LONGEST_COMPONENT and "MooringSystem" not in place)
        or whole > LONGEST_WITH_HELPERS
    ]
    assert not long, "\n".join(long)
