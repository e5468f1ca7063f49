"""The worst case that follows the visitor's hand: what is asked, and the answer. No widget.

It is searched around the visitor's own knee, in the true model, among knees at rest: exactly what
``worst_case(Knee(space, solver="equilibrium"), SearchSettings(method="exact"))`` finds without a
browser.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass

import kneecore
from kneecore import (
    Cancelled,
    Knee,
    MonteCarloResult,
    Progress,
    SamplingSettings,
    SearchResult,
    SearchSettings,
)

N_SAMPLES = 2000
"""Knees behind the band."""
FIRST_SECONDS, NEXT_SECONDS = 0.1, 0.25
"""s of a search after which its best pair until then is told, and how often again if it improves.
By then it is within one or two per cent of the end; quick searches have ended."""
_BETTER = 1e-4  # of f: less is not worth a picture


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
    sampled: MonteCarloResult | None
    """Knees at rest within the same bounds; those without an equilibrium are counted. None while
    the search goes on."""

    @property
    def improving(self) -> bool:
        """Whether the search goes on: then it is the best pair until now."""
        return self.sampled is None


class _UntilNow:
    """Tells the search's best pair from time to time."""

    def __init__(self, request: LiveRequest, tell: Callable[[LiveAnswer], None]) -> None:
        self._request, self._tell = request, tell
        self._due, self._best = time.monotonic() + FIRST_SECONDS, 0.0

    def look(self, progress: Progress) -> None:
        now = time.monotonic()
        if progress.so_far is None or now < self._due:
            return
        self._due = now + NEXT_SECONDS
        result = progress.so_far()
        f = result.objective_model
        if f > self._best * (1.0 + _BETTER):
            self._best = f
            self._tell(LiveAnswer(request=self._request, result=result, sampled=None))


def find(
    request: LiveRequest, stop: Callable[[], bool], tell: Callable[[LiveAnswer], None]
) -> LiveAnswer:
    """Search and sample.

    Parameters
    ----------
    request : LiveRequest
    stop : callable
        Asked between any two batches of models; a true answer cancels.
    tell : callable
        Gets the best pair until then where the search takes long: soon, and as it improves.

    Raises
    ------
    Cancelled
        If `stop` said so.
    KneecoreError
        If there is no worst case within these bounds.
    """
    until_now = _UntilNow(request, tell)

    def watch(progress: Progress) -> bool:
        until_now.look(progress)
        return stop()

    result = kneecore.worst_case(request.knee, request.search, callback=watch)
    if result.stop_reason == "cancelled":
        raise Cancelled
    sampled = kneecore.monte_carlo(
        request.knee, SamplingSettings(n_samples=N_SAMPLES, seed=request.search.seed)
    )
    return LiveAnswer(request=request, result=result, sampled=sampled)
