"""What is done with points, wherever it is done: a function's runs, each failure caught.

A work is pickled by value (cloudpickle) and sent to workers, once to each.
"""

import time
import traceback
from collections import OrderedDict
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any, Protocol

import lazy_loader
import numpy as np
from numpy.typing import NDArray

from kneecore.errors import ParameterError
from kneecore.returned import run_all, run_one
from kneecore.runs.evaluation import Evaluation
from kneecore.runs.part import Part, Trouble

__all__ = ["BatchWork", "ExamineWork", "RowWork", "RunFailed", "Work", "dumped", "loaded"]

FloatArray = NDArray[np.float64]
LONGEST_TRACEBACK = 20_000
"""Characters that are kept: a recursion without end has millions."""
_MOST_LOADED = 8

cloudpickle: Any = lazy_loader.load("cloudpickle")


class Work(Protocol):
    """What a worker can do."""

    n_outputs: int
    by_row: bool
    """Whether one row is run after the other, so that one row is the least to be asked for."""
    keeps: bool
    """Whether the outputs are all, so that they may be taken from an earlier run."""

    def parts(self, x: FloatArray, *, observe: bool, patience: float) -> Iterator[Part]:
        """Yield what becomes of points (n, d), at the latest when `patience` seconds are over."""

    def warm_up(self) -> None:
        """Do what is to be done once in a process."""


class RunFailed(Exception):
    """A run that failed in a way of its own, with files that tell of it.

    Parameters
    ----------
    message : str
        What happened, in one line.
    files : str, optional
        Where to look.
    kind : str
        As `Failure.kind`.
    """

    def __init__(self, message: str, files: str | None = None, kind: str = "raised") -> None:
        super().__init__(message, files, kind)
        self.message, self.files, self.kind = message, files, kind


def _trouble(error: BaseException, row: int, seconds: float, tries: int) -> Trouble:
    """Return what an exception says, in one line."""
    if isinstance(error, RunFailed):
        return Trouble(
            row=row, kind=error.kind, message=error.message, files=error.files, seconds=seconds,
            tries=tries, error=error,
        )  # fmt: skip
    told = traceback.format_exception(error)
    line = " ".join(str(error).split())
    kind = "raised"
    if isinstance(error, ParameterError):
        kind = "returned"
    else:
        line = f"raised {type(error).__name__}" + (f": {line}" if line else "")
    return Trouble(
        row=row,
        kind=kind,
        message=line[:1000],
        traceback="".join(told)[-LONGEST_TRACEBACK:],
        seconds=seconds,
        tries=tries,
        error=error,
    )


def _not_finite(y: FloatArray, known: list[Trouble]) -> list[Trouble]:
    """Return the troubles of all rows: of those that were caught, and of outputs like NaN."""
    told = {t.row for t in known}
    for row in np.flatnonzero(~np.isfinite(y).all(axis=1)).tolist():
        if row not in told:
            n = int(np.count_nonzero(~np.isfinite(y[row])))
            message = f"returned NaN or infinity for {n} of {y.shape[1]} outputs"
            known.append(Trouble(row=row, kind="nan", message=message))
    return sorted(known, key=lambda t: t.row)


def _part(y: FloatArray, troubles: list[Trouble], seconds: float, retried: int) -> Part:
    troubles = _not_finite(y, troubles)
    counts = {"failed": len(troubles)} | ({"retried": retried} if retried else {})
    return Part(done=Evaluation(y=y, counts=counts), troubles=tuple(troubles), seconds=seconds)


class _FunctionWork:
    """Runs a function.

    Parameters
    ----------
    run : callable
        Takes a point (d,) and returns its outputs, (m,); or many points, where that is said.
    n_outputs : int
    retries : int
        How often a run that raised is tried again.
    """

    keeps = True

    def __init__(self, run: Callable[[FloatArray], Any], n_outputs: int, retries: int = 0) -> None:
        self.run, self.n_outputs, self.retries = run, n_outputs, retries

    def warm_up(self) -> None:
        """Nothing is known of what a function has to load."""


