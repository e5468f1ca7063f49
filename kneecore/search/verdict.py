"""Whether a worst pair is to be trusted, from what the search has seen."""

from collections.abc import Sequence

import numpy as np
import scipy  # its subpackages are loaded when they are used: a knee's search needs none
from numpy.typing import NDArray

from kneecore.search.inside import Half
from kneecore.search.result import Verdict, gap_percent
from kneecore.search.training import Training

__all__ = ["judged"]

FloatArray = NDArray[np.float64]

# The limits were chosen on tests/benchmarks/any_model.py, where they are measured.
_GAP = 2.0  # per cent
_RANKS = 0.7  # rank correlation below which the surrogate knows too little of the model
_FEW_RANKS = 0.98  # the same where there are few runs for the number of inputs ...
_FEW = 10  # ... which is below this many for each
_ERROR = 0.25  # of f: mean error of the latest predictions
_RISE = 0.01  # of f: what the last part of the search may still have gained
_LATE = 0.3  # of the batches: that part
_FLAT = 1e-12  # of the outputs' size


def _ranks(training: Training, sums: FloatArray) -> float | None:
    """Return the rank correlation of the outputs' sum with its leave-one-out prediction."""
    true = training.surrogate.values @ sums
    predicted = true + training.surrogate.loo_errors @ sums
    if not np.isfinite(predicted).all() or np.ptp(true) == 0.0 or np.ptp(predicted) == 0.0:
        return None
    return float(scipy.stats.spearmanr(true, predicted).statistic)


def judged(
    history: Sequence[float],
    training: Training,
    weights: FloatArray,
    halves: Sequence[Half],
    promised: float,
) -> Verdict:
    """Judge the best pair of a search.

    Parameters
    ----------
    history : sequence of float
        Best f after each batch.
    training : Training
        All runs, and the surrogate through them.
    weights : ndarray, shape (m,)
    halves : sequence of Half
        The two of the best pair, with the errors of their latest predictions.
    promised : float
        The largest f that the surrogate promises.
    """
    best = history[-1]
    size = float(np.nanmax(np.abs(training.values) @ weights))
    if not np.isfinite(best) or best <= _FLAT * size:
        return Verdict(
            word="not found",
            reasons=(
                "No two runs differ by more than rounding; look at whether the inputs reach the "
                "outputs.",
            ),
        )
    reasons = _doubts(history, training, halves, promised)
    return Verdict(word="doubtful" if reasons else "trusted", reasons=tuple(reasons))


def _doubts(
    history: Sequence[float], training: Training, halves: Sequence[Half], promised: float
) -> list[str]:
    best, reasons = history[-1], []
    gap = gap_percent(promised, best)
    if gap is not None and gap > _GAP:
        reasons.append(
            f"The surrogate still promises {gap:.0f} % more than any run has shown; allow more "
            "runs."
        )
    late = history[int((1.0 - _LATE) * (len(history) - 1))]
    if best - late > _RISE * best:
        reasons.append(
            f"The last {100 * _LATE:.0f} % of the search still gained "
            f"{100 * (best - late) / best:.1f} %; allow more runs."
        )
    error = sum(h.error for h in halves) / best
    if error > _ERROR:
        reasons.append(
            f"The latest runs near the pair were {100 * error:.0f} % of f away from what was "
            "predicted: the model is rough, noisy or discontinuous there; run the pair again, "
            "allow more runs, or narrow the bounds."
        )
    reasons += _doubts_of_ranks(training, halves[0].sums)
    failed = training.n_failed
    if failed > 0.1 * len(training.points):
        reasons.append(
            f"{failed} of {len(training.points)} runs failed; a worse pair may lie where the model "
            "fails: look at why."
        )
    return reasons


def _doubts_of_ranks(training: Training, sums: FloatArray) -> list[str]:
    ranks, (n, d) = _ranks(training, sums), training.points.shape
    if ranks is None or ranks >= (_FEW_RANKS if n < _FEW * d else _RANKS):
        return []
    return [
        f"The surrogate orders left-out runs with a rank correlation of {ranks:.2f} only, with "
        f"{n} runs for {d} inputs; allow more runs."
    ]
