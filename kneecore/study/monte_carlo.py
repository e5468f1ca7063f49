"""Monte Carlo in the true model: what the uncertainty does on average.

Examples
--------
>>> import kneecore
>>> study = kneecore.monte_carlo(kneecore.ParameterSpace(), n_samples=1000)
>>> study.n_failed
0
>>> bool(4.5 < study.flexion_deg.sd[5] < 6.5)  # at +5 N m
True
"""

import time
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kneecore._threads import thread_count
from kneecore.errors import ModelError
from kneecore.knee.response import MOMENT, RestLength, Solver, simulate_batch
from kneecore.knee.space import ParameterSpace
from kneecore.numbers import plain
from kneecore.numerics.moments import Stream
from kneecore.numerics.sampling import Sampling, batches, n_drawn
from kneecore.progress import Callback, Progress
from kneecore.search.result import versions

__all__ = ["MonteCarloResult", "Spread", "monte_carlo"]

FloatArray = NDArray[np.float64]
BATCH = 2048
# (name in results and JSON, field of a response, factor from SI)
QUANTITIES = (
    ("flexion_deg", "flexion", float(np.degrees(1.0))),
    ("tension_n", "tension", 1.0),
    ("contact_force_n", "contact_force", 1.0),
    ("ap_position_mm", "ap_position", 1e3),
)


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

    def to_dict(self) -> dict[str, Any]:
        """Return the arrays as JSON-ready values."""
        return {
            "mean": plain(self.mean),
            "sd": plain(self.sd),
            "bounds_997": {
                "sigma": {"lower": plain(self.sigma_lower), "upper": plain(self.sigma_upper)},
                "percentile": {
                    "lower": plain(self.percentile_lower),
                    "upper": plain(self.percentile_upper),
                },
            },
        }


@dataclass(frozen=True, kw_only=True, eq=False)
class MonteCarloResult:
    """The outcome of a Monte-Carlo study. Failed samples are in no statistic."""

    space: ParameterSpace
    rest_length: RestLength
    sampling: Sampling
    seed: int
    n_samples: int
    """Samples drawn, failed ones included."""
    n_failed: int
    n_refined: int
    """Samples that needed a smaller time step."""
    n_unsettled: int
    """Samples, failed ones apart, not at rest at some load; they are in the statistics."""
    solver: Solver = "dynamics"
    """Which response was sampled: the motion over 23 s, or the knee at rest."""
    n_lost: int = 0
    """Failed samples that have no equilibrium to follow (`solver` "equilibrium")."""
    flexion_deg: Spread
    """Shape (12,)."""
    tension_n: Spread
    """Shape (12, 4)."""
    contact_force_n: Spread
    """Shape (12,)."""
    ap_position_mm: Spread
    """Shape (12,)."""
    below: FloatArray | None
    """Share of the samples whose angle is below each of the angles asked for, shape (k, 12)."""
    stop_reason: str
    """`all_samples` or `cancelled`."""
    seconds: Mapping[str, float]
    threads: int
    versions: Mapping[str, str]

    def to_dict(self) -> dict[str, Any]:
        """Return the result as JSON-ready values, units in the keys."""
        flexion = self.flexion_deg.to_dict()
        return {
            "schema": "kneecore.monte_carlo/1",
            "n_samples": self.n_samples,
            "n_failed": self.n_failed,
            "n_refined": self.n_refined,
            "n_unsettled": self.n_unsettled,
            "n_lost": self.n_lost,
            "solver": self.solver,
            "moment_nm": MOMENT.tolist(),
            "mean_deg": flexion["mean"],
            "sd_deg": flexion["sd"],
            "bounds_997_deg": flexion["bounds_997"],
            "tension_n": self.tension_n.to_dict(),
            "contact_force_n": self.contact_force_n.to_dict(),
            "ap_position_mm": self.ap_position_mm.to_dict(),
            "seed": self.seed,
            "sampling": self.sampling,
            "case": self.space.case,
            "rest_length": self.rest_length,
            "baseline": {"title": self.space.title, "note": self.space.note},
            "lower": dict(zip(self.space.names, self.space.lower.tolist(), strict=True)),
            "upper": dict(zip(self.space.names, self.space.upper.tolist(), strict=True)),
            "stop_reason": self.stop_reason,
            "versions": dict(self.versions),
            "seconds": {k: round(v, 6) for k, v in self.seconds.items()},
            "threads": self.threads,
        }

    def __str__(self) -> str:
        from kneecore.report.study import monte_carlo_report

        return monte_carlo_report(self)


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


