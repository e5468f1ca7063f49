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
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kneecore._threads import thread_count
from kneecore._version import versions
from kneecore.errors import ModelError, ParameterError
from kneecore.model import Evaluation, Model
from kneecore.numerics.moments import Stream
from kneecore.numerics.sampling import batches, n_drawn
from kneecore.presented import Presented
from kneecore.progress import Callback, Progress
from kneecore.record import Arrays, kept_step
from kneecore.study.arguments import checked_settings
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
    was needed), "unsettled" (not at rest at some load, but in the statistics) and "lost" (failed,
    for there was no equilibrium to follow)."""
    below: FloatArray | None
    """Share of the samples whose output is below each of the marks asked for, shape (k, m)."""
    stop_reason: str
    """`all_samples` or `cancelled`."""
    seconds: Mapping[str, float]
    threads: int
    versions: Mapping[str, str]

    @property
    def n_failed(self) -> int:
        """Samples that failed."""
        return self.counts["failed"]


@dataclass(kw_only=True)
class _Sums:
    """What is kept of the samples until now."""

    total: int
    marks: FloatArray | None
    streams: dict[str, Stream] = field(default_factory=dict)
    counts: dict[str, int] = field(default_factory=lambda: {"failed": 0})
    below: Any = 0.0
    n_done: int = 0

    def add(self, done: Evaluation) -> None:
        """Take in a batch; failed samples only count."""
        good = np.isfinite(done.y).all(axis=1)
        for name, values in ({"": done.y} | dict(done.observed)).items():
            self.streams.setdefault(name, Stream(self.total)).add(values[good])
        if self.marks is not None:
            self.below = self.below + (done.y[good][:, None] < self.marks[None]).sum(axis=0)
        for name, count in done.counts.items():
            self.counts[name] = self.counts.get(name, 0) + count
        self.n_done += len(done.y)

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
            self.streams[name] = Stream(self.total)
            self.streams[name].state = own
        self.below = state.get("below", 0.0)
        self.n_done = int(state["n_done"])


def _spread(stream: Stream) -> Spread:
    sigma, percentile = stream.sigma_bounds(), stream.percentile_bounds()
    return Spread(
        mean=stream.mean,
        sd=stream.sd,
        sigma_lower=sigma[0],
        sigma_upper=sigma[1],
        percentile_lower=percentile[0],
        percentile_upper=percentile[1],
    )


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
    """Sample the true model within the bounds.

    Parameters
    ----------
    model : Model
        Such as `Knee`.
    settings : SamplingSettings, optional
    marks : array_like, shape (k, m), optional
        Outputs whose place in the sampled distribution is wanted, such as a worst case's.
    callback : callable, optional
        Gets `Progress`; a true result cancels: the statistics of what was done are returned.

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
    if sums.n_good < 2:
        raise ModelError(
            f"{sums.counts['failed']} of {sums.n_done} samples failed; at least 2 answers are "
            "needed"
        )
    spreads = {name: _spread(stream) for name, stream in sums.streams.items()}
    return MonteCarloResult(
        model=model,
        settings=settings,
        y=spreads.pop(""),
        observed=spreads,
        n_samples=sums.n_done,
        counts=sums.counts,
        below=None if sums.marks is None else sums.below / sums.n_good,
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
    points = batches(
        sums.total, model.n_free, settings.seed, sampling=settings.sampling, size=BATCH
    )
    drawn = 0
    for unit in points:
        drawn += len(unit)
        if drawn <= sums.n_done:  # these were done before the computation was stopped
            continue
        report = Progress(stage="sampling", done=sums.n_done, total=sums.total)
        if callback is not None and callback(report) and sums.n_done > 0:
            if step is not None:
                step.save(sums.state, now=True)
            return True
        sums.add(model.examine(model.from_free_unit(unit), observe=True))
        if step is not None:
            step.save(sums.state)
    if step is not None:
        step.save(sums.state, now=True)
    if callback is not None:
        callback(Progress(stage="sampling", done=sums.n_done, total=sums.total))
    return False
