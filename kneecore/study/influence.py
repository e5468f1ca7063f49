"""Which parameters decide the knee's angles: the answer that a worst case alone cannot give.

Examples
--------
>>> import kneecore
>>> found = kneecore.influence(kneecore.ParameterSpace(), n_base=256)
>>> found.deciding(5.0)[0]  # at 5 N m of extension
'condyle_x'
"""

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kneecore._threads import thread_count
from kneecore.errors import ModelError, ParameterError
from kneecore.knee.model import KneeModel
from kneecore.knee.parameters import STRUCTURE
from kneecore.knee.response import MOMENT, RestLength, Solver, check_solver
from kneecore.knee.space import ParameterSpace
from kneecore.numbers import plain
from kneecore.numerics.sampling import check_count
from kneecore.numerics.sensitivity import Indices, sobol_indices
from kneecore.progress import Callback, Cancelled, Progress
from kneecore.search.result import SearchResult, versions

__all__ = ["InfluenceResult", "WorstCaseSlopes", "influence", "worst_case_slopes"]

FloatArray = NDArray[np.float64]
N_RESAMPLES = 100
_STEP = 1e-4  # of a parameter's range, for central differences


@dataclass(frozen=True, kw_only=True, eq=False)
class InfluenceResult:
    """Sobol' indices of the 12 angles."""

    space: ParameterSpace
    rest_length: RestLength
    solver: Solver
    """Which response of the true model."""
    names: tuple[str, ...]
    """The free parameters, in the order of the indices' second axis."""
    indices: Indices
    """First axis the 12 loads, second axis the free parameters."""
    seed: int
    seconds: Mapping[str, float]
    threads: int
    versions: Mapping[str, str]

    @property
    def groups(self) -> dict[str, FloatArray]:
        """First-order indices summed over each group's parameters, shape (12,) each."""
        group_of = {row[0]: row[1] for row in STRUCTURE}
        sums: dict[str, FloatArray] = {}
        for k, name in enumerate(self.names):
            before = sums.get(group_of[name], np.zeros(len(MOMENT)))
            sums[group_of[name]] = before + self.indices.first_order[:, k]
        return sums

    def deciding(self, moment: float, count: int = 5) -> list[str]:
        """Return the parameters with the largest total indices at a load, largest first.

        Parameters
        ----------
        moment : float
            One of the 12 moments, N m; extension positive.
        count : int
            How many are wanted.
        """
        matches = np.flatnonzero(np.isclose(MOMENT, moment))
        if len(matches) == 0:
            raise ParameterError(
                f"`moment` is {moment!r}; one of {', '.join(f'{m:+g}' for m in MOMENT)} is allowed"
            )
        total = np.nan_to_num(self.indices.total_order[matches[0]])
        return [self.names[k] for k in np.argsort(-total, kind="stable")[:count]]

    def answer(self, moment: float = 5.0, *, label: Callable[[str], str] = str) -> str:
        """Return in one sentence what decides the angle at a load.

        Parameters
        ----------
        moment : float
            One of the 12 moments, N m; extension positive.
        label : callable
            Gives the parameters other names.
        """
        names = self.deciding(moment)
        load = int(np.argmin(np.abs(MOMENT - moment)))
        if self.indices.constant[load]:
            return f"At {moment:+g} N m the angle does not vary."
        share = sum(self.indices.first_order[load, self.names.index(n)] for n in names)
        shown = [label(name) for name in names]
        if len(shown) == 1:
            return f"At {moment:+g} N m {shown[0]} alone varies, and decides the angle."
        return (
            f"At {moment:+g} N m {', '.join(shown[:-1])} and {shown[-1]} decide the angle: alone "
            f"they explain {100.0 * share:.0f} % of its variance."
        )

    def to_dict(self) -> dict[str, Any]:
        """Return the result as JSON-ready values."""
        found = self.indices
        intervals = {
            name: None if both is None else {"lower": plain(both[0]), "upper": plain(both[1])}
            for name, both in (
                ("first_order", found.first_order_interval),
                ("total_order", found.total_order_interval),
            )
        }
        return {
            "schema": "kneecore.influence/1",
            "answer": self.answer(),
            "moment_nm": MOMENT.tolist(),
            "parameters": list(self.names),
            "first_order": plain(found.first_order),
            "total_order": plain(found.total_order),
            "interval_95": intervals,
            "groups_first_order": {name: plain(v) for name, v in self.groups.items()},
            "n_base": found.n_base,
            "n_evaluations": found.n_evaluations,
            "n_failed_rows": found.n_failed_rows,
            "seed": self.seed,
            "case": self.space.case,
            "rest_length": self.rest_length,
            "solver": self.solver,
            "baseline": {"title": self.space.title, "note": self.space.note},
            "versions": dict(self.versions),
            "seconds": {k: round(v, 6) for k, v in self.seconds.items()},
            "threads": self.threads,
        }

    def to_csv(self) -> str:
        """Return the indices as CSV, one line for each load and parameter."""
        lines = [
            "moment_nm,parameter,first_order,first_lower,first_upper,"
            "total_order,total_lower,total_upper"
        ]
        found = self.indices
        unknown = np.full((2, *found.first_order.shape), np.nan)
        first, total = (
            unknown if both is None else both
            for both in (found.first_order_interval, found.total_order_interval)
        )
        for k, moment in enumerate(MOMENT):
            for j, name in enumerate(self.names):
                row = (
                    found.first_order[k, j],
                    *first[:, k, j],
                    found.total_order[k, j],
                    *total[:, k, j],
                )
                cells = ["" if np.isnan(v) else f"{v:.6g}" for v in row]
                lines.append(f"{moment:g},{name},{','.join(cells)}")
        return "\n".join(lines) + "\n"

    def __str__(self) -> str:
        from kneecore.report.study import influence_report

        return influence_report(self)


