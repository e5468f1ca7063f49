"""What a worst-case search found, with everything needed to judge and to repeat it."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from kneecore.model import Model
from kneecore.presented import Presented
from kneecore.search.settings import SearchSettings

__all__ = [
    "MANY_FAILED",
    "METHOD_NAMES",
    "MODELS",
    "BoundEvidence",
    "Evidence",
    "MethodTrace",
    "Repair",
    "RepairRound",
    "SampledBound",
    "SearchResult",
    "Verdict",
    "gap_percent",
]

FloatArray = NDArray[np.float64]

MODELS = ("baseline", "model_1", "model_2")
"""What the nominal model and the two that were found are called, in this order."""
METHOD_NAMES = {
    "ga_surrogate": "genetic algorithm in the surrogate (200 x 800)",
    "repair": "self-repairing surrogate",
    "exact": "exact gradients in the true model",
    "ga": "genetic algorithm in the true model (100 x 100)",
}
"""The methods of `kneecore.search.compare`, in words."""

MANY_FAILED = 0.01
"""Share of an exact search's models above which bounds count as so wide that models fail."""


def gap_percent(surrogate: float | None, model: float | None) -> float | None:
    """Return 100 (surrogate - model) / surrogate; None without both."""
    if surrogate is None or model is None or surrogate == 0.0:
        return None
    return 100.0 * (1.0 - model / surrogate)


@dataclass(frozen=True, kw_only=True)
class SampledBound:
    """What f is at most if slopes stay near the range that samples have shown; no proof."""

    widening_percent: float
    """Share of the sampled range of slopes by which they may leave it, on each side."""
    objective: float
    """Sampled bound of f in the model with gradients: for knees, at rest."""
    n_looks: int
    """Patterns of signs that slopes over the box did not rule out, and that were looked at on their
    own faces and in parts of the box, each with a sampled range of its own."""


@dataclass(frozen=True, kw_only=True)
class BoundEvidence:
    """What slopes over the whole bounds say about how good a result is; no proof.

    They are those of the model with gradients (for knees, at rest), for the best pair's signs.
    """

    n_inputs: int
    """Inputs that vary."""
    n_one_signed_sampled: int
    """Inputs whose slope kept its sign over the samples."""
    n_one_signed: int
    """Those whose slope kept it under a search for a change, too."""
    n_models: int
    """Models looked at for the signs."""
    n_failed: int
    """Those among them that failed; there is no bound over models that fail."""
    n_vertices: int | None
    """Vertices of the other inputs, for both models, all of them computed; None if those inputs are
    too many."""
    vertices_objective: float | None
    """Largest f on these vertices; None if they were not computed, or one failed."""
    vertices_in_motion: float | None
    """The same in the true model, where that is another one."""
    n_patterns: int
    """Patterns of signs of the outputs."""
    bounds: tuple[SampledBound, ...]
    """For more and more widening; none where models fail."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Evidence:
    """What an exact search says about how good its result is."""

    n_climbs: int
    """Climbs for the two models of the best pair, from random starts and from kicks."""
    share_reached: float
    """Share of them that ended in the best pair's value, to 0.01 % of f."""
    second_best: float | None
    """f of the best other basin: another corner with the same signs, or another pattern."""
    patterns: tuple[tuple[tuple[int, ...], float], ...]
    """Patterns of signs, in the order of the outputs, and the best value for each: the proxy's, if
    the search went on from one."""
    n_evaluations: int
    """Models evaluated, each with its gradient."""
    n_failed: int = 0
    """Those among them that failed (knees without an equilibrium) and were left out."""
    objective_proxy: float | None = None
    """f of the worst pair of the model with gradients: for knees, at rest."""
    objective_before_climb: float | None = None
    """f in the true model of the best pair that the proxy had proposed."""
    n_models: int = 0
    """Models run without a gradient, on the way from the proxy's pair: for knees, in motion."""
    bound: BoundEvidence | None = None
    """What slopes say; None if it was not asked for, or was cancelled."""

    @property
    def many_failed(self) -> bool:
        """Whether the bounds are so wide that models often fail within them."""
        return self.n_failed > MANY_FAILED * self.n_evaluations


@dataclass(frozen=True, kw_only=True)
class RepairRound:
    """One look at the surrogate's optimum in the true model."""

    n_models: int
    """Models added to the training samples by then, those of the optimum included."""
    objective_surrogate: float
    """f of the optimum by the surrogate that was not yet fitted to it."""
    objective_model: float | None
    """f of the same pair by the true model; None if one of the two failed."""
    gap_percent: float | None
    """100 (surrogate - model) / surrogate."""


