"""The exact worst case of the knee: climbs with exact gradients at rest, then in motion.

Examples
--------
>>> from kneecore import ParameterSpace
>>> from kneecore.search.exact_model import exact_worst_case
>>> found = exact_worst_case(ParameterSpace(case="material"), solver="equilibrium")
>>> round(found.objective, 2)  # deg, summed over the 12 loads
35.57
"""

import time
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from kneecore.errors import ModelError
from kneecore.knee.model import KneeModel, Objective, load_weights
from kneecore.knee.response import MOMENT, RestLength, Solver, check_solver
from kneecore.knee.slopes import SettledKnee
from kneecore.knee.space import ParameterSpace
from kneecore.search.pattern_climb import MotionPair, climb_in_motion
from kneecore.search.sign_climb import Evidence, ExactPair, ExactSettings, Report, climb_pair

__all__ = ["ExactWorstCase", "exact_extremes", "exact_worst_case"]

FloatArray = NDArray[np.float64]
ALONG_LOADS = tuple(int(k) for k in np.argsort(-MOMENT, kind="stable"))
"""The loads from the largest extension to the largest flexion."""
_MANY_LOST = 0.01  # share of the models at rest without an equilibrium


@dataclass(frozen=True, kw_only=True, eq=False)
class ExactWorstCase:
    """The two most different knees by an exact search.

    Model 1 is the one with the smaller angle at the largest extension moment that counts.
    """

    u: FloatArray
    """The two knees in the unit cube of the free parameters, shape (2, n_free)."""
    x: FloatArray
    """The same, shape (2, 28), SI."""
    flexion_deg: FloatArray
    """Their angles in the response that was searched, shape (2, 12), deg."""
    objective: float
    """f, deg summed over the loads that count."""
    evidence: Evidence
    seconds: dict[str, float]
    """rest, motion"""


def _evidence(knee: SettledKnee, found: ExactPair, moved: MotionPair | None) -> Evidence:
    evidence = replace(
        found.evidence,
        n_evaluations=knee.n_simulated,
        n_lost=knee.n_lost,
        objective_at_rest=found.value,
    )
    if moved is None:
        return evidence
    return replace(
        evidence,
        second_best=moved.others[0] if moved.others else None,
        objective_before_climb=moved.first_value,
        n_in_motion=moved.n_models,
    )


def exact_worst_case(
    space: ParameterSpace | None = None,
    *,
    objective: Objective = "all",
    solver: Solver = "dynamics",
    rest_length: RestLength = "recomputed",
    seed: int = 0,
    threads: int | None = None,
    settings: ExactSettings | None = None,
    report: Report | None = None,
) -> ExactWorstCase:
    """Find the two most different knees of a space in the true model.

    Parameters
    ----------
    space : ParameterSpace, optional
        The knees to search; the packaged baseline with its default bounds for None.
    objective : {"all", "extension", "flexion"}
        Which of the 12 loads count.
    solver : {"dynamics", "equilibrium"}
        Which response: that of the motion over 23 s, or that at rest.
    rest_length, threads
        As for `simulate_batch`.
    seed : int
        The same seed gives the same bytes, on any number of threads.
    settings : ExactSettings, optional
        How much to look for; its seed is not used.
    report : callable, optional
        As for `kneecore.search.sign_climb.climb_pair`, with f at rest.

    Raises
    ------
    ParameterError
        If an argument is not allowed.
    ModelError
        If no knee could be evaluated.
    Cancelled
        If `report` ended the search before there was a pair.
    """
    return _search(
        space or ParameterSpace(),
        load_weights(objective),
        solver,
        rest_length,
        threads,
        replace(settings or ExactSettings(), seed=seed),
        report,
    )


def exact_extremes(
    space: ParameterSpace,
    load: int,
    *,
    solver: Solver = "dynamics",
    rest_length: RestLength = "recomputed",
    seed: int = 0,
    threads: int | None = None,
    report: Report | None = None,
) -> ExactWorstCase:
    """Find the knees of a space with the least and with the largest angle at one load.

    Parameters
    ----------
    space : ParameterSpace
    load : int
        Index into `MOMENT`.
    solver, rest_length, seed, threads, report
        As for `exact_worst_case`, which raises the same.

    Returns
    -------
    ExactWorstCase
        The first knee has the least angle; `objective` is the difference of the two, deg.
    """
    weights = np.zeros(len(MOMENT))
    weights[load] = 1.0
    settings = ExactSettings(seed=seed)
    return _search(space, weights, solver, rest_length, threads, settings, report)


def _search(
    space: ParameterSpace,
    weights: FloatArray,
    solver: Solver,
    rest_length: RestLength,
    threads: int | None,
    settings: ExactSettings,
    report: Report | None,
) -> ExactWorstCase:
    check_solver(solver)
    begun = time.perf_counter()
    knee = SettledKnee(space, rest_length, threads)
    found = climb_pair(
        knee, space.n_free, weights, order=ALONG_LOADS, settings=settings, report=report
    )
    rested = time.perf_counter()
    moved = None
    if solver == "dynamics":
        model = KneeModel(space, rest_length, threads)
        many_lost = knee.n_lost > _MANY_LOST * knee.n_simulated
        moved = climb_in_motion(model, found, weights, seed=settings.seed, many_lost=many_lost)
        if not np.isfinite(moved.value):
            raise ModelError("none of the worst pairs at rest could be simulated in motion")
    u, y = (found.u, found.y) if moved is None else (moved.u, moved.y)
    first = next(k for k in ALONG_LOADS if weights[k] > 0.0)
    if y[0, first] > y[1, first]:
        u, y = u[::-1].copy(), y[::-1].copy()
    return ExactWorstCase(
        u=u,
        x=space.from_free_unit(u),
        flexion_deg=y,
        objective=found.value if moved is None else moved.value,
        evidence=_evidence(knee, found, moved),
        seconds={"rest": rested - begun, "motion": time.perf_counter() - rested},
    )
