"""Whether to trust a worst pair, from what its search has seen: a sentence for each doubt."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import scipy  # its subpackages are loaded when they are used: a knee's search needs none
from numpy.typing import NDArray

from kneecore.search.result import Verdict, gap_percent

__all__ = ["Seen", "judged", "ranks_of"]

FloatArray = NDArray[np.float64]

# The limits were chosen on tests/benchmarks/any_model.py, where they are measured.
_GAP = 2.0  # per cent
_RANKS = 0.9
_FEW = 10  # runs for each input: below that the first runs alone must reach ranks of their own
_FIRST_RANKS = 0.95
_ERROR = 0.25  # of f: mean error of the latest predictions
_RISE = 0.01  # of f: what the last part of the search may still have gained
_LATE = 0.3  # of the batches: that part
_NOISE = 1e-3  # of f
_FAILED = 0.1  # of the runs


@dataclass(frozen=True, kw_only=True)
class Seen:
    """What a search has seen. Errors, noise and jump are in shares of f."""

    history: Sequence[float]
    """Best f after each batch."""
    promised: float
    """The largest f that the surrogate promises."""
    possible: float | None = None
    """The largest f within two standard deviations of the surrogate; None where it has none."""
    ranks: float | None
    """Rank correlation of left-out runs with what is predicted for them."""
    first_ranks: float | None = None
    """The same for the first runs alone, which lie evenly within the bounds."""
    n_runs: int
    n_inputs: int
    n_failed: int = 0
    n_failed_best: int = 0
    """Failed runs among those where more was promised than was known."""
    error: float = 0.0
    """Mean error of the latest predictions."""
    noise: float = 0.0
    jump: float = 0.0
    jump_width: float = 0.0
    """How near the two sides of the jump are, of the bounds' width."""


def ranks_of(true: FloatArray, predicted: FloatArray) -> float | None:
    """Return the rank correlation of numbers (n,) with what was predicted, where there is one."""
    if not np.isfinite(predicted).all() or np.ptp(true) == 0.0 or np.ptp(predicted) == 0.0:
        return None
    return float(scipy.stats.spearmanr(true, predicted).statistic)


def judged(seen: Seen | None) -> Verdict:
    """Judge the best pair of a search; None for a model whose outputs are all the same."""
    if seen is None:
        return Verdict(
            word="not found",
            reasons=(
                "No two runs differ by more than rounding; look at whether the inputs reach the "
                "outputs.",
            ),
        )
    reasons = tuple(sentence for doubt in _DOUBTS for sentence in doubt(seen))
    if reasons:
        return Verdict(word="doubtful", reasons=reasons, outlook=_outlook(seen))
    return Verdict(word="trusted", outlook=_outlook(seen))


def _late_gain(history: Sequence[float]) -> float:
    """Return what the last part of the search has gained, of f."""
    best = history[-1]
    return (best - history[int((1.0 - _LATE) * (len(history) - 1))]) / best


def _gap(seen: Seen) -> Iterator[str]:
    gap = gap_percent(seen.promised, seen.history[-1])
    if gap is not None and gap < -_GAP:
        yield (
            f"The surrogate is {-gap:.0f} % below what the model says of the pair; let it be "
            "repaired, or allow more runs."
        )
    if gap is not None and gap > _GAP:
        yield (
            f"The surrogate still promises {gap:.0f} % more than any run has shown; allow more "
            "runs."
        )


def _rising(seen: Seen) -> Iterator[str]:
    gain = _late_gain(seen.history)
    if gain > _RISE:
        yield (
            f"The last {100 * _LATE:.0f} % of the search still gained {100 * gain:.1f} %; allow "
            "more runs."
        )


def _ranks(seen: Seen) -> Iterator[str]:
    if seen.ranks is not None and seen.ranks < _RANKS:
        yield (
            f"The surrogate orders left-out runs with a rank correlation of {seen.ranks:.2f} only: "
            "another pair may be worse; allow more runs, or narrow the bounds."
        )


def _few(seen: Seen) -> Iterator[str]:
    few = seen.n_runs < _FEW * seen.n_inputs
    if few and seen.first_ranks is not None and seen.first_ranks < _FIRST_RANKS:
        yield (
            f"{seen.n_runs} runs are few for {seen.n_inputs} inputs whose effects depend on each "
            "other: over the whole bounds the surrogate orders left-out runs with a rank "
            f"correlation of {seen.first_ranks:.2f} only; allow more runs, or hold inputs that "
            "have little influence."
        )


def _noisy(seen: Seen) -> Iterator[str]:
    if seen.noise > _NOISE:
        told = (
            "failed" if np.isinf(seen.noise) else f"gave outputs {100 * seen.noise:.2g} % of f away"
        )
        yield (
            f"The pair run again {told}: the model is noisy; fix its random seed, tighten its "
            "tolerances, or average several runs."
        )


def _jumping(seen: Seen) -> Iterator[str]:
    if seen.jump > 0.0 and seen.noise <= _NOISE:
        yield (
            f"The model jumps: between two runs {100 * seen.jump_width:.2g} % of the bounds apart "
            f"its outputs change by {100 * seen.jump:.0f} % of f; search each side by itself, with "
            "bounds that end there."
        )


def _rough(seen: Seen) -> Iterator[str]:
    told = seen.noise > _NOISE or seen.jump > 0.0
    if seen.error > _ERROR and not told:
        yield (
            f"The latest runs near the pair were {100 * seen.error:.0f} % of f away from what was "
            "predicted: the model is rough there; allow more runs, or narrow the bounds."
        )


def _failing(seen: Seen) -> Iterator[str]:
    if seen.n_failed_best:
        yield (
            f"{seen.n_failed_best} runs failed where more was promised: the worst pair may lie "
            "where the model fails, and this one is the best that works; look at `model.failures`, "
            "or narrow the bounds."
        )
    elif seen.n_failed > _FAILED * seen.n_runs:
        yield (
            f"{seen.n_failed} of {seen.n_runs} runs failed; a worse pair may lie where the model "
            "fails: look at why."
        )


_DOUBTS = (_gap, _rising, _ranks, _few, _noisy, _jumping, _rough, _failing)


def _outlook(seen: Seen) -> str:
    gained, promised = 100 * _late_gain(seen.history), _more(seen, seen.promised)
    told = (
        f"What more runs would buy: the last {100 * _LATE:.0f} % of the search gained "
        f"{gained:.1f} %, and the surrogate promises {promised:.1f} % more"
    )
    if seen.possible is None:
        return f"{told}."
    return f"{told}; {_more(seen, seen.possible):.0f} % is within two standard deviations of it."


def _more(seen: Seen, f: float) -> float:
    return float(max(100 * (f / seen.history[-1] - 1.0), 0.0))
