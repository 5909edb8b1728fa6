"""A part is replaced within its base class, wherever its owner made it, or the wish is refused."""

import pytest

import fowtlib as fw
from fowtlib.language import RealInput, RealOutput, Scalar, eq, param, part, port
from fowtlib.language.errors import ConnectionFault, ModelError, ParameterError


class Source(fw.Component):
    """y = value."""

    value: Scalar = param(default=1.0, doc="value")
    y: RealOutput = port(doc="value")

    def equations(self):
        return [eq(self.y, self.value)]


class Block(fw.Component):
    """Partial: one input, one output."""

    u: RealInput = port(doc="input")
    y: RealOutput = port(doc="output")


class Gain(Block):
    """y = k u."""

    k: Scalar = param(default=2.0, doc="gain")

    def equations(self):
        return [eq(self.y, self.k * self.u)]


class Square(Block):
    """y = u^2."""

    def equations(self):
        return [eq(self.y, self.u**2)]


class Cube(fw.Component):
    """y = u^3, with the ports of a Block and not one of them."""

    u: RealInput = port(doc="input")
    y: RealOutput = port(doc="output")

    def equations(self):
        return [eq(self.y, self.u**3)]


class Chain(fw.Component):
    """So many gains in a row, made in build(); the last is declared."""

    count: int = param(default=2, doc="number of gains before the last")
    k: Scalar = param(default=2.0, doc="their gain")
    u: RealInput = port(doc="input")
    y: RealOutput = port(doc="output")
    last: Block = part(Gain, k=k)

    def build(self):
        before = self.u
        for i in range(self.count):
            gain = Gain(k=self.k)
            self.add(f"gain_{i + 1}", gain)
            self.connect(before, gain.u)  # the author's own reference, not what add() returns
            before = gain.y
        self.connect(before, self.last.u)
        self.connect(self.last.y, self.y)


class Farm(fw.Component):
    """A source and a chain, both made in build(); what comes out."""

    count: int = param(default=2, doc="of the chain")
    y: RealOutput = port(doc="output")

    def build(self):
        self.source = Source(value=3.0)
        self.chain = Chain(count=self.count)
        self.connect(self.source.y, self.chain.u)
        self.connect(self.chain.y, self.y)


def value(root, path="y"):
    return float(fw.load(root).compile().initial_state()[path])


def test_a_part_of_build_is_replaced_at_any_depth():
    farm = Farm()
    assert value(farm) == 24.0
    farm.chain.gain_2 = Square()
    assert value(farm) == 72.0  # 3 * 2 = 6, squared, times 2
    farm.chain.last = Square()
    assert value(farm) == 36.0**2
    farm.source = Source(value=1.0)
    assert value(farm) == 16.0


def test_it_outlives_the_owner_that_is_made_anew():
    farm = Farm()
    farm.chain.gain_1 = Square()
    farm.chain.last.k = 5.0
    farm.count = 3
    assert [type(item).__name__ for item in farm.chain.parts.values()] == ["Gain", "Square", "Gain", "Gain"]
    assert value(farm) == 9 * 2 * 2 * 5


def test_by_the_constructor():
    assert value(Farm(chain=Chain(gain_1=Square(), last=Cube()))) == 18.0**3
    with pytest.raises(ParameterError, match="Chain makes no part 'gain_3' that a Square could take the place of"):
        Chain(gain_3=Square())


def test_a_class_with_the_same_ports_fits_and_another_is_refused():
    farm = Farm()
    farm.chain.last = Cube()
    assert value(farm) == 12.0**3
    with pytest.raises(ParameterError) as error:
        farm.chain.last = Source()
    assert str(error.value) == "Source cannot take the place of chain.last, a Block: it has no port 'u'."
    with pytest.raises(ParameterError, match="place of chain.gain_1, a Gain: it has no port 'u'"):
        farm.chain.gain_1 = Source()
    with pytest.raises(ParameterError, match="chain.last is a part, and 3.0 is no Component"):
        farm.chain.last = 3.0
    assert value(farm) == 12.0**3  # as before


