"""An equilibrium with freed parameters: as many parameters are sought as there are conditions on what comes out.

The states, the algebraic unknowns and the freed parameters are the unknowns of one Newton iteration, from the
equilibrium at the values that the parameters have, or the start values where there is none. Where it does not converge,
as when a turbine comes from one region of its controller into another, the parameters alone are sought, with the
equilibrium for each value of them; and where this does not come nearer either, the conditions move from what they are
there to what is wanted, in steps that become shorter.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import casadi as ca
import numpy as np

from fowtlib.flattening.system import element_names
from fowtlib.language.data_files import is_number
from fowtlib.language.errors import ModelError, NotFoundError, ParameterError, SimulationError, did_you_mean
from fowtlib.language.units import to_si
from fowtlib.solving.binding import data_from, start_slopes
from fowtlib.solving.equilibrium import Rest, equilibrium, moving_states, refuse_time, time_dependence
from fowtlib.solving.functions import AtParameters
from fowtlib.solving.initial import csc
from fowtlib.solving.newton import newton, undamped
from fowtlib.solving.paths import by_path, names_of
from fowtlib.solving.state import State

if TYPE_CHECKING:
    from scipy import sparse

Values = Mapping[str, Any]
Plant = Any
"""fowtlib.solving.plant.Plant, which calls this module."""

SHORTEST = 1 / 32  # of the way to the wanted conditions, in one step
ITERATIONS = 30  # of one step; from a start that is near enough some ten are needed
FARTHEST, NEAREST = 0.2, 1e-6  # change of a parameter over its value from one equilibrium to the next
DIFFERENCE = 1e-5  # of a parameter over its value, where data behind a handle are made from it
NONE = 1e-10  # relative change of a condition by relative changes of the parameters that counts as none


@dataclass(frozen=True)
class Freed:
    """An element of a tunable parameter that is sought: path, its number in column order, its name."""

    path: str
    number: int
    name: str


@dataclass(frozen=True)
class Target:
    """What a result or a variable shall be [SI]; name: what the user calls it, and text: the value in his words.

    factor, unit: of the result, value [SI] times factor is in this unit.
    """

    name: str
    expression: ca.SX
    value: float
    text: str
    factor: float
    unit: str

    def told(self, value: float) -> str:
        """A value [SI] in the unit of the result."""
        return f"{value * self.factor:.6g}" + ("" if self.unit == "1" else f" {self.unit}")


def freed_equilibrium(plant: Plant, free: Values | Sequence[str], targets: Values, parameters: Values | None,
                      hold: Values | None, start: Values | None, inputs: Values | None,
                      near: State | None = None) -> State:  # fmt: skip
    """The equilibrium at which `targets` hold, with the parameters `free` at the values that this takes.

    free: paths, or first guesses by path. near: such an equilibrium of other parameters, from which it is sought first.
    The state's `parameters` hold what was found. Raises ParameterError where the conditions are not as many as the
    freed parameters, or a parameter is not tunable, and SimulationError where no such equilibrium is found.
    """
    guesses = dict(free) if isinstance(free, Mapping) else dict.fromkeys(names_of(free, "freed parameters"))
    wanted = [_target(plant, name, value) for name, value in by_path(targets, "targets").items()]
    given = {**(parameters or {})}
    sought = _elements(plant, guesses)
    if len(sought) != len(wanted):
        raise ParameterError(
            f"{_count(len(sought), 'parameter')} freed ({_names(item.name for item in sought)}) and "
            f"{_count(len(wanted), 'condition')} given ({_names(item.name for item in wanted)}): give as many "
            "conditions as freed parameters."
        )
    values = {path: value.astype(float) for path, value in plant.parameter_values(given).items()}
    found = near.parameters if near is not None else {}
    guesses |= {item.path: found[item.path] for item in sought if item.path in found}
    for item in sought:
        guess = guesses.get(item.name, guesses.get(item.path))
        if guess is not None:
            numbers = np.ravel(np.asarray(to_si(guess, plant.dae.parameters[item.path].unit, item.name), dtype=float))
            values[item.path].T.flat[item.number] = numbers[min(item.number, numbers.size - 1)]
    problem = _Problem(plant, sought, wanted, given, values)
    beside = problem.beside(near) if near is not None else None
    if beside is not None:
        return beside
    state = plant.initial_state(problem.parameters(np.zeros(len(sought))), {**(start or {}), **(hold or {})}, inputs)
    return problem.solved(state, {plant.layout.x[path] for path in hold or {}})


class _Problem:
    """One search; its unknowns are moving states, algebraic unknowns and shares s, p = p_0 + scale s."""

    def __init__(self, plant: Plant, sought: list[Freed], wanted: list[Target], given: Values,
                 values: Mapping[str, np.ndarray]):  # fmt: skip
        self.plant, self.sought, self.wanted, self.given = plant, sought, wanted, given
        self.first = {item.path: values[item.path] for item in sought}
        start = np.array([values[item.path].T.flat[item.number] for item in sought])
        self.scale = np.where(start == 0, 1.0, np.abs(start))
        self.want = np.array([item.value for item in wanted])
        self.places = [plant.layout.p[item.path].start + item.number for item in sought]
        self.base, self.alone = plant.binding(self.parameters(np.zeros(len(sought)))), False
        self.alone = self._moves_alone()

    def _moves_alone(self) -> bool:
        """Whether no other number of a run follows from those that are freed, so that nothing is bound anew."""
        if any(item.path in reads for reads in self.base.reads.values() for item in self.sought):
            return False
        try:
            moved = self.plant.binding(self.parameters(np.full(len(self.sought), 1e-6))).p
        except ModelError:
            return False
        return set(np.flatnonzero(moved != self.base.p)) <= set(self.places)

    def at(self, shares: np.ndarray) -> AtParameters:
        """The functions with those that are freed at these shares; ModelError where one is out of its bounds."""
        if not self.alone:
            return self.plant.at(self.parameters(shares))
        p = self.base.p.copy()
        p[self.places] += shares * self.scale
        for item, value in zip(self.sought, p[self.places], strict=True):
            bounds = self.plant.dae.parameters[item.path]
            if (bounds.min is not None and value < bounds.min) or (bounds.max is not None and value > bounds.max):
                raise ParameterError(f"{item.name} = {value:g} is out of its bounds.")
        self.plant.dae.check_dependents(p)
        return self.plant.functions.at(replace(self.base, p=p))

    def parameters(self, shares: np.ndarray) -> dict[str, Any]:
        """The parameters of a run, with those that are freed at these shares."""
        values = {path: np.array(value) for path, value in self.first.items()}
        for item, step in zip(self.sought, shares * self.scale, strict=True):
            values[item.path].T.flat[item.number] += step
        return {**self.given, **{path: value if value.shape else float(value) for path, value in values.items()}}

    def beside(self, near: State) -> State | None:
        """The state that Newton's iteration finds from one of other parameters; None: none."""
        at = self.plant.at(self.parameters(np.zeros(len(self.sought))))
        d = at.start_values()[2]
        if time_dependence(at, d):
            return None
        moving = moving_states(at.functions, set())
        equations = _Equations(self, Rest(at, near.t, near.x, np.concatenate([near.u, d]), moving))
        found = equations.solve(np.concatenate([near.x[moving], near.z, np.zeros(len(self.sought))]), self.want)
        if found is None:
            return None
        x, z, shares = equations.unpack(found)
        return self.plant.state(near.t, x, z, d, near.u, self.parameters(shares))

    def solved(self, state: State, held: set[int]) -> State:
        """The state at which all conditions hold."""
        q, plant = np.concatenate([state.u, state.d]), self.plant
        at = plant.at(self.parameters(np.zeros(len(self.sought))))
        refuse_time(at, q)
        zero = any(self.first[item.path].T.flat[item.number] == 0 for item in self.sought)
        moving, why = moving_states(at.general if zero else at.functions, held), ""
        x, z, known = state.x, state.z, True
        try:
            x, z = equilibrium(at, state.t, state.x, state.z, q, held)
        except SimulationError as error:
            known, why = False, f" Without the conditions, too, there is {error.message}"
        equations = _Equations(self, Rest(at, state.t, x, q, moving))
        unknowns = np.concatenate([x[moving], z, np.zeros(len(self.sought))])
        if known:
            self._refuse_unmoved(equations, unknowns)
        solution = equations.solve(unknowns, self.want, whole=True)
        found, first = solution is not None, unknowns
        unknowns = solution if solution is not None else unknowns
        if not found and known:
            found, unknowns = self._by_equilibria(equations, first, held)
        if not found and unknowns is first:
            reached, unknowns = self._on_the_way(equations, first, known)
            found = reached == 1
        if not found:
            raise SimulationError(self._failure(equations, unknowns, known) + why)
        x, z, shares = equations.unpack(unknowns)
        return plant.state(state.t, x, z, state.d, state.u, self.parameters(shares))

    def _on_the_way(self, equations: _Equations, unknowns: np.ndarray, known: bool) -> tuple[float, np.ndarray]:
        """How far the conditions have come, 1 is all the way, and the unknowns there."""
        begin, reached, step = equations.conditions(unknowns), 0.0, 1.0
        while reached < 1 and step >= SHORTEST:
            share = min(reached + step, 1.0)
            solution = equations.solve(unknowns, begin + share * (self.want - begin) if known else self.want)
            if solution is not None:
                reached, unknowns, step = share, solution, 2 * step
            elif not known:
                break
            else:
                step /= 2
        return reached, unknowns

    def _by_equilibria(self, equations: _Equations, unknowns: np.ndarray, held: set[int]) -> tuple[bool, np.ndarray]:
        """Newton steps of the parameters alone, from equilibrium to equilibrium: whether all holds, and where it is."""
        size = np.maximum(np.maximum(np.abs(equations.conditions(unknowns)), np.abs(self.want)), 1e-9)
        miss, reach = (self.want - equations.conditions(unknowns)) / size, FARTHEST
        for _ in range(ITERATIONS):
            slopes = equations.slopes_at_rest(unknowns)
            if not np.all(np.isfinite(slopes)):
                return False, unknowns
            step = np.linalg.lstsq(slopes / size[:, None], miss, rcond=1e-12)[0]
            step *= min(1.0, reach / max(float(np.max(np.abs(step))), 1e-300))
            while (largest := float(np.max(np.abs(step)))) > NEAREST:
                trial = equations.at_rest(unknowns, step, held)
                left = None if trial is None else (self.want - equations.conditions(trial)) / size
                if trial is not None and np.linalg.norm(left) < np.linalg.norm(miss):
                    break
                step, reach = step / 2, FARTHEST
            else:  # it is there, or at the nearest that can be reached
                solution = equations.solve(unknowns, self.want)
                return solution is not None, unknowns if solution is None else solution
            unknowns, miss = trial, left
            if largest < FARTHEST / 4 and (solution := equations.solve(unknowns, self.want, whole=True)) is not None:
                return True, solution
            reach *= 1.5
        return False, unknowns

    def _refuse_unmoved(self, equations: _Equations, unknowns: np.ndarray) -> None:
        """SimulationError where a condition does not depend on what is freed."""
        slopes = equations.slopes_at_rest(unknowns)
        sizes = np.maximum(np.abs(equations.conditions(unknowns)), np.abs(self.want))
        for target, row, size in zip(self.wanted, slopes, sizes, strict=True):
            if not (np.isfinite(size) and np.all(np.isfinite(row))):
                raise SimulationError(
                    f"{target.name} is not a number at the equilibrium from which the search begins (a period where "
                    "there is no stiffness?). Give first guesses at which it is one."
                )
            if np.max(np.abs(row)) <= NONE * max(size, 1e-9):
                raise SimulationError(
                    f"{target.name} = {target.text} cannot be reached: at the equilibrium it does not change with "
                    f"{_names(item.name for item in self.sought)}. Free a parameter that moves it."
                )
        rows = slopes / np.max(np.abs(slopes), axis=1, keepdims=True)
        if len(rows) > 1 and np.linalg.cond(rows / np.maximum(np.linalg.norm(rows, axis=0), 1e-300)) > 1e9:
            raise SimulationError(
                f"{_names(item.name for item in self.sought)} move the conditions "
                f"{_names(item.name for item in self.wanted)} all alike, so that they are not determined. Free other "
                "parameters, or ask for something else."
            )

    def _failure(self, equations: _Equations, unknowns: np.ndarray, known: bool) -> str:
        asked = ", ".join(f"{item.name} = {item.text}" for item in self.wanted)
        text = f"no equilibrium with {asked} is found by freeing {_names(item.name for item in self.sought)}."
        if not known:
            return text + " Give first guesses nearer to a solution."
        shares, there = equations.unpack(unknowns)[2], equations.conditions(unknowns)
        units = self.plant.dae.units
        at = ", ".join(f"{item.name} = {item.told(value)}" for item, value in zip(self.wanted, there, strict=True))
        values = [value.T.flat[item.number] for item, value in self._values(shares)]
        found = ", ".join(f"{item.name} = {value:.6g} {units.get(item.path, '')}".rstrip()
                          for item, value in zip(self.sought, values, strict=True))  # fmt: skip
        return f"{text} The search came to {at} with {found}. Ask for something nearer, or give first guesses."

    def _values(self, shares: np.ndarray) -> list[tuple[Freed, np.ndarray]]:
        values = self.parameters(shares)
        return [(item, np.asarray(values[item.path])) for item in self.sought]


