"""The worst case that follows the visitor's hand: what is asked, and the answer. No widget.

It is searched around the visitor's own knee, in the true model, among knees at rest: exactly what
``worst_case(Knee(space, solver="equilibrium"), SearchSettings(method="exact"))`` finds without a
browser.
"""

from collections.abc import Callable
from dataclasses import dataclass

import kneecore
from kneecore import (
    Cancelled,
    Knee,
    MonteCarloResult,
    SamplingSettings,
    SearchResult,
    SearchSettings,
)

N_SAMPLES = 2000
"""Knees behind the band."""


@dataclass(frozen=True, kw_only=True, eq=False)
class LiveRequest:
    """What the visitor has set."""

    knee: Knee
    """The knees at rest within the bounds around his."""
    search: SearchSettings


@dataclass(frozen=True, kw_only=True, eq=False)
class LiveAnswer:
    """The two most different knees at rest, and where the others are."""

    request: LiveRequest
    result: SearchResult
    sampled: MonteCarloResult
    """Knees at rest within the same bounds; those without an equilibrium are counted."""


def find(request: LiveRequest, stop: Callable[[], bool]) -> LiveAnswer:
    """Search and sample.

    Parameters
    ----------
    request : LiveRequest
    stop : callable
        Asked between any two batches of models; a true answer cancels.

    Raises
    ------
    Cancelled
        If `stop` said so.
    KneecoreError
        If there is no worst case within these bounds.
    """
    result = kneecore.worst_case(request.knee, request.search, callback=lambda _: stop())
    if result.stop_reason == "cancelled":
        raise Cancelled
    sampled = kneecore.monte_carlo(
        request.knee, SamplingSettings(n_samples=N_SAMPLES, seed=request.search.seed)
    )
    return LiveAnswer(request=request, result=result, sampled=sampled)