def influence(
    space: ParameterSpace | None = None,
    *,
    n_base: int = 1024,
    seed: int = 0,
    rest_length: RestLength = "recomputed",
    solver: Solver = "dynamics",
    threads: int | None = None,
    intervals: bool = True,
    callback: Callback | None = None,
) -> InfluenceResult:
    """Return first-order and total Sobol' indices of the 12 angles in the true model.

    Parameters
    ----------
    space : ParameterSpace, optional
        The packaged baseline with its default bounds for None.
    n_base : int
        Base rows, rounded up to a power of two; the model is run n_free + 2 times for each.
    seed : int
        The same seed gives the same numbers on any number of threads.
    rest_length, solver, threads
        As for `simulate_batch`.
    intervals : bool
        Whether to bootstrap 95 % intervals.
    callback : callable, optional
        Gets `Progress`; a true result cancels (raises `Cancelled`).

    Raises
    ------
    ParameterError
        If an argument is not allowed, or no angle varies within the bounds.
    ModelError
        If too many models failed.
    """
    space = space or ParameterSpace()
    check_count("n_base", n_base)
    n_threads = thread_count(threads)
    model = KneeModel(space, rest_length, n_threads, check_solver(solver))
    start = time.perf_counter()

    def watch(done: int, total: int) -> object:
        if callback is None:
            return False
        return callback(Progress(stage="sampling", done=done, total=total))

    try:
        found = sobol_indices(
            model,
            space.n_free,
            n_base=n_base,
            seed=seed,
            n_resamples=N_RESAMPLES if intervals else 0,
            callback=watch,
        )
    except InterruptedError:
        raise Cancelled from None
    if found.constant.all():
        raise ParameterError(
            f"the bounds of the {space.n_free} free parameters move no angle; bounds that move at "
            "least one are needed"
        )
    return InfluenceResult(
        space=space,
        rest_length=rest_length,
        solver=solver,
        names=tuple(n for n, free in zip(space.names, space.free, strict=True) if free),
        indices=found,
        seed=seed,
        seconds={"total": time.perf_counter() - start},
        threads=n_threads,
        versions=versions(),
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class WorstCaseSlopes:
    """What the angles of two knees gain over each free parameter's half-range, by slope."""

    names: tuple[str, ...]
    slopes_deg: FloatArray
    """Change of angle for one half-range more of a parameter, shape (2, 12, n_free), deg."""

    def deciding(self, load: int, count: int = 5) -> list[str]:
        """Return the parameters whose slopes separate the two knees most at a load (index)."""
        weight = np.abs(self.slopes_deg[:, load]).sum(axis=0)
        return [self.names[k] for k in np.argsort(-weight, kind="stable")[:count]]


def worst_case_slopes(result: SearchResult) -> WorstCaseSlopes:
    """Return the slopes of the two worst-case knees' angles, by central differences.

    Raises
    ------
    ModelError
        If a model beside one of the two fails.
    """
    space = result.space
    model = KneeModel(space, result.rest_length, result.threads, result.solver)
    u = space.to_unit(result.x)[:, space.free]
    steps = _STEP * np.eye(space.n_free)
    # The worst case lies on bounds: keep both sides of the difference within the cube.
    centre = np.clip(u, _STEP, 1.0 - _STEP)
    points = np.concatenate([centre[:, None] + steps, centre[:, None] - steps], axis=1)
    angles = model(points.reshape(-1, space.n_free)).reshape(2, 2, space.n_free, len(MOMENT))
    if not np.isfinite(angles).all():
        raise ModelError("a model beside the worst case fails; its slopes are not known")
    per_half_range = 0.5 * (angles[:, 0] - angles[:, 1]) / (2.0 * _STEP)
    return WorstCaseSlopes(
        names=tuple(n for n, free in zip(space.names, space.free, strict=True) if free),
        slopes_deg=per_half_range.transpose(0, 2, 1),
    )