def test_connections_from_outside_follow():
    root = fw.Assembly()
    root.farm, root.probe, root.inner = Farm(), Gain(k=10.0), Gain(k=100.0)
    root.connect(root.farm.y, root.probe.u)
    root.connect(root.farm.chain.gain_1.y, root.inner.u)
    root.farm.count = 1
    assert (value(root, "probe.y"), value(root, "inner.y")) == (120.0, 600.0)
    root.farm.chain.gain_1 = Square()
    assert (value(root, "probe.y"), value(root, "inner.y")) == (180.0, 900.0)
    root.probe = Square()
    assert value(root, "probe.y") == 18.0**2
    with pytest.raises(ConnectionFault, match="place of probe, a Square: it has no port 'u', which is"):
        root.probe = Source()
    with pytest.raises(ParameterError, match="farm.chain makes no part 'gain_1' that a Square"):
        root.farm.count = 0
    assert value(root, "inner.y") == 900.0


def test_a_connection_to_a_part_that_vanished_is_refused():
    root = fw.Assembly()
    root.farm, root.inner = Farm(), Gain()
    root.connect(root.farm.chain.gain_2.y, root.inner.u)
    root.farm.count = 1
    with pytest.raises(ConnectionFault, match="farm.chain.gain_2 is there no more: farm.chain was composed anew"):
        value(root)


def test_formulas_and_handles_follow():
    root = fw.Assembly()
    root.farm = Farm()
    first = root.farm.chain.gain_1
    root.double = Source(value=2 * first.k)
    root.farm.count = 1
    assert first is not root.farm.chain.gain_1
    first.k = 7.0
    assert root.farm.chain.gain_1.parameter_value("k") == 7.0
    assert value(root, "double.y") == 14.0


def test_a_further_part_in_a_class_that_makes_its_own():
    farm = Farm()
    farm.chain.extra = Gain(k=-1.0)
    farm.chain.connect(farm.chain.gain_1.y, farm.chain.extra.u)
    farm.count = 1
    farm.chain.k = 4.0
    assert value(farm, "chain.extra.y") == -12.0
    with pytest.raises(ParameterError, match="extra is a part already"):
        farm.chain.second = farm.chain.extra


class Sized(fw.Component):
    """As many as the owner says, unless they were given."""

    count: int = param(default=1, doc="number")

    def build(self):
        for i in range(self.count):
            self.add(f"item_{i + 1}", Source())


class Owner(fw.Component):
    """Says how many."""

    count: int = param(default=2, doc="number")
    sized: Sized = part(Sized)

    def build(self):
        if not self.sized.is_set("count"):
            self.sized.count = self.count


def test_what_an_owner_puts_into_a_given_part_follows_the_owner():
    owner = Owner(sized=Sized())
    assert len(owner.sized.parts) == 2
    owner.count = 4
    assert len(owner.sized.parts) == 4
    owner.sized.count = 3
    owner.count = 5
    assert len(owner.sized.parts) == 3


def test_a_composition_that_fails_leaves_the_model_as_it_was():
    farm = Farm()
    farm.chain.gain_2.k = 5.0
    with pytest.raises(ParameterError, match=r"there is no 'chain.gain_2.k', which was given a value before"):
        farm.count = 1
    assert farm.count == 2 and value(farm) == 3 * 2 * 5 * 2


def test_a_number_in_the_place_of_a_part():
    model = fw.load("oc3_spar_rigid")
    for path, name in (("", "wind"), ("", "platform"), ("platform", "hull")):
        component = model.root.find(path)
        with pytest.raises(ModelError, match=rf"{name} is a part, a \w+: give values to its parameters, or another"):
            setattr(component, name, 3)
        with pytest.raises(ModelError, match=rf"{name} is (a part|made by|no)"):
            fw.load("oc3_spar_rigid", set={f"{path}.{name}".lstrip("."): 3})


class Span(fw.Component):
    """y = high - low, which is above zero."""

    low: float = param(default=1.0, doc="lower end")
    high: float = param(default=2.0, doc="upper end")
    y: RealOutput = port(doc="their difference")

    def build(self):
        if self.low >= self.high:
            raise ParameterError(f"{self.label}: low is below high")
        self.source = Source(value=self.high - self.low)
        self.connect(self.source.y, self.y)


def test_values_that_fit_only_together():
    """One after the other is refused; together they are taken, or none of them."""
    span = Span()
    assert span.source.parameter_value("value") == 1.0
    with pytest.raises(ParameterError, match="low is below high"):
        span.low = 5.0
    span.set_together({"low": 5.0, "high": 8.0})
    assert span.source.parameter_value("value") == 3.0
    for wrong in ({"low": 9.0, "high": 8.5}, {"low": 6.0, "hihg": 7.0}, {"low": 6.0, "high": "seven"}):
        with pytest.raises(ModelError):
            span.set_together(wrong)
        assert span.source.parameter_value("value") == 3.0 and span.low == 5.0
