"""One case of a batch in the process that computes it: from plain data to a file of results and plain data."""

from __future__ import annotations

import gc
import json
import os
import time
import traceback
import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fowtlib.cases.case import Case
from fowtlib.cases.statistics import statistics_of
from fowtlib.language.data_files import digest_of, files_of
from fowtlib.language.errors import ModelError, SimulationError
from fowtlib.language.whole_files import WriteError, write_text
from fowtlib.solving.results.journal import Journal

if TYPE_CHECKING:
    import numpy as np

    from fowtlib.solving.binding import Binding
    from fowtlib.solving.model import Model
    from fowtlib.solving.plant import Plant
    from fowtlib.solving.results import Result
    from fowtlib.solving.results.data import RawTrajectory, Stored

DONE, FAILED, STOPPED, NO_ROOM = "done", "failed", "stopped", "no room"
SHIPPED = "models:"  # of a file that fowtlib brings, in place of its folder
_KEPT = 2  # plants of one process
Report = Callable[[float, float], None]


@dataclass(frozen=True)
class Job:
    """A case and where its result goes; plain data.

    case: see Case.plain. model: a shipped name or the whole path of the model file. result: the file to write, "" for
    none; partial: that of what a case that fails has computed. starts: a folder for the means that runs start from,
    each found once in a batch; "" for none. journal: the file beside which a run that takes long keeps what it has
    computed, to go on from where it was killed; "" for none. allow_python, trust, allow: see fowtlib.modelfile.load.
    """

    case: Mapping[str, Any]
    model: str
    result: str
    partial: str
    starts: str = ""
    journal: str = ""
    allow_python: bool = False
    trust: bool = False
    allow: tuple[str, ...] = ()

    def plain(self) -> dict[str, Any]:
        """In what JSON can hold."""
        return asdict(self)

    @property
    def name(self) -> str:
        """Of the case."""
        return self.case["name"]


@dataclass(frozen=True)
class Outcome:
    """What became of a case; plain data. state: done, failed, stopped (by a wish of the user) or no room (on the disk).

    statistics: all of fowtlib.analysis.case_statistics. The other fields are those of fowtlib.cases.registry.Row.
    """

    state: str
    message: str = ""
    warnings: str = ""
    seconds: float = 0.0
    processor: float = 0.0
    simulated: float = 0.0
    result: str = ""
    bytes: int | None = None
    files: dict[str, str] = field(default_factory=dict)
    statistics: dict[str, Any] = field(default_factory=dict)

    def plain(self) -> dict[str, Any]:
        """In what JSON can hold."""
        return asdict(self)


@dataclass
class _Compiled:
    model: Model
    plant: Plant
    digests: dict[str, str]


_plants: dict[tuple[Any, ...], _Compiled] = {}  # of this process; the last one used is the last


def carry_out(job: Job, report: Report = lambda t, end: None) -> Outcome:
    """Compute a case and write its result; whatever goes wrong is said in the outcome.

    report: is told the simulated time and its end [s]; it may raise KeyboardInterrupt to stop the run.
    """
    began, used = time.perf_counter(), time.process_time()
    told: dict[str, Any] = {"state": DONE}
    with warnings.catch_warnings(record=True) as heard:
        warnings.simplefilter("ignore")
        warnings.simplefilter("always", UserWarning)
        warnings.simplefilter("always", RuntimeWarning)
        try:
            _compute(job, report, told)
        except KeyboardInterrupt:
            told = {"state": STOPPED}
        except WriteError as error:
            told |= {"state": NO_ROOM, "message": str(error)}
        except ModelError as error:
            told |= {"state": FAILED, "message": str(error)}
            _keep_partial(error, job, told)
        except MemoryError:
            told |= {"state": FAILED, "message": "this needs more memory than there is."}
        except Exception as error:
            traceback.print_exc()  # into the log of the workers
            reason = f"{type(error).__name__}: {error}" if str(error) else type(error).__name__
            told |= {"state": FAILED, "message": f"an error inside the program: {reason}"}
    said = dict.fromkeys(str(item.message) for item in heard if issubclass(item.category, UserWarning))
    return Outcome(**{
        "warnings": "\n".join(said), "seconds": time.perf_counter() - began,
        "processor": time.process_time() - used, **told,
    })  # fmt: skip


def _compute(job: Job, report: Report, told: dict[str, Any]) -> None:
    case = Case.from_plain(job.case)
    compiled = _compiled(job)
    told["files"] = dict(compiled.digests)
    conditions = case.conditions()
    binding = compiled.plant.binding(conditions.values or None)
    told["files"] |= digests(files_of(binding.root).values())
    if Path(case.start).suffix:
        told["files"] |= digests([case.start])
    journal = LateJournal(Path(job.journal)) if job.journal else None
    earlier = _left(journal, binding)
    options = {"solver": case.solver, "step": case.step, "tolerance": case.tolerance, "journal": journal}
    try:
        with _means(compiled.plant, job.starts):
            given = conditions if earlier is None else conditions.but(start=earlier)
            later = compiled.plant.simulate(conditions=given, progress=report, **options)
    except SimulationError as error:
        partial: Result | None = getattr(error, "result", None)
        if earlier is not None and partial is not None:
            error.result = earlier.followed_by(partial)  # type: ignore[attr-defined]
        if journal is not None and not _is_interrupt(error):
            journal.remove()
        raise
    result = later if earlier is None else earlier.followed_by(later)
    told["simulated"] = float(result.time[-1])
    told["statistics"] = statistics_of(result)
    if job.result:
        path = result.save(job.result)
        told |= {"result": path.name, "bytes": path.stat().st_size}
    if journal is not None:
        journal.remove()
    with suppress(OSError):
        os.unlink(job.partial)


