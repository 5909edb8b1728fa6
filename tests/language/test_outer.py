"""What a part finds around it: the nearest of a class, or all of them."""

import pytest

import fowtlib as fw
from fowtlib.language import RealOutput, Scalar, der, eq, outer, param, part, port, var
from fowtlib.language.errors import ParameterError


class Tank(fw.Component):
    """A heat store."""

    temperature: Scalar = param(default=300.0, unit="K", doc="temperature")


class Heater(fw.Component):
    """A source of heat, with its size."""

    power: Scalar = param(default=1.0, unit="W", doc="heat")
    heat: RealOutput = port(unit="W", doc="heat given")

    def equations(self):
        return [eq(self.heat, self.power)]


class BigHeater(Heater):
    """Another class of the same kind."""


class Room(fw.Component):
    """Warms up by all heaters of the model, wherever they are: C T' = sum of all heat."""

    heaters: list[Heater] = outer(Heater, many=True)
    own: Heater = part(Heater, power=1000.0)  # a part of the asker is no part of its surroundings
    T: Scalar = var(unit="K", start=0.0, fixed=True, doc="temperature rise")

    def equations(self):
        return [eq(50.0 * der(self.T), sum(heater.heat for heater in self.heaters))]


class Gauge(fw.Component):
    """Shows the temperature of its tank."""

    tank: Tank = outer(Tank)
    y: RealOutput = port(unit="K", doc="temperature")

    def equations(self):
        return [eq(self.y, self.tank.temperature)]


def house(heaters):
    root = fw.Assembly()
    root.room = Room()
    floor = root.add("floor", fw.Assembly())
    for i in range(heaters):
        (floor if i % 2 else root).add(f"heater_{i}", (BigHeater if i > 1 else Heater)(power=10.0 * (i + 1)))
    return root


@pytest.mark.parametrize("count", [0, 1, 4])
def test_a_collection_finds_all_members(count):
    """T = t sum(10 (i + 1)) / 50 after t = 5 s."""
    root = house(count)
    paths = {item.path for item in root.room.heaters}
    assert paths == {f"floor.heater_{i}" if i % 2 else f"heater_{i}" for i in range(count)}
    result = fw.load(root).compile().simulate(5.0)
    assert float(result["room.T"][-1]) == pytest.approx(sum(10 * (i + 1) for i in range(count)) / 10, abs=1e-9)


def test_a_parameter_of_a_member_stays_one():
    result = fw.load(house(2)).compile().simulate(5.0, parameters={"floor.heater_1.power": 90.0})
    assert float(result["room.T"][-1]) == pytest.approx(10.0)


def test_the_nearest_wins():
    root = fw.Assembly()
    root.tank, inner = Tank(temperature=280.0), root.add("inner", fw.Assembly())
    inner.tank, inner.gauge, root.gauge = Tank(temperature=350.0), Gauge(), Gauge()
    state = fw.load(root).compile().initial_state()
    assert (state["inner.gauge.y"], state["gauge.y"]) == (350.0, 280.0)


@pytest.mark.parametrize("names", [("one", "two"), ("one", "two", "three")])
def test_two_equally_near_are_an_error_that_names_both(names):
    root = fw.Assembly()
    for name in names:
        root.add(name, Tank())
    deep = root.add("deep", fw.Assembly())
    deep.gauge = Gauge()
    listed = "'one' and 'two'" if len(names) == 2 else "'one', 'two' and 'three'"
    with pytest.raises(ParameterError) as error:
        fw.load(root).compile()
    assert str(error.value) == (
        f"deep.gauge needs one Tank as its 'tank', and there are {listed}; leave one, or put each beside what belongs "
        "to it."
    )
    deep.nearer = Tank(temperature=310.0)
    assert fw.load(root).compile().initial_state()["deep.gauge.y"] == 310.0


def test_two_worlds():
    from fowtlib.components.environment import World
    from fowtlib.components.mechanics import PointMass

    root = fw.Assembly()
    root.world, root.earth, root.mass = World(), World(), PointMass(mass=1.0)
    root.connect(root.world.frame, root.mass.frame_a)
    with pytest.raises(ParameterError, match="mass needs one World as its 'world', and there are 'world' and 'earth'"):
        fw.load(root).compile()


def test_a_collection_needs_a_class():
    with pytest.raises(ValueError, match="needs the class of its members"):
        outer(many=True)