def monte_carlo(
    space: ParameterSpace | None = None,
    *,
    n_samples: int = 10_000,
    sampling: Sampling = "uniform",
    seed: int = 0,
    rest_length: RestLength = "recomputed",
    solver: Solver = "dynamics",
    threads: int | None = None,
    angles_deg: ArrayLike | None = None,
    callback: Callback | None = None,
) -> MonteCarloResult:
    """Sample the true model within the bounds.

    Parameters
    ----------
    space : ParameterSpace, optional
        The packaged baseline with its default bounds for None.
    n_samples : int
        Samples; Sobol' sampling rounds up to a power of two.
    sampling : {"uniform", "latin-hypercube", "sobol"}
        How the points are drawn.
    seed : int
        The same seed gives the same numbers on any number of threads.
    rest_length, solver, threads
        As for `simulate_batch`; a knee without an equilibrium is a failure.
    angles_deg : array_like, shape (k, 12), optional
        Angles whose place in the sampled distribution is wanted, such as a worst case's.
    callback : callable, optional
        Gets `Progress`; a true result cancels: the statistics of what was done are returned.

    Raises
    ------
    ParameterError
        If an argument is not allowed.
    ModelError
        If fewer than two samples gave an answer.
    """
    space = space or ParameterSpace()
    total = n_drawn(n_samples, sampling)
    n_threads = thread_count(threads)
    streams = {name: Stream(total) for name, _, _ in QUANTITIES}
    marks = None if angles_deg is None else np.atleast_2d(np.array(angles_deg, dtype=np.float64))
    below = np.zeros((0, len(MOMENT)) if marks is None else marks.shape)
    n_done = n_failed = n_refined = n_unsettled = n_lost = 0
    cancelled = False
    start = time.perf_counter()
    for unit in batches(total, space.n_free, seed, sampling=sampling, size=BATCH):
        report = Progress(stage="sampling", done=n_done, total=total)
        if callback is not None and callback(report) and n_done > 0:
            cancelled = True
            break
        batch = simulate_batch(
            space.from_free_unit(unit),
            baseline=space.baseline,
            rest_length=rest_length,
            solver=solver,
            threads=n_threads,
        )
        lost = ~np.isnan(batch.lost_at)
        good = ~(batch.failed | lost)
        for name, attribute, factor in QUANTITIES:
            streams[name].add(factor * getattr(batch, attribute)[good])
        if marks is not None:
            angles = np.degrees(batch.flexion[good])
            below += (angles[:, None] < marks[None]).sum(axis=0)
        n_done += len(unit)
        n_failed += int(np.count_nonzero(~good))
        n_refined += int(np.count_nonzero(batch.refinements[good] > 0))
        n_unsettled += int(np.count_nonzero(~batch.settled[good].all(axis=1)))
        n_lost += int(np.count_nonzero(lost))
    if callback is not None and not cancelled:
        callback(Progress(stage="sampling", done=n_done, total=total))
    if n_done - n_failed < 2:
        raise ModelError(f"{n_failed} of {n_done} samples failed; at least 2 answers are needed")
    return MonteCarloResult(
        space=space,
        rest_length=rest_length,
        sampling=sampling,
        seed=seed,
        n_samples=n_done,
        n_failed=n_failed,
        n_refined=n_refined,
        n_unsettled=n_unsettled,
        solver=solver,
        n_lost=n_lost,
        **{name: _spread(streams[name]) for name, _, _ in QUANTITIES},
        below=None if marks is None else below / (n_done - n_failed),
        stop_reason="cancelled" if cancelled else "all_samples",
        seconds={"sampling": time.perf_counter() - start},
        threads=n_threads,
        versions=versions(),
    )
