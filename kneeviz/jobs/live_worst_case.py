"""The worst case that follows the visitor's hand: what is asked, and the answer. No widget.

It is searched around the visitor's own knee, in the true model, among knees at rest: exactly what
``worst_case(space, method="exact", solver="equilibrium")`` finds without a browser.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import kneecore
from kneecore import Cancelled, MonteCarloResult, ParameterSpace, SearchResult
from kneecore.knee.model import Objective

N_SAMPLES = 2000
"""Knees behind the band."""


@dataclass(frozen=True, kw_only=True, eq=False)
class LiveSettings:
    """What the visitor has set: one request."""

    space: ParameterSpace
    """The bounds, around his knee."""
    rest_length: Any
    objective: Objective
    seed: int


@dataclass(frozen=True, kw_only=True, eq=False)
class LiveAnswer:
    """The two most different knees at rest, and where the others are."""

    settings: LiveSettings
    result: SearchResult
    sampled: MonteCarloResult
    """Knees at rest within the same bounds; those without an equilibrium are counted."""


def find(settings: LiveSettings, stop: Callable[[], bool]) -> LiveAnswer:
    """Search and sample.

    Parameters
    ----------
    settings : LiveSettings
    stop : callable
        Asked between any two batches of models; a true answer cancels.

    Raises
    ------
    Cancelled
        If `stop` said so.
    KneecoreError
        If there is no worst case within these bounds.
    """
    # One thread: its batches are too small for two, and the other core draws.
    result = kneecore.worst_case(
        settings.space,
        method="exact",
        solver="equilibrium",
        objective=settings.objective,
        seed=settings.seed,
        rest_length=settings.rest_length,
        threads=1,
        callback=lambda _: stop(),
    )
    if result.stop_reason == "cancelled":
        raise Cancelled
    sampled = kneecore.monte_carlo(
        settings.space,
        n_samples=N_SAMPLES,
        solver="equilibrium",
        seed=settings.seed,
        rest_length=settings.rest_length,
        threads=1,
    )
    return LiveAnswer(settings=settings, result=result, sampled=sampled)
