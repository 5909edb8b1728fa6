"""Properties of the kernel on random systems: networks against NumPy, graph algorithms, aliases, repeatability."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

import fowtlib as fw
from fowtlib.components.mechanics import FixedFlange, IdealGear, Inertia, TorsionSpringDamper
from fowtlib.flattening import flatten, structure
from fowtlib.language import Component, Connector, Scalar, der, eq, flow, param, port, potential, var
from fowtlib.solving import Model

settings.register_profile("kernel", deadline=None, max_examples=25, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("kernel")


class Pin(Connector):
    v = potential(unit="V", doc="potential")
    i = flow(unit="A", doc="current into the component")


class TwoPins(Component):
    p: Pin = port(optional=True, doc="positive pin; no current when open")
    n: Pin = port(optional=True, doc="negative pin; no current when open")


class Branch(TwoPins):
    """A resistor in series with a source of voltage."""

    resistance: Scalar = param(unit="ohm", doc="resistance")
    source: Scalar = param(default=0.0, unit="V", doc="voltage of the source, driving from n to p")

    def equations(self):
        p, n = self.p, self.n
        return [eq(p.v - n.v, self.resistance * p.i - self.source), eq(p.i + n.i, 0)]


class Capacitor(TwoPins):
    capacitance: Scalar = param(unit="F", doc="capacitance")
    start: Scalar = param(default=0.0, unit="V", doc="voltage at the start")

    v: Scalar = var(unit="V", start=start, state="prefer", doc="voltage")

    def equations(self):
        return [
            eq(self.v, self.p.v - self.n.v),
            eq(self.p.i, self.capacitance * der(self.v)),
            eq(self.p.i + self.n.i, 0),
        ]


class Ground(Component):
    pin: Pin = port(doc="grounded pin")

    def equations(self):
        return [eq(self.pin.v, 0)]


@st.composite
def graphs(draw, largest=7):
    """A connected graph: (number of nodes, edges), a random tree with more edges, in any direction."""
    n = draw(st.integers(2, largest))
    tree = [(draw(st.integers(0, k - 1)), k) for k in range(1, n)]
    extra = draw(st.lists(st.tuples(st.integers(0, n - 1), st.integers(0, n - 1)), max_size=n))
    edges = tree + [(a, b) for a, b in extra if a != b]
    return n, [(b, a) if draw(st.booleans()) else (a, b) for a, b in edges]


values = st.floats(0.1, 10.0).map(lambda x: round(x, 3))


class Network:
    """Parts on the nodes of a graph; a node is the first pin that was joined to it."""

    def __init__(self, ground: str = "ground"):
        self.model = fw.Assembly("network")
        self.model.add(ground, Ground())
        self.nodes = {0: self.model.parts[ground].pin}

    def add(self, name, component, a, b):
        self.model.add(name, component)
        for pin, node in ((component.p, a), (component.n, b)):
            if node in self.nodes:
                self.model.connect(self.nodes[node], pin)
            else:
                self.nodes[node] = pin
        return component


def resistances(draw_graph, numbers, rename=""):
    n, edges = draw_graph
    network = Network()
    for k, ((a, b), (r, e)) in enumerate(zip(edges, numbers, strict=False)):
        network.add(f"{rename}branch_{k}", Branch(resistance=r, source=e), a, b)
    return network.model


def currents_by_numpy(n, edges, numbers):
    """Nodal analysis: incidence A, conductances G; A G A^T v = -A G e."""
    A = np.zeros((n, len(edges)))
    for k, (a, b) in enumerate(edges):
        A[a, k], A[b, k] = 1.0, -1.0
    G = np.diag([1 / r for r, _ in numbers])
    e = np.array([source for _, source in numbers])
    potentials = np.zeros(n)
    potentials[1:] = np.linalg.solve((A @ G @ A.T)[1:, 1:], -(A @ G @ e)[1:])
    return G @ (A.T @ potentials + e)


@given(graphs(), st.data())
def test_meshes_of_resistors_agree_with_numpy(graph, data):
    n, edges = graph
    numbers = data.draw(st.lists(st.tuples(values, values), min_size=len(edges), max_size=len(edges)))
    state = Model(resistances(graph, numbers)).compile().initial_state()
    found = [state[f"branch_{k}.p.i"] for k in range(len(edges))]
    assert np.allclose(found, currents_by_numpy(n, edges, numbers), rtol=1e-8, atol=1e-9)


@given(graphs(5), st.data())
def test_networks_of_capacitors_have_the_modes_of_their_matrices(graph, data):
    """A capacitor from each node to ground, resistors between: dv/dt = -C^-1 (A G A^T) v."""
    n, edges = graph
    resistance = data.draw(st.lists(values, min_size=len(edges), max_size=len(edges)))
    capacitance = data.draw(st.lists(values, min_size=n - 1, max_size=n - 1))
    network = Network()
    for k, ((a, b), r) in enumerate(zip(edges, resistance, strict=True)):
        network.add(f"r{k}", Branch(resistance=r), a, b)
    for node, c in enumerate(capacitance, start=1):
        network.add(f"c{node}", Capacitor(capacitance=c), node, 0)
    plant = Model(network.model).compile()
    A = np.zeros((n, len(edges)))
    for k, (a, b) in enumerate(edges):
        A[a, k], A[b, k] = 1.0, -1.0
    matrix = -(A @ np.diag(1 / np.array(resistance)) @ A.T)[1:, 1:] / np.array(capacitance)[:, None]
    expected = np.sort(np.linalg.eigvals(matrix).real)
    linear = plant.linearize(plant.initial_state())
    assert np.allclose(np.sort(np.linalg.eigvals(np.asarray(linear.A)).real), expected, rtol=1e-8, atol=1e-10)


@given(
    st.lists(st.tuples(values, st.floats(-5, 5).filter(lambda g: abs(g) > 0.2), values, values), min_size=1, max_size=5)
)
def test_geared_shafts_have_the_modes_of_their_matrices(cells):
    """Wheels in pairs on gears (index reduction), springs from pair to pair: M q'' + K q = 0."""
    model = fw.Assembly("shafts")
    model.ground = FixedFlange()
    before, ratio, n = model.ground.flange, 1.0, len(cells)
    M, K = np.zeros((n, n)), np.zeros((n, n))
    for i, (slow, gear, fast, stiffness) in enumerate(cells):
        parts = {
            "spring": TorsionSpringDamper(stiffness=stiffness), "slow": Inertia(inertia=slow),
            "gear": IdealGear(ratio=gear), "fast": Inertia(inertia=fast),
        }  # fmt: skip
        spring, first, box, second = (model.add(f"{name}_{i}", part) for name, part in parts.items())
        model.connect(before, spring.flange_a)
        model.connect(spring.flange_b, first.flange_a)
        model.connect(first.flange_b, box.flange_b)
        model.connect(box.flange_a, second.flange_a)
        before = second.flange_b
        M[i, i] = slow + gear**2 * fast
        twist = np.zeros(n)  # of the spring: slow wheel i minus fast wheel i - 1
        twist[i] = 1.0
        if i:
            twist[i - 1] = -ratio
        K += stiffness * np.outer(twist, twist)
        ratio = gear
    plant = Model(model).compile()
    assert len(plant.dae.states) == 2 * n
    frequencies = np.sort(np.abs(np.linalg.eigvals(np.asarray(plant.linearize(plant.initial_state()).A)).imag))[::2]
    assert np.allclose(frequencies**2, np.sort(np.linalg.eigvals(np.linalg.solve(M, K)).real), rtol=1e-6, atol=1e-7)


# --- graph algorithms ---------------------------------------------------------------------------------------------


@st.composite
def regular_incidences(draw, largest=12):
    """A square incidence with a hidden perfect matching, rows and columns shuffled."""
    n = draw(st.integers(1, largest))
    columns = draw(st.permutations(range(n)))
    extra = draw(st.lists(st.tuples(st.integers(0, n - 1), st.integers(0, n - 1)), max_size=3 * n))
    rows = [{columns[i]} for i in range(n)]
    for i, j in extra:
        rows[i].add(j)
    return [np.array(sorted(row), int) for row in rows]


@given(regular_incidences())
def test_strong_components_are_a_block_triangular_order(rows):
    blocks = structure.strong_components(rows, len(rows))
    assert sorted(int(r) for block, _ in blocks for r in block) == list(range(len(rows)))
    known: set[int] = set()
    for block_rows, block_columns in blocks:
        assert len(block_rows) == len(block_columns)
        members = set(map(int, block_columns))
        for r in block_rows:
            assert set(map(int, rows[r])) <= known | members
        inner = [np.array([c for c in map(int, rows[r]) if c in members]) for r in block_rows]
        assert not len(inner) > 1 or _is_irreducible(inner, sorted(members))
        known |= members
    assert known == set(range(len(rows)))


def _is_irreducible(rows, columns):
    """No proper subset of k rows has only k columns: as a directed graph over a matching, one strong component."""
    position = {c: k for k, c in enumerate(columns)}
    local = [np.array([position[int(c)] for c in row]) for row in rows]
    match = structure.matching(local, len(columns))
    row_of = np.argsort(match)
    reach = np.eye(len(rows), dtype=bool)
    for i, row in enumerate(local):
        reach[i, row_of[row]] = True
    for _ in rows:
        reach = reach @ reach
    return bool(reach.all())


@st.composite
def incidences(draw):
    rows, columns = draw(st.integers(1, 10)), draw(st.integers(1, 10))
    return [np.array(sorted(draw(st.sets(st.integers(0, columns - 1), max_size=4))), int) for _ in range(rows)], columns


@given(incidences())
def test_dulmage_mendelsohn_finds_the_parts(system):
    rows, columns = system
    coarse = structure.dulmage_mendelsohn(rows, columns)
    sparsity = structure.matrix(rows, columns).toarray()
    rank = len(rows) - len(coarse.unmatched_rows)
    assert rank == columns - len(coarse.unmatched_columns) == _structural_rank(sparsity)
    over_rows, over_columns = set(coarse.over_rows.tolist()), set(coarse.over_columns.tolist())
    under_rows, under_columns = set(coarse.under_rows.tolist()), set(coarse.under_columns.tolist())
    assert not over_rows & under_rows and not over_columns & under_columns
    # the over-determined rows see only their columns, and there are too few of these; and the other way round
    assert all(set(rows[i].tolist()) <= over_columns for i in over_rows)
    assert len(over_rows) - len(over_columns) == len(coarse.unmatched_rows)
    assert all(i in under_rows for i in range(len(rows)) for j in rows[i] if int(j) in under_columns)
    assert len(under_columns) - len(under_rows) == len(coarse.unmatched_columns)
    # what is left is well determined
    left_rows = [i for i in range(len(rows)) if i not in over_rows | under_rows]
    left = sparsity[left_rows][:, [j for j in range(columns) if j not in over_columns | under_columns]]
    assert left.shape[0] == left.shape[1] == _structural_rank(left)
    # every row of the over-determined part may be the one too many
    for i in over_rows:
        assert _structural_rank(np.delete(sparsity, i, axis=0)) == rank


def _structural_rank(matrix):
    return ca.sprank(ca.sparsify(ca.DM(matrix.astype(float)))) if matrix.size else 0


# --- aliases ------------------------------------------------------------------------------------------------------


@given(st.data())
def test_aliases_with_any_signs(data):
    """x_k = +- x_j along a random tree, x_0 given by an equation: every x_k is x_0 times the product of the signs."""
    n = data.draw(st.integers(2, 10))
    edges = [(data.draw(st.integers(0, k - 1)), k, data.draw(st.sampled_from([1, -1]))) for k in range(1, n)]
    order = data.draw(st.permutations(range(len(edges))))
    flipped = data.draw(st.lists(st.booleans(), min_size=n, max_size=n))

    def equations(self):
        x = [getattr(self, f"x{k}") for k in range(n)]
        statements = [eq(der(x[0]), 1.0 - x[-1])]
        for k in order:
            a, b, sign = edges[k]
            left, right = (x[b], sign * x[a]) if flipped[b] else (sign * x[b], x[a])
            statements.append(eq(right, left) if flipped[a] else eq(left, right))
        return statements

    members = {f"x{k}": var(doc="x") for k in range(n)}
    members["x0"] = var(start=0.25, state="prefer", doc="x")
    component = type("Signs", (Component,), {
        "__annotations__": dict.fromkeys(members, Scalar), **members, "equations": equations,
    })  # fmt: skip
    model = fw.Assembly("signs")
    model.c = component()
    plant = Model(model).compile()
    assert len(plant.dae.states) == 1 and not plant.dae.algebraics
    signs = [1.0] * n
    for a, b, sign in edges:
        signs[b] = signs[a] * sign
    state = plant.initial_state()
    assert [state[f"c.x{k}"] for k in range(n)] == pytest.approx([0.25 * sign for sign in signs])
    assert state["der(c.x0)"] == pytest.approx(1.0 - 0.25 * signs[-1])


# --- repeatability ------------------------------------------------------------------------------------------------


def charged(numbers, graph, prefix=""):
    n, edges = graph
    network = Network(f"{prefix}ground")
    for k, ((a, b), r) in enumerate(zip(edges, numbers, strict=True)):
        network.add(f"{prefix}r{k}", Branch(resistance=r), a, b)
    for node in range(1, n):
        network.add(f"{prefix}c{node}", Capacitor(capacitance=1.0 + node, start=float(node)), node, 0)
    return network.model


@given(graphs(5), st.data())
def test_flattening_is_repeatable(graph, data):
    numbers = data.draw(st.lists(values, min_size=len(graph[1]), max_size=len(graph[1])))
    one, two = flatten(charged(numbers, graph)), flatten(charged(numbers, graph))
    assert [q.path for q in one.states] == [q.path for q in two.states]
    assert [q.path for q in one.algebraics] == [q.path for q in two.algebraics]
    assert (str(one.ode), str(one.alg)) == (str(two.ode), str(two.alg))
    assert list(one.observed) == list(two.observed)


@given(graphs(5), st.data())
@settings(max_examples=10)
def test_names_of_parts_do_not_change_results(graph, data):
    numbers = data.draw(st.lists(values, min_size=len(graph[1]), max_size=len(graph[1])))
    assume(len(numbers) > 0)
    plain = Model(charged(numbers, graph)).compile()
    renamed = Model(charged(numbers, graph, prefix="zz_")).compile()
    for name in (f"c{node}.v" for node in range(1, graph[0])):
        one = plain.simulate(1.0, output_step=0.5, tolerance=1e-8)[name]
        two = renamed.simulate(1.0, output_step=0.5, tolerance=1e-8)[f"zz_{name}"]
        assert np.allclose(one, two, rtol=1e-6, atol=1e-7)
