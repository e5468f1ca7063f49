"""What running a model for some points has given."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kneecore.runs.evaluation import Evaluation

__all__ = ["Failure", "Part", "Trouble", "failed_part", "join", "with_count"]

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, eq=False)
class Failure:
    """One run that gave no usable outputs."""

    number: int
    """Which run of the model it was, from 1, in the order in which they were asked for."""
    x: FloatArray
    """The inputs, shape (d,)."""
    kind: str
    """`raised`, `returned` (something that is no outputs), `nan`, `timed out` or `died` (the
    process ended)."""
    message: str
    """What happened, in one line."""
    traceback: str
    """Where in the model it happened; empty where Python does not know."""
    files: str | None
    """The file with the traceback, or the folder of an external program's run, where kept."""
    seconds: float
    """Wall time of the last try."""
    tries: int
    """How often it was tried."""

    def __str__(self) -> str:
        where = f" (see {self.files})" if self.files else ""
        return f"run {self.number} {self.message}{where}"


@dataclass(frozen=True, kw_only=True)
class Trouble:
    """One row of a part that failed."""

    row: int
    kind: str
    message: str
    traceback: str = ""
    files: str | None = None
    seconds: float = 0.0
    tries: int = 1
    error: BaseException | None = field(default=None, compare=False)
    """What was raised, where it was in this process."""

    def __getstate__(self) -> dict[str, Any]:
        """Leave what was raised behind: not every exception can be sent."""
        return {**vars(self), "error": None}


@dataclass(frozen=True, kw_only=True, eq=False)
class Part:
    """What a worker has to say of the points that it was given."""

    done: Evaluation
    troubles: tuple[Trouble, ...] = ()
    """The rows that failed, in order."""
    seconds: float = 0.0
    """Wall time in the worker."""

    def __len__(self) -> int:
        return len(self.done.y)

    def moved(self, rows: int) -> tuple[Trouble, ...]:
        """Return the troubles as they are called `rows` further down."""
        return tuple(replace(t, row=t.row + rows) for t in self.troubles)


def _summed(counts: Sequence[Mapping[str, int]]) -> dict[str, int]:
    total: dict[str, int] = {}
    for one in counts:
        for name, count in one.items():
            total[name] = total.get(name, 0) + count
    return total


def _observed(parts: Sequence[Part]) -> dict[str, FloatArray]:
    """Return the quantities of all parts; NaN where a part, being all failed runs, has none."""
    known = next((p.done.observed for p in parts if p.done.observed), {})
    return {
        name: np.concatenate(
            [
                p.done.observed[name]
                if p.done.observed
                else np.full((len(p), *v.shape[1:]), np.nan)
                for p in parts
            ]
        )
        for name, v in known.items()
    }


def join(parts: Sequence[Part]) -> Part:
    """Return parts that follow one another as one."""
    if len(parts) == 1:
        return parts[0]
    starts = np.concatenate([[0], np.cumsum([len(p) for p in parts])])
    return Part(
        done=Evaluation(
            y=np.concatenate([p.done.y for p in parts]),
            counts=_summed([p.done.counts for p in parts]),
            observed=_observed(parts),
        ),
        troubles=tuple(
            t for p, start in zip(parts, starts[:-1], strict=True) for t in p.moved(int(start))
        ),
        seconds=sum(p.seconds for p in parts),
    )


def with_count(part: Part, name: str) -> Part:
    """Return a part with one more run counted by a name."""
    counts = {**part.done.counts, name: part.done.counts.get(name, 0) + 1}
    return replace(part, done=replace(part.done, counts=counts))


def failed_part(n_outputs: int, trouble: Trouble) -> Part:
    """Return the part of one run that failed altogether."""
    return Part(
        done=Evaluation(y=np.full((1, n_outputs), np.nan), counts={"failed": 1}),
        troubles=(replace(trouble, row=0),),
        seconds=trouble.seconds,
    )
