"""What a search in a surrogate that is not repaired can say of its pair, and offer in its place."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from kneecore.search.inside import best_places
from kneecore.search.problem import Outcome
from kneecore.search.result import Verdict
from kneecore.search.training import Training
from kneecore.search.verdict import Seen, judged, ranks_of

__all__ = ["judged_and_offered"]

FloatArray = NDArray[np.float64]


def judged_and_offered(outcome: Outcome, weights: FloatArray) -> Outcome:
    """Return an outcome with its verdict, and with a better pair of training runs, if there is one.

    The surrogate's own pair may fail in the model, or be less than what was run anyway.
    """
    training, f = outcome.training, outcome.objective_model
    assert training is not None
    i, j, best = best_places(training.values, weights)
    failed = f is None
    if f is None or f < best:
        outcome = _with_pair(outcome, training, [i, j], best)
    return replace(outcome, verdict=_verdict(outcome, training, weights, failed=failed))


def _with_pair(outcome: Outcome, training: Training, places: list[int], f: float) -> Outcome:
    u = training.points[places]
    return replace(
        outcome,
        found=replace(outcome.found, u=u, evidence=None),
        y=training.values[places],
        y_surrogate=training.surrogate(u),
        objective_model=f,
    )


def _verdict(outcome: Outcome, training: Training, weights: FloatArray, *, failed: bool) -> Verdict:
    f, promised = outcome.objective_model, outcome.objective_surrogate
    if not f or promised is None:
        return judged(None)
    signs = np.where(outcome.y[0] >= outcome.y[1], 1.0, -1.0) * weights
    surrogate = training.surrogate
    sums = surrogate.values @ signs
    n, d = training.points.shape
    return judged(
        Seen(
            history=(f,),
            promised=promised,
            ranks=ranks_of(sums, sums + surrogate.loo_errors @ signs),
            n_runs=n,
            n_inputs=d,
            n_failed=training.n_failed,
            n_failed_best=int(failed),
        )
    )