class LateJournal(Journal):
    """A journal that begins with its first piece, when a run has taken some seconds; shorter ones write none."""

    _about: Mapping[str, Any] | None = None

    def begin(self, about: Mapping[str, Any], earlier: Stored | None = None, checkpoint: bytes = b"") -> None:
        """Wait, unless there is something to go on from."""
        if earlier is None and not checkpoint:
            self._about = about
        else:
            super().begin(about, earlier, checkpoint)

    def write(self, raw: RawTrajectory | None, values: Mapping[str, np.ndarray], checkpoint: bytes) -> None:
        """Add output points, and replace the checkpoint."""
        if self._about is not None:
            about, self._about = self._about, None
            super().begin(about)
        super().write(raw, values, checkpoint)


def _left(journal: Journal | None, binding: Binding) -> Result | None:
    """What a run of the same that was killed has left to go on from."""
    from fowtlib.solving.results import Result

    if journal is None or not journal.path.exists():
        return None
    try:
        earlier = Result.open(journal.path)
        earlier.check_resumable(binding.values, binding.structure)
    except ModelError:  # it was another one, or had not computed anything
        journal.remove()
        return None
    return earlier


def forget_journal(output: Path) -> None:
    """Take away what a run to this file has left, which has become another one."""
    with suppress(OSError):
        Journal(output).remove()


def _compiled(job: Job) -> _Compiled:
    """The plant of a job, compiled once in a process as long as the files of its model stay the same."""
    from fowtlib.language.leave import require_leave
    from fowtlib.modelfile import load

    key = (job.model, job.allow_python, job.trust, tuple(job.allow))
    known = _plants.pop(key, None)
    if known is None or digests(known.model.files) != known.digests:
        del known  # before the memory is needed again
        while len(_plants) >= _KEPT:
            del _plants[next(iter(_plants))]
        model = load(job.model, allow_python=job.allow_python, trust=job.trust, allow=job.allow)
        require_leave(model.root)
        known = _Compiled(model, model.compile(), digests(model.files))
        gc.collect()
        gc.freeze()  # a model is a million objects that stay: looking through them again and again costs 6 %
    _plants[key] = known
    return known


@contextmanager
def _means(plant: Plant, folder: str) -> Iterator[None]:
    """Let a run know the means that others of the batch have found, and them the ones that it finds."""
    if not folder:
        yield
        return
    known = plant.kept_starts
    with suppress(OSError):
        for path in Path(folder).glob("*.json"):
            key = path.stem.replace("-", " ", 1)
            if key not in known:
                with suppress(ValueError):  # another one is found, where this cannot be read
                    known[key] = json.loads(path.read_text())
    before = set(known)
    try:
        yield
    finally:
        for key in known.keys() - before:
            with suppress(ModelError, OSError):  # it is found again
                Path(folder).mkdir(exist_ok=True)
                write_text(Path(folder) / f"{key.replace(chr(32), chr(45), 1)}.json", json.dumps(known[key]))


def _keep_partial(error: ModelError, job: Job, told: dict[str, Any]) -> None:
    """Save what a case has computed before it failed, and say where that is."""
    partial: Result | None = getattr(error, "result", None) if isinstance(error, SimulationError) else None
    if isinstance(error, SimulationError) and _is_interrupt(error):
        told |= {"state": STOPPED}
        return
    if partial is None or partial.time.size < 2 or not job.partial:
        return
    told["simulated"] = float(partial.time[-1])
    try:
        path = partial.save(job.partial)
    except ModelError as problem:
        told["message"] += f"\nWhat it has computed cannot be saved: {problem}"
        return
    told |= {"result": path.name, "bytes": path.stat().st_size}
    told["message"] += f"\nThe results up to t = {partial.time[-1]:g} s are saved in {path.name}."


def _is_interrupt(error: SimulationError) -> bool:
    from fowtlib.solving.run import Interrupted

    return isinstance(error, Interrupted)


# --- the files that a result depends on ------------------------------------------------------------------------------


def digests(paths: Any) -> dict[str, str]:
    """Digests of files by path; of those that fowtlib brings by their place in it, wherever that is installed."""
    shipped = str(_shipped())
    found = {}
    for path in paths:
        whole = os.path.realpath(path)
        name = SHIPPED + os.path.relpath(whole, shipped) if whole.startswith(shipped + os.sep) else whole
        found[name] = _digest(whole)
    return found


def changes(files: Mapping[str, str]) -> list[str]:
    """Which of these files have another content now, in words."""
    found = []
    for name, digest in files.items():
        now = _digest(place_of(name))
        if now != digest:
            found.append(f"{name.removeprefix(SHIPPED)} {'has changed' if now else 'is gone'}")
    return found


def place_of(name: str) -> str:
    """The path of a file that `digests` names."""
    return os.path.join(_shipped(), name.removeprefix(SHIPPED)) if name.startswith(SHIPPED) else name


def _shipped() -> Path:
    from fowtlib.modelfile.files import models_folder

    return models_folder().resolve()


def _digest(path: str) -> str:
    try:
        return digest_of(path)
    except OSError:
        return ""