class RowWork(_FunctionWork):
    """Runs a function of one point at a time."""

    by_row = True

    def parts(self, x: FloatArray, *, observe: bool, patience: float) -> Iterator[Part]:
        """Yield what becomes of points (n, d); see `Work`."""
        y = np.empty((len(x), self.n_outputs))
        troubles: list[Trouble] = []
        first, retried, began = 0, 0, time.perf_counter()
        for row, point in enumerate(x):
            tries = self._fill(y[row], point, row - first, troubles)
            retried += tries > 1
            now = time.perf_counter()
            if now - began >= patience or row == len(x) - 1:
                yield _part(y[first : row + 1], troubles, now - began, retried)
                first, retried, troubles = row + 1, 0, []
                began = time.perf_counter()

    def _fill(self, y: FloatArray, point: FloatArray, row: int, troubles: list[Trouble]) -> int:
        """Put the outputs of a point into `y`; return how often it was tried."""
        for tries in range(1, self.retries + 2):
            began = time.perf_counter()
            try:
                y[:] = run_one(self.run, point, self.n_outputs)
            # sys.exit in a model is its failure, not our end.
            except (Exception, SystemExit) as error:
                if tries <= self.retries:
                    continue
                y[:] = np.nan
                troubles.append(_trouble(error, row, time.perf_counter() - began, tries))
            return tries
        raise AssertionError


class BatchWork(_FunctionWork):
    """Runs a function of many points at once.

    Where it raises, or returns what is no outputs, halves of the points are tried, and so on, until
    the points that it fails for are alone.
    """

    by_row = False

    def parts(self, x: FloatArray, *, observe: bool, patience: float) -> Iterator[Part]:
        """Yield what becomes of points (n, d), at once."""
        y = np.full((len(x), self.n_outputs), np.nan)
        troubles: list[Trouble] = []
        began = time.perf_counter()
        pending = [(0, len(x))] if len(x) else []
        of_all: BaseException | None = None
        retried = 0
        while pending:
            first, last = pending.pop()
            error, seconds, tries = self._fill(y[first:last], x[first:last])
            if error is None:
                retried += (last - first) * (tries > 1)
                continue
            of_all = of_all or error
            # What has another shape has it for any points; what raised may do so for one of them.
            shaped = isinstance(error, ParameterError) and error.__cause__ is None
            if shaped or last - first == 1:
                trouble = _trouble(error, first, seconds, self.retries + 1)
                troubles += [replace(trouble, row=row) for row in range(first, last)]
                continue
            middle = (first + last) // 2
            pending += [(middle, last), (first, middle)]
        if len(troubles) == len(x) and isinstance(of_all, ParameterError):
            # It fails for any points: what it said of all of them says best how it is called.
            troubles[0] = _trouble(of_all, 0, 0.0, self.retries + 1)
        yield _part(y, troubles, time.perf_counter() - began, retried)

    def _fill(self, y: FloatArray, x: FloatArray) -> tuple[BaseException | None, float, int]:
        """Put the outputs of points into `y`; return what the last try raised, its time, number."""
        raised: BaseException | None = None
        for tries in range(1, self.retries + 2):
            began = time.perf_counter()
            try:
                y[:] = run_all(self.run, x, self.n_outputs)
                return None, 0.0, tries
            except (Exception, SystemExit) as error:
                raised = error
        return raised, time.perf_counter() - began, tries


class ExamineWork:
    """Asks something that examines many points itself, such as a model with counts of its own.

    Parameters
    ----------
    model : object
        With `examine(x, observe=...)`, `n_outputs` and `warm_up()`.
    """

    by_row = False
    keeps = False

    def __init__(self, model: Any) -> None:
        self.model, self.n_outputs = model, int(model.n_outputs)

    def warm_up(self) -> None:
        """Load what the first run would have to wait for."""
        self.model.warm_up()

    def parts(self, x: FloatArray, *, observe: bool, patience: float) -> Iterator[Part]:
        """Yield what becomes of points (n, d), at once; its failures are counted by itself."""
        began = time.perf_counter()
        done: Evaluation = self.model.examine(x, observe=observe)
        yield Part(done=done, seconds=time.perf_counter() - began)


def dumped(work: Work) -> bytes:
    """Return a work as bytes that another process can load.

    Raises
    ------
    ParameterError
        If it cannot be sent.
    """
    try:
        sent: bytes = cloudpickle.dumps(work)
    except Exception as error:  # whatever a stranger's __reduce__ raises
        said = " ".join(str(error).split())[:300]
        raise ParameterError(
            f"the model cannot be sent to another process ({type(error).__name__}: {said}); a "
            "function of a module, which opens its files and connections itself, can be"
        ) from None
    return sent


_LOADED: OrderedDict[str, Work] = OrderedDict()


def loaded(digest: str, blob: bytes) -> Work:
    """Return the work in `blob`; it is loaded once in a process."""
    work = _LOADED.get(digest)
    if work is None:
        work = cloudpickle.loads(blob)
        work.warm_up()
        _LOADED[digest] = work
        while len(_LOADED) > _MOST_LOADED:
            _LOADED.popitem(last=False)
    return work
