"""A co-simulation FMU as a part of a model."""

from __future__ import annotations

from fowtlib.components.fmu.archive import Archive
from fowtlib.components.fmu.description import Description, read_description
from fowtlib.components.fmu.running import FmuProcess, platform_folder
from fowtlib.components.fmu.signals import FmuSignal, check_names, check_ports, check_start, signals
from fowtlib.language import Array, Component, Number, RealInput, RealOutput, call, eq, param, port, sampled, var
from fowtlib.language.errors import ModelError, ParameterError, one_of


class FMU(Component):
    """A co-simulation FMU (FMI 2.0 or 3.0) as a sampled part; its inputs and outputs are ports of this part.

    The FMU is called once every `period`. At the start t0 it is initialised with its inputs at t0. At each later
    sample it takes its inputs at that instant and steps from the last sample to this one. Its outputs are held until
    the next sample; so an output that follows its input at once has no delay, and a controller acts as a computer does.
    Ports: every input and output under its own name, where anything but letters, digits and underscores becomes an
    underscore (`pitch[1]` is pitch_1), in the SI unit of its own, with its shape. Whole numbers and booleans are real
    signals: an input takes the nearest whole number, true is 0.5 and above. An input must be connected unless `start`
    gives its value. The file is native code that runs with the rights of the user: load only one you trust. It runs in
    a process of its own: one that crashes, or hangs longer than `patience`, ends the simulation with an error.
    Source: FMI 2.0.4, chapter 4; FMI 3.0.2, chapter 4.
    """

    in_own_units = {"": "an FMU has units and times of its own"}

    file: str = param(native=True, doc="path of the .fmu file")
    period: Number = param(default=None, unit="s", min=1e-9, doc="communication step; by default that of the file")
    time_factor: Number = param(
        default=1.0, min=1e-9, doc="seconds of the FMU in one of the model: sqrt(45) of a prototype in a tank at 1:45"
    )
    start: dict = param(
        default={},
        doc="values of parameters, open inputs and first outputs, by the FMU's names; numbers in the FMU's own unit",
    )
    names: dict = param(default={}, doc="names of ports of your own, by the FMU's names")
    units: dict = param(default={}, doc="units of variables whose unit the file does not define, by the FMU's names")
    ignore: list = param(default=[], doc="inputs and outputs that are to be no ports, by the FMU's names")
    patience: Number = param(default=60.0, unit="s", min=1e-3, doc="wall time one call may take")
    in_process: bool = param(default=False, doc="run it in the process of the simulation, which a crash then ends")

    def build(self):
        self._archive = Archive(self.file)
        self._content = self._archive.description()
        self._description = description = read_description(self._content, self._archive.path.name)
        _check_platform(self._archive, description)
        for what in ("names", "units"):
            check_names(description, getattr(self, what), what)
        check_names(description, self.ignore, "ignore", list)
        check_ports(self.names)
        self._start = check_start(description, self.start, self.units)
        self._step = _step(description, self.period, self.time_factor)
        given = (self.start, self.names, self.units, self.ignore)
        self._inputs, self._outputs = (signals(description, kind, *given) for kind in ("input", "output"))
        for signal in self._inputs:
            _declare(self, signal.port, RealInput, signal, default=signal.start)
        for signal in self._outputs:
            _declare(self, signal.port, RealOutput, signal)
            start = 0.0 if signal.start is None else signal.start
            held = var(unit=signal.unit, shape=signal.variable.shape, discrete=True, start=start, doc="held until then")
            self.declare(f"{signal.port}_held", Array, held)

    def equations(self):
        held = [getattr(self, f"{signal.port}_held") for signal in self._outputs]
        process = FmuProcess(
            self._archive, self._description, self._content, self._inputs, self._outputs, self._start,
            self._step * self.time_factor, self.patience, self.in_process, self.time_factor,
        )  # fmt: skip
        return [
            sampled(self._step, call(held, process, [getattr(self, signal.port) for signal in self._inputs])),
            [eq(getattr(self, signal.port), value) for signal, value in zip(self._outputs, held, strict=True)],
        ]


def _declare(unit: FMU, name: str, kind: type, signal: FmuSignal, **options: object) -> None:
    doc = signal.variable.doc or f"{signal.variable.name} of the FMU"
    try:
        unit.declare(name, kind, port(unit=signal.unit, shape=signal.variable.shape, doc=doc, **options))
    except ParameterError:
        raise ParameterError(
            f"the variable '{signal.variable.name}' cannot be the port '{name}', which is taken; give it a name of its "
            f"own, names: {{\"{signal.variable.name}\": ...}}."
        ) from None


def _check_platform(archive: Archive, description: Description) -> None:
    """Refuse an FMU that cannot run here."""
    if description.needs_tool:
        raise archive.broken("it needs the program that made it, which must run beside it; export one that does not")
    here, there = platform_folder(description.version), archive.platforms(description.identifier)
    if here not in there:
        known = f"for {one_of(there, 'and')}" if there else "for no platform"
        sources = any(name.startswith("sources/") and name.endswith(".c") for name in archive.names)
        more = " It brings sources, which have to be compiled into it first." if sources else ""
        raise ModelError(f"'{archive.path.name}' has no library for this machine ('{here}'), but {known}.{more}")


def _step(description: Description, given: float | None, factor: float) -> float:
    """Period of the exchange in seconds of the model; factor: seconds of the FMU in one of these."""
    step = given * factor if given is not None else description.step
    if step is None:
        raise ParameterError("the FMU does not name a communication step; give 'period'.")
    fixed = description.fixed_step
    if fixed is not None and abs(step / fixed - max(1, round(step / fixed))) > 1e-6:
        raise ParameterError(f"the period is {step:g} s, and this FMU steps by multiples of {fixed:g} s only.")
    return step / factor
