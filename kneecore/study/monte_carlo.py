"""Monte Carlo in the true model: what the uncertainty does on average.

Examples
--------
>>> import kneecore
>>> study = kneecore.monte_carlo(kneecore.Knee(), kneecore.SamplingSettings(n_samples=1000))
>>> study.n_failed
0
>>> bool(4.5 < study.y.sd[5] < 6.5)  # deg, at +5 N m
True
"""

import time
from collections import deque
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kneecore._threads import thread_count
from kneecore._version import versions
from kneecore.errors import ModelError, ParameterError
from kneecore.model import Evaluation, Model
from kneecore.numerics.moments import GappyStream, Stream, restored
from kneecore.numerics.sampling import batches, n_drawn
from kneecore.presented import Presented
from kneecore.progress import Callback, Cancelled, Clock, Progress
from kneecore.record import Arrays, KeptStep, kept_step
from kneecore.study.arguments import checked_settings
from kneecore.study.partial import count_partial
from kneecore.study.settings import SamplingSettings

__all__ = ["MonteCarloResult", "Spread", "monte_carlo"]

FloatArray = NDArray[np.float64]
BATCH = 2048


@dataclass(frozen=True, kw_only=True, eq=False)
class Spread:
    """How one quantity is spread over the samples; every array has the quantity's shape."""

    mean: FloatArray
    sd: FloatArray
    """Standard deviation."""
    sigma_lower: FloatArray
    """Mean less three standard deviations: the paper's 99.7 % bound."""
    sigma_upper: FloatArray
    percentile_lower: FloatArray
    """0.15 % of the samples lie below."""
    percentile_upper: FloatArray


@dataclass(frozen=True, kw_only=True, eq=False)
class MonteCarloResult(Presented):
    """The outcome of a Monte-Carlo study. Failed samples are in no statistic."""

    model: Model
    """What was sampled. Read from a file, a model that is no knee has no function."""
    settings: SamplingSettings
    y: Spread
    """The outputs, shape (m,)."""
    observed: Mapping[str, Spread]
    """Further quantities of the model by name, with their units in it: the knee's tensions, contact
    forces and positions."""
    n_samples: int
    """Samples drawn, failed ones included."""
    counts: Mapping[str, int]
    """Samples by what became of them, "failed" always; of knees also "refined" (a smaller time step
    was needed), "unsettled" (still turning at some load), "not_at_rest" (more than 0.1 deg from its
    own equilibrium at some load) and "implausible" (in a pose that no knee takes), all three in the
    statistics, and "lost" (failed, for there was no equilibrium to follow); of other models
    "partial" (some outputs failed: the others are in the statistics) and "reused" (taken from the
    runs that were kept)."""
    below: FloatArray | None
    """Share of the samples whose output is below each of the marks asked for, shape (k, m)."""
    stop_reason: str
    """`all_samples` or `cancelled`."""
    seconds: Mapping[str, float]
    threads: int
    versions: Mapping[str, str]
    n_used: NDArray[np.int64] | None = None
    """Samples in each output's statistics, shape (m,), where some failed in some outputs only."""

    @property
    def n_failed(self) -> int:
        """Samples that failed."""
        return self.counts["failed"]


@dataclass(kw_only=True)
class _Sums:
    """What is kept of the samples until now."""

    total: int
    marks: FloatArray | None
    streams: dict[str, Stream | GappyStream] = field(default_factory=dict)
    counts: dict[str, int] = field(default_factory=lambda: {"failed": 0})
    below: Any = 0.0
    n_done: int = 0

    def add(self, done: Evaluation) -> None:
        """Take in a batch; failed samples only count, and an output that failed costs itself."""
        finite = np.isfinite(done.y)
        good, usable = finite.all(axis=1), finite.any(axis=1)
        self._add_y(done.y[usable], with_gaps=bool((usable & ~good).any()))
        for name, values in done.observed.items():
            self.streams.setdefault(name, Stream(self.total)).add(values[good])
        if self.marks is not None:
            self.below = self.below + (done.y[usable][:, None] < self.marks[None]).sum(axis=0)
        for name, count in done.counts.items():
            self.counts[name] = self.counts.get(name, 0) + count
        count_partial(self.counts, done.y)
        self.n_done += len(done.y)

    def _add_y(self, y: FloatArray, *, with_gaps: bool) -> None:
        stream = self.streams.setdefault("", Stream(self.total))
        if with_gaps and isinstance(stream, Stream):
            stream = self.streams[""] = GappyStream(stream, y.shape[1])
        stream.add(y)

    @property
    def n_used(self) -> NDArray[np.int64] | None:
        """Samples in each output's statistics, where they are not all the same."""
        stream = self.streams[""]
        return stream.n if isinstance(stream, GappyStream) else None

    @property
    def n_good(self) -> int:
        return self.n_done - self.counts["failed"]

    def state(self) -> Arrays:
        """All that is kept, in arrays."""
        counts = {f"count {name}": np.array(n) for name, n in self.counts.items()}
        below = {} if self.marks is None else {"below": np.asarray(self.below, dtype=np.int64)}
        streams = {
            f"stream {part} {name}": values
            for name, stream in self.streams.items()
            for part, values in stream.state.items()
        }
        return {"n_done": np.array(self.n_done), **counts, **below, **streams}

    def restore(self, state: Arrays) -> None:
        """Go on from a `state`."""
        parts: dict[str, dict[str, FloatArray]] = {}
        for key, values in state.items():
            kind, _, name = key.partition(" ")
            if kind == "count":
                self.counts[name] = int(values)
            elif kind == "stream":
                part, _, name = name.partition(" ")
                parts.setdefault(name, {})[part] = np.asarray(values, dtype=np.float64)
        for name, own in parts.items():
            self.streams[name] = restored(self.total, own)
        self.below = state.get("below", 0.0)
        self.n_done = int(state["n_done"])