@dataclass(frozen=True, kw_only=True)
class Repair:
    """The history of a surrogate's repair."""

    goal_percent: float
    """Gap below which the surrogate counts as repaired."""
    max_models: int
    """Models that were allowed."""
    n_models: int
    """Models that were added, failed ones included."""
    n_failed: int
    """Those among them that failed: they are in no fit."""
    n_checked: int = 0
    """Runs that then looked whether the model is noisy at the pair or jumps; in no fit either."""
    n_checked_failed: int = 0
    """Those among them that failed."""
    rounds: tuple[RepairRound, ...]
    """The gaps, the first that of the surrogate before the repair."""

    @property
    def reached(self) -> bool:
        """Whether the last gap is below the goal."""
        gap = self.rounds[-1].gap_percent if self.rounds else None
        return gap is not None and abs(gap) < self.goal_percent


@dataclass(frozen=True, kw_only=True)
class Verdict:
    """Whether a worst pair is to be trusted."""

    word: Literal["trusted", "doubtful", "not found"]
    reasons: tuple[str, ...] = ()
    """Why not, and what to do: a sentence each."""
    outlook: str = ""
    """What more runs would buy: a sentence, or nothing where there is no saying."""

    def __str__(self) -> str:
        return " ".join([f"Verdict: {self.word}.", *self.reasons])


@dataclass(frozen=True, kw_only=True)
class MethodTrace:
    """One method's worst case and the way to it; every f but the promised one is the model's."""

    method: str
    """A key of `METHOD_NAMES`."""
    promised: float | None
    """f by the surrogate that was searched; None for a search in the true model."""
    n_models: tuple[float, ...]
    """True models run by then, rising."""
    objective: tuple[float, ...]
    """Best f by then; empty if the true model failed for what was found."""
    seconds: float
    """Wall time, the kernels' compilation apart."""

    def shortfall_percent(self, best: float) -> float | None:
        """Return by how much the method's f falls short of `best`, per cent."""
        return 100.0 * (1.0 - self.objective[-1] / best) if self.objective and best else None


@dataclass(frozen=True, kw_only=True, eq=False)
class SearchResult(Presented):
    """The two most different models within bounds.

    Model 1 is the one with the smaller output in `Model.watched`: the knee that over-extends at the
    largest extension moment.
    """

    model: Model
    """What was searched: inputs with their bounds, outputs. Read from a file, a model that is no
    knee has no function and cannot be run."""
    settings: SearchSettings
    """How it was searched, with nothing left open."""
    x: FloatArray
    """The two models, shape (2, d); knees in SI."""
    y: FloatArray
    """The true model's outputs for them, shape (2, m); NaN where it failed."""
    y_nominal: FloatArray
    """Its outputs for the nominal inputs, shape (m,): the knee's baseline."""
    y_surrogate: FloatArray | None
    """The surrogate's outputs for the two, shape (2, m); None where it was not used."""
    responses: Mapping[str, Any]
    """All that the model tells of the nominal inputs (`baseline`), of `model_1` and of `model_2`:
    for knees their `Response`s. Empty where the outputs are all."""
    objective_surrogate: float | None
    """f by the surrogate, of a repaired one the largest that it still promises; None where the
    search was in the model."""
    objective_model: float | None
    """f by the model; None if one of the two fails there."""
    gap_percent: float | None
    """100 (surrogate - model) / surrogate; None without both."""
    training_x: FloatArray | None
    """Training inputs, shape (n, d)."""
    training_y: FloatArray | None
    """Their outputs, shape (n, m); NaN where the model failed."""
    loo_rms: float | None
    """The surrogate's root mean square leave-one-out error, in the outputs' unit."""
    run_values: tuple[float, ...]
    """Best f of each run of the genetic algorithm, in the space searched."""
    history: FloatArray
    """Best f after each generation of the best run."""
    stop_reason: str
    """`max_generations`, `converged` (an exact search), `repaired` or `not_repaired` (whether the
    surrogate's gap fell below the goal), or `cancelled`."""
    counts: Mapping[str, int]
    """Pairs evaluated; models simulated, and what became of them, over the whole search."""
    seconds: Mapping[str, float]
    """compile, sampling, fit, search (the optimisation alone), verify; compare_ and the method for
    each method compared."""
    threads: int
    """Threads that were used; the numbers do not depend on it."""
    versions: Mapping[str, str]
    evidence: Evidence | None = None
    """What an exact search says about how good its result is."""
    repair: Repair | None = None
    """How the surrogate was repaired; None if it was not asked to be."""
    verdict: Verdict | None = None
    """Whether the pair is to be trusted; None where the search does not judge itself: that of a
    knee, or one in the true model."""
    methods: tuple[MethodTrace, ...] = field(default=())
    """What all methods find in the same bounds (`kneecore.search.compare.with_methods`)."""

    @property
    def best_of_all(self) -> float | None:
        """The largest f in the true model, of this search and of all methods compared."""
        known = [m.objective[-1] for m in self.methods if m.objective]
        return max(
            [*known, *([self.objective_model] if self.objective_model else [])], default=None
        )

    def __repr__(self) -> str:
        return f"SearchResult({self.summary()!r}, objective_model={self.objective_model})"