class _Equations:
    """Residual and Jacobian of a search, at the values of the parameters that its unknowns say."""

    def __init__(self, problem: _Problem, rest: Rest):
        self.problem, self.rest, at = problem, rest, rest.at
        dae, self.paths = at.dae, list(dict.fromkeys(item.path for item in problem.sought))
        self.through_data = {path for path in self.paths if data_from(dae, at.binding, path)}
        sloped = [path for path in self.paths if path not in self.through_data]
        self.computed = sorted({k for path in sloped for k in start_slopes(dae, at.binding, path)})
        self.columns = {path: dae.parameters[path].symbol for path in self.paths}
        self.columns |= {name: dae.bound[name].symbol for name in self.computed}
        rows = ca.vertcat(dae.ode, dae.alg, *(item.expression for item in problem.wanted))
        blocks = [dae.x, dae.z, *map(ca.vec, self.columns.values())]
        key = ("freed", tuple(item.name for item in problem.wanted), tuple(self.columns))
        general = at.general
        self.value = general.once((*key, "value"), lambda: general.function("freed", [rows]))
        self.jacobian = general.once((*key, "slopes"), lambda: general.torn_jacobian("freed_slopes", rows, blocks))
        self.kept = np.r_[rest.moving, rest.x.size : rows.numel()].astype(int)  # rows of the search

    def unpack(self, values: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """States, algebraic unknowns, shares."""
        return *self.rest.unpack(values[: self.rest.size]), values[self.rest.size :]

    def conditions(self, values: np.ndarray) -> np.ndarray:
        """Values of the targets [SI]."""
        return self._rows(values)[-len(self.problem.wanted) :]

    def _rows(self, values: np.ndarray) -> np.ndarray:
        x, z, shares = self.unpack(values)
        try:
            at = self.problem.at(shares)
        except ModelError:  # a parameter out of its bounds
            return np.full(self.value.size1_out(0), np.nan)
        return np.array(at.call(self.value, self.rest.t, x, z, self.rest.q)).ravel()

    def solve(self, values: np.ndarray, want: np.ndarray, whole: bool = False) -> np.ndarray | None:
        """The unknowns with these conditions, perhaps by whole steps alone; None where they are not found."""
        kept, shift = self.kept, np.concatenate([np.zeros(self.rest.size), want])

        def residual(v: np.ndarray) -> np.ndarray:
            return self._rows(v)[kept] - shift

        def slopes(v: np.ndarray) -> sparse.csr_matrix:
            return self._slopes(v)[kept]

        try:
            found = undamped(residual, slopes, values) if whole else newton(residual, slopes, values, limit=ITERATIONS)
        except ModelError:  # a whole step out of the bounds
            return None
        return found.values if found is not None and found.converged else None

    def at_rest(self, values: np.ndarray, step: np.ndarray, held: set[int]) -> np.ndarray | None:
        """The unknowns at the equilibrium a step of the shares away; None where there is none."""
        x, z, shares = self.unpack(values)
        try:
            x, z = equilibrium(self.problem.at(shares + step), self.rest.t, x, z, self.rest.q, held)
        except (ModelError, SimulationError):
            return None
        return np.concatenate([x[self.rest.moving], z, shares + step])

    def _slopes(self, values: np.ndarray) -> sparse.csr_matrix:
        from scipy import sparse  # slow to import

        x, z, shares = self.unpack(values)
        problem = self.problem
        at = problem.at(shares)
        by_x, by_z, *by_numbers = (csc(block) for block in at.call(self.jacobian, self.rest.t, x, z, self.rest.q))
        by = dict(zip(self.columns, by_numbers, strict=True))
        sloped = [] if problem.alone else [path for path in self.paths if path not in self.through_data]
        through = {path: start_slopes(at.dae, at.binding, path) for path in sloped}
        columns = []
        for k, (item, scale) in enumerate(zip(problem.sought, problem.scale, strict=True)):
            if item.path in self.through_data:
                columns.append(self._differences(values, k))
                continue
            column = by[item.path][:, [item.number]].toarray()
            for name, slope in through.get(item.path, {}).items():
                column = column + by[name] @ slope[:, [item.number]]
            columns.append(column * scale)
        return sparse.csr_matrix(sparse.hstack([by_x[:, self.rest.moving], by_z, np.hstack(columns)]))

    def _differences(self, values: np.ndarray, number: int) -> np.ndarray:
        """The column of a parameter from which data of a run are made, as the surface of a hull is: by differences."""
        step = np.zeros(values.size)
        step[self.rest.size + number] = DIFFERENCE
        return ((self._rows(values + step) - self._rows(values - step)) / (2 * DIFFERENCE))[:, None]

    def slopes_at_rest(self, values: np.ndarray) -> np.ndarray:
        """Derivatives of the targets at the equilibrium by the shares; what is free to move, as a yaw, stays."""
        whole, n = self._slopes(values).toarray()[self.kept], self.rest.size
        rest, targets = whole[:n], whole[n:]
        if not n:  # nothing moves
            return targets
        rest = rest / np.maximum(np.max(np.abs(rest[:, :n]), axis=1, keepdims=True), 1e-300)
        moved = -np.linalg.lstsq(rest[:, :n], rest[:, n:], rcond=1e-14)[0]
        return targets[:, n:] + targets[:, :n] @ moved


def _elements(plant: Plant, guesses: Values) -> list[Freed]:
    """The elements of tunable parameters behind paths; a path without a number stands for all of its elements."""
    found = []
    for name in guesses:
        path = name if name in plant.dae.parameters else name.partition("[")[0]
        if path not in plant.dae.parameters:
            plant.binding({path: 0.0})  # says that it is no tunable one, and what was meant
            raise ParameterError(f"{path} is bound when a run starts, and no number that can be freed.")
        item = plant.dae.parameters[path]
        names = element_names(path, item.symbol.shape)
        if name != path and name not in names:
            raise ParameterError(f"{name} cannot be freed: the elements of {path} are {names[0]} to {names[-1]}.")
        found += [Freed(path, k, own) for k, own in enumerate(names) if name in (path, own)]
    return found


def _target(plant: Plant, name: str, value: Any) -> Target:
    """A condition; a number, also as a text, is in the unit of the result of that name, or SI."""
    entry = plant.outputs.entry(name)
    try:
        expression = ca.vec(plant.dae.observe_expression(entry.path))
    except NotFoundError:
        known = [*dict(plant.outputs.items()), *plant.dae.names]
        raise NotFoundError(f"there is no variable '{name}'{did_you_mean(name, known)}") from None
    if expression.numel() != 1:
        raise ParameterError(f"a condition is on one number, and {name} has {expression.numel()}: take {name}[0].")
    si = plant.describe(entry.path)[0]
    if value is None:
        raise ParameterError(f"the condition on {name} has no value: say which it shall take.")
    if isinstance(value, str) and not is_number(value):
        number, text = float(np.asarray(to_si(value, si, name))), value
    else:
        number = float(value) / plant.outputs.factor(name)
        text = f"{float(value):g}" + ("" if entry.unit == "1" else f" {entry.unit}")
    if not np.isfinite(number):
        raise ParameterError(f"the condition {name} = {value} is not a finite number.")
    return Target(name, expression, number, text, plant.outputs.factor(name), entry.unit)


def _count(number: int, what: str) -> str:
    return f"{number} {what} is" if number == 1 else f"{number or 'no'} {what}s are"


def _names(items: Any) -> str:
    return ", ".join(items) or "none"