def _spread(stream: Stream | GappyStream) -> Spread:
    sigma, percentile = stream.sigma_bounds(), stream.percentile_bounds()
    return Spread(
        mean=stream.mean,
        sd=stream.sd,
        sigma_lower=sigma[0],
        sigma_upper=sigma[1],
        percentile_lower=percentile[0],
        percentile_upper=percentile[1],
    )


def _shares(sums: _Sums) -> FloatArray:
    n = sums.n_good if sums.n_used is None else np.maximum(sums.n_used, 1)
    shares: FloatArray = sums.below / n
    return shares


def _checked_marks(marks: ArrayLike | None, n_outputs: int) -> FloatArray | None:
    if marks is None:
        return None
    try:
        values = np.atleast_2d(np.asarray(marks))
        usable = values.dtype.kind in "iuf"
    except ValueError:
        usable = False
    if not usable or values.ndim != 2 or values.shape[1] != n_outputs:
        shape = f"has shape {np.shape(values)}" if usable else "is not an array of numbers"
        raise ParameterError(f"`marks` {shape}; (k, {n_outputs}) is allowed")
    return values.astype(np.float64)


def monte_carlo(
    model: Model,
    settings: SamplingSettings | None = None,
    *,
    marks: ArrayLike | None = None,
    callback: Callback | None = None,
) -> MonteCarloResult:
    """Sample the true model: uniformly within the bounds, or by its inputs' distributions.

    Parameters
    ----------
    model : Model
        Such as `Knee`.
    settings : SamplingSettings, optional
    marks : array_like, shape (k, m), optional
        Outputs whose place in the sampled distribution is wanted, such as a worst case's.
    callback : callable, optional
        Gets `Progress`; a true result cancels: the statistics of what was done are returned, or
        `Cancelled` is raised where that is less than two samples.

    Raises
    ------
    ParameterError
        If an argument is not allowed.
    ModelError
        If fewer than two samples gave an answer.
    """
    settings = checked_settings(model, SamplingSettings, settings, callback)
    total = n_drawn(settings.n_samples, settings.sampling)
    sums = _Sums(total=total, marks=_checked_marks(marks, model.n_outputs))
    start = time.perf_counter()
    cancelled = _sample(model, settings, sums, callback)
    if cancelled and sums.n_good < 2:
        raise Cancelled
    if sums.n_good < 2:
        raise ModelError(
            f"{sums.counts['failed']} of {sums.n_done} samples failed; at least 2 answers are "
            f"needed{model.told_failure}"
        )
    spreads = {name: _spread(stream) for name, stream in sums.streams.items()}
    return MonteCarloResult(
        model=model,
        settings=settings,
        y=spreads.pop(""),
        observed=spreads,
        n_samples=sums.n_done,
        counts=sums.counts,
        below=None if sums.marks is None else _shares(sums),
        n_used=sums.n_used,
        stop_reason="cancelled" if cancelled else "all_samples",
        seconds={"sampling": time.perf_counter() - start},
        threads=thread_count(model.threads),
        versions=versions(),
    )


def _sample(
    model: Model, settings: SamplingSettings, sums: _Sums, callback: Callback | None
) -> bool:
    """Draw and run all samples; return whether the callback cancelled."""
    marks = None if sums.marks is None else sums.marks.tolist()
    step = kept_step("monte_carlo", model.identity, settings, marks)
    if step is not None and (kept := step.load()) is not None:
        sums.restore(kept)
    n_before = sums.n_done
    points = batches(
        sums.total, model.n_free, settings.seed, sampling=settings.sampling, size=BATCH
    )
    expected: deque[int] = deque()
    drawn = 0

    def points_left() -> Iterator[FloatArray]:
        nonlocal drawn
        for unit in points:
            drawn += len(unit)
            if drawn > n_before:  # the others were done before the computation was stopped
                expected.append(len(unit))
                yield model.drawn(unit)

    clock = Clock()

    def watch(done: int) -> object:
        done = min(n_before + done, sums.total)
        left = clock.left(done - n_before, sums.total - done)
        report = Progress(stage="sampling", done=done, total=sums.total, seconds_left=left)
        return callback is not None and callback(report)

    for done in model.stream(points_left(), observe=True, watch=watch):
        if len(done.y) < expected.popleft():  # cancelled in its midst: it will be done again
            _keep(step, sums, now=True)
            sums.add(done)
            return True
        sums.add(done)
        _keep(step, sums)
    _keep(step, sums, now=True)
    if sums.n_done < sums.total:
        return True
    watch(sums.total - n_before)
    return False


def _keep(step: KeptStep | None, sums: _Sums, *, now: bool = False) -> None:
    if step is not None:
        step.save(sums.state, now=now)
