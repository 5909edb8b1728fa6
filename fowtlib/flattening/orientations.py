"""Step 2b: the orientation graph: definitions along a spanning tree; a loop gives three equations, not nine."""

from __future__ import annotations

from typing import TYPE_CHECKING

import casadi as ca

from fowtlib.flattening.instances import Statements
from fowtlib.flattening.system import Intermediate, Loop, System, scalars
from fowtlib.language.connectors import BoundPort
from fowtlib.language.equations import Assertion, Rotation
from fowtlib.language.errors import ConnectionFault

if TYPE_CHECKING:
    import networkx as nx


def resolve_orientations(system: System, statements: Statements) -> nx.MultiGraph:
    """Define the rotation matrix of every frame from the roots outwards; returns the graph of the relations."""
    import networkx as nx

    graph = nx.MultiGraph()
    matrices: dict[int, tuple[str, ca.SX, ca.SX]] = {}
    roots: dict[int, str] = {}

    def node(frame: BoundPort) -> int:
        name, member = next((n, m) for n, m in frame.connector.members.items() if m.kind == "orientation")
        R = getattr(frame, name)
        key = R.elements()[0].element_hash()
        matrices.setdefault(key, (frame.path, R, getattr(frame, member.angular_velocity)))
        return key

    for path, fixed in statements.fixed_orientations:
        key = node(fixed.frame)
        if key in roots:
            raise ConnectionFault(
                f"{system.placed(path)}the orientation of {fixed.frame.path} is fixed twice, "
                f"by {roots[key]} and by {path or 'the model'}; "
                "one of them must leave it free."
            )
        roots[key] = path or "the model"
        graph.add_node(key)
        _, R, w = matrices[key]
        _define(system, R, fixed.R, path)
        system.add_equation(w, fixed.w, path, fixed.source)
    for path, rotation in statements.rotations:
        graph.add_edge(node(rotation.frame_a), node(rotation.frame_b), data=(path, rotation))

    parents: dict[int, tuple[int, tuple[str, Rotation]]] = {}
    done: set[int] = set()
    used: set[int] = set()
    for root in roots:
        if root in done:
            raise ConnectionFault(
                f"{system.placed(roots[root])}the orientation of {matrices[root][0]} is fixed by {roots[root]}, "
                "and so is that of a frame "
                "that it is joined to; one of them must leave it free."
            )
        done.add(root)
        system.joints_below[root], front = 0, [root]
        while front:
            following = []
            for known in front:
                for neighbour, edges in graph.adj[known].items():
                    for attributes in edges.values():
                        if neighbour in done or id(attributes["data"]) in used:
                            continue
                        used.add(id(attributes["data"]))
                        _tree_edge(system, matrices, known, node, *attributes["data"])
                        parents[neighbour] = known, attributes["data"]
                        done.add(neighbour)
                        system.joints_below[neighbour] = system.joints_below[known] + 1
                        following.append(neighbour)
            front = following
    frames = {key: path for key, (path, _, _) in matrices.items()}
    frames |= {R.elements()[0].element_hash(): path for path, R in system.orientations}
    loose = [path for key, path in frames.items() if key not in done]
    if loose:
        raise ConnectionFault(
            f"{system.placed(loose[0])}the orientation of {_some(loose)} is not tied to the world; "
            "join it by a joint, a fixed part or a FreeMotion to the World."
        )
    for _, _, attributes in graph.edges(data=True):
        if id(attributes["data"]) not in used:
            statements.assertions.append(_closing_edge(system, *attributes["data"]))
            path, closing = attributes["data"]
            ring = _ring(parents, node(closing.frame_a), node(closing.frame_b))
            system.loops.append(_loop(system, [(path, closing), *ring]))
    return graph


def _ring(parents: dict, a: int, b: int) -> list[tuple[str, Rotation]]:
    """The edges of the spanning tree between two frames."""

    def upwards(key: int) -> dict[int, tuple[str, Rotation]]:
        edges = {}
        while key in parents:
            above, edge = parents[key]
            edges[key], key = edge, above
        return edges

    left, right = upwards(a), upwards(b)
    return [edge for key, edge in left.items() if key not in right] + [
        edge for key, edge in right.items() if key not in left
    ]


def _loop(system: System, edges: list[tuple[str, Rotation]]) -> Loop:
    owners = {unknown.path.rpartition(".")[0] for unknown in system.unknowns if not unknown.order}
    turning = sum(not rotation.w_rel.is_constant() for _, rotation in edges)
    moving = sum(path in owners for path, rotation in edges if rotation.w_rel.is_constant())
    return Loop([path or "the model" for path, _ in edges], turning, moving)


def _some(paths: list[str]) -> str:
    return ", ".join(paths[:3]) + (f" and {len(paths) - 3} more" if len(paths) > 3 else "")


def _members(frame: BoundPort) -> tuple[ca.SX, ca.SX]:
    name, member = next((n, m) for n, m in frame.connector.members.items() if m.kind == "orientation")
    return getattr(frame, name), getattr(frame, member.angular_velocity)


def _tree_edge(system, matrices, known, node, path, rotation) -> None:
    R_a, w_a = _members(rotation.frame_a)
    R_b, w_b = _members(rotation.frame_b)
    if node(rotation.frame_a) == known:
        _define(system, R_b, R_a @ rotation.R_rel, path)
    else:
        _define(system, R_a, R_b @ rotation.R_rel.T, path)
    system.add_equation(w_b, w_a + R_a @ rotation.w_rel, path, rotation.source)


def _closing_edge(system, path, rotation) -> tuple[str, Assertion]:
    """Three independent equations for R_b = R_a @ R_rel: the skew part of their quotient is zero.

    So it is, too, where the quotient is half a turn about some axis, which is no closed loop: that is checked.
    """
    quotient = _members(rotation.frame_b)[0].T @ _members(rotation.frame_a)[0] @ rotation.R_rel
    residual = 0.5 * ca.vertcat(
        quotient[2, 1] - quotient[1, 2], quotient[0, 2] - quotient[2, 0], quotient[1, 0] - quotient[0, 1]
    )
    system.add_equation(residual, ca.SX(3, 1), path, rotation.source)
    message = "its two frames meet turned by half a turn: give the joints of this loop start angles nearer to the place"
    return path, Assertion(ca.trace(quotient) > 0, message, "error", rotation.source)


def _define(system: System, R: ca.SX, value: ca.SX, path: str) -> None:
    symbols = scalars(R)
    matrix = symbols[0].name().removesuffix("_0")  # CasADi numbers the elements of a matrix symbol
    system.intermediates.append(Intermediate(symbols, ca.densify(ca.vec(value)), None, path, matrix))
