"""The worst-case search for any batched model: sample, fit, search the pair, recompute.

Everything here lives in the unit cube of the free inputs; `kneecore.search.worst_case` maps it to
a user's bounds or to the knee's parameters.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from numbers import Real
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from kneecore.errors import ModelError, ParameterError
from kneecore.numerics.genetic import GeneticResult, maximize
from kneecore.numerics.genetic_options import GeneticOptions
from kneecore.numerics.pair import ModelPair, SurrogatePair
from kneecore.numerics.sampling import check_count, check_seed, uniform
from kneecore.numerics.surrogate import Surrogate
from kneecore.search.cancelled import Cancelled
from kneecore.search.exact import Evidence
from kneecore.search.progress import Callback, Progress
from kneecore.search.repair_history import Repair

__all__ = [
    "Found",
    "Method",
    "PairOutcome",
    "PairSettings",
    "SearchSpace",
    "Training",
    "checked_weights",
    "default_space",
    "find_pair",
    "gap_percent",
    "outputs_of",
    "pair_value",
    "search_pair",
    "train",
    "verified",
]

FloatArray = NDArray[np.float64]
UnitModel = Callable[[FloatArray], FloatArray]
SearchSpace = Literal["surrogate", "model"]
Method = Literal["ga", "exact"]


def default_space(method: str, *, repair: bool) -> SearchSpace:
    """Return what a search of the knee evaluates if nothing else is asked for."""
    return "model" if method == "exact" and not repair else "surrogate"


@dataclass(frozen=True, kw_only=True)
class PairSettings:
    """How to search. Defaults are the paper's main run."""

    method: Method = "ga"
    """The paper's genetic algorithm, or climbs with exact gradients."""
    search_space: SearchSpace = "surrogate"
    """What the search evaluates."""
    training_samples: int = 50
    """Model runs that the surrogate is fitted to."""
    pop_size: int = 200
    n_generations: int = 800
    n_runs: int = 1
    """Independent runs of the genetic algorithm; the best is kept."""
    options: GeneticOptions = field(default_factory=GeneticOptions)
    seed: int = 0
    repair: bool = False
    """Whether the surrogate is repaired around its own optimum (`kneecore.search.repair`)."""
    repair_gap_percent: float = 1.0
    """Gap at the optimum below which a surrogate counts as repaired, per cent."""
    repair_models: int = 40
    """Model runs that a repair may add to the training samples."""

    def __post_init__(self) -> None:
        if self.search_space not in get_args(SearchSpace):
            raise ParameterError(
                f"`search_space` is {self.search_space!r}; 'surrogate' or 'model' is allowed"
            )
        for name in ("training_samples", "pop_size", "n_generations", "n_runs"):
            object.__setattr__(self, name, check_count(name, getattr(self, name)))
        object.__setattr__(self, "seed", check_seed(self.seed))
        if not isinstance(self.options, GeneticOptions):
            raise ParameterError(f"`options` is {self.options!r}; GeneticOptions are allowed")
        self.options.split(self.pop_size)
        self._check_method()
        self._check_repair()

    def _check_method(self) -> None:
        """Raise if the method is unknown, or has options that are another's."""
        if self.method not in get_args(Method):
            raise ParameterError(f"`method` is {self.method!r}; 'ga' or 'exact' is allowed")
        if self.method == "ga":
            return
        for name, usual in (
            ("pop_size", 200),
            ("n_generations", 800),
            ("n_runs", 1),
            ("options", GeneticOptions()),
        ):
            if getattr(self, name) != usual:
                raise ParameterError(
                    f"`{name}` is {getattr(self, name)!r}; it is the genetic algorithm's, and the "
                    "method 'exact' has none of it"
                )

    def _check_repair(self) -> None:
        """Raise if the repair's options are not allowed, or are given without it."""
        check_count("repair_models", self.repair_models)
        gap = self.repair_gap_percent
        if isinstance(gap, bool) or not isinstance(gap, Real) or not 0.0 < gap < 100.0:
            raise ParameterError(
                f"`repair_gap_percent` is {gap!r}; a number above 0 and below 100 is allowed"
            )
        object.__setattr__(self, "repair_gap_percent", float(gap))
        object.__setattr__(self, "repair_models", int(self.repair_models))
        if self.repair and self.repair_models < 2:
            raise ParameterError(
                f"`repair_models` is {self.repair_models}; at least 2 are needed, for the "
                "surrogate's optimum is a pair"
            )
        if self.repair and self.search_space == "model":
            raise ParameterError(
                "`search_space` is 'model'; with `repair` it is the surrogate that is searched"
            )
        for name, usual in (("repair_gap_percent", 1.0), ("repair_models", 40)):
            if not self.repair and getattr(self, name) != usual:
                raise ParameterError(f"`{name}` is {getattr(self, name):g}; it needs `repair`")

    def check_training(self, n_dimensions: int) -> None:
        """Raise if the surrogate's linear tail needs more samples than there are."""
        if self.search_space == "surrogate" and self.training_samples < n_dimensions + 1:
            raise ParameterError(
                f"`training_samples` is {self.training_samples}; with {n_dimensions} free "
                f"parameters at least {n_dimensions + 1} are needed"
            )

    def run_seed(self, run: int) -> int:
        """Return the seed of the genetic algorithm's run; the first is the seed itself."""
        if run == 0:
            return int(self.seed)
        state = np.random.SeedSequence([self.seed, run]).generate_state(1, np.uint64)
        return int(state[0] >> np.uint64(1))


@dataclass(frozen=True, kw_only=True, eq=False)
class Training:
    """A surrogate and the samples it was fitted to."""

    surrogate: Surrogate
    points: FloatArray
    """All samples, failed ones included, shape (n, d), unit cube."""
    values: FloatArray
    """Their outputs, shape (n, m); NaN rows failed and were left out of the fit."""
    seconds_sampling: float
    seconds_fit: float

    @property
    def n_failed(self) -> int:
        """Number of samples whose model failed."""
        return int(np.count_nonzero(~np.isfinite(self.values).all(axis=1)))

    @property
    def loo_rms(self) -> float | None:
        """Root mean square of the leave-one-out errors, in the outputs' unit; None if unknown."""
        errors = self.surrogate.loo_errors
        return float(np.sqrt(np.mean(errors**2))) if np.isfinite(errors).all() else None


@dataclass(frozen=True, kw_only=True, eq=False)
class Found:
    """The best pair of one search, in the space that was searched."""

    u: FloatArray
    """The two models, shape (2, d), unit cube."""
    run_values: tuple[float, ...]
    """Best f of each run."""
    best_run: int
    history: FloatArray
    """Best f in the course of the best run."""
    n_evaluations: int
    """Pairs evaluated by the genetic algorithm, all runs."""
    stop_reason: str
    evidence: Evidence | None = None

    @property
    def value(self) -> float:
        """F of the pair."""
        return self.run_values[self.best_run]


@dataclass(frozen=True, kw_only=True, eq=False)
class PairOutcome:
    """The best pair found, in the unit cube, with the model's own word on it."""

    u: FloatArray
    """The two models, shape (2, d)."""
    y: FloatArray
    """The true model's outputs, shape (2, m); NaN where it failed."""
    y_surrogate: FloatArray | None
    """The surrogate's outputs, shape (2, m)."""
    objective_surrogate: float | None
    """f by the surrogate; of one that was repaired, the largest that it still promises."""
    objective_model: float | None
    """f in the true model; None if it failed there."""
    training: Training | None
    run_values: tuple[float, ...]
    """Best f of each run, in the space searched."""
    best_run: int
    history: FloatArray
    """Best f after each generation of the best run."""
    n_evaluations: int
    """Pairs evaluated by the genetic algorithm, all runs."""
    stop_reason: str
    seconds: dict[str, float]
    evidence: Evidence | None = None
    """What an exact search says about how good the pair is."""
    repair: Repair | None = None
    """How the surrogate was repaired."""

    @property
    def gap_percent(self) -> float | None:
        """100 (surrogate - model) / surrogate; None without both."""
        return gap_percent(self.objective_surrogate, self.objective_model)


def train(
    model: UnitModel, n_dimensions: int, settings: PairSettings, callback: Callback | None = None
) -> Training:
    """Sample the model uniformly and fit a surrogate.

    Raises
    ------
    ParameterError
        If there are too few samples for the linear tail.
    ModelError
        If too many of them failed.
    """
    settings.check_training(n_dimensions)
    report = callback or (lambda _: None)
    n = settings.training_samples
    if report(Progress(stage="sampling", done=0, total=n)):
        raise Cancelled
    start = time.perf_counter()
    points = uniform(n, n_dimensions, settings.seed)
    values = outputs_of(model, points)
    sampled = time.perf_counter()
    report(Progress(stage="sampling", done=n, total=n))
    good = np.isfinite(values).all(axis=1)
    if np.count_nonzero(good) < n_dimensions + 1:
        raise ModelError(
            f"{np.count_nonzero(~good)} of {n} training samples failed; the surrogate needs "
            f"{n_dimensions + 1} that did not"
        )
    if report(Progress(stage="fit", done=0, total=1)):
        raise Cancelled
    surrogate = Surrogate.fit(points[good], values[good])
    return Training(
        surrogate=surrogate,
        points=points,
        values=values,
        seconds_sampling=sampled - start,
        seconds_fit=time.perf_counter() - sampled,
    )


def outputs_of(model: UnitModel, points: FloatArray, n_values: int | None = None) -> FloatArray:
    """Return the model's outputs, checked to have one row a point (and `n_values` columns)."""
    given = model(points)
    try:
        values = np.asarray(given, dtype=np.float64)
    except (TypeError, ValueError):
        raise ParameterError("`model` returned something other than an array of numbers") from None
    wanted = "m" if n_values is None else str(n_values)
    fits = values.ndim == 2 and len(values) == len(points) and values.shape[1] > 0
    if not fits or n_values not in (None, values.shape[1]):
        raise ParameterError(
            f"`model` returned shape {values.shape} for {len(points)} rows; "
            f"({len(points)}, {wanted}) is allowed"
        )
    return values


def pair_value(y: FloatArray, weights: FloatArray) -> float:
    """Return f of a pair's outputs, shape (2, m); NaN if one of the two has failed."""
    return float((np.abs(y[0] - y[1]) * weights).sum())


def gap_percent(surrogate: float | None, model: float | None) -> float | None:
    """Return 100 (surrogate - model) / surrogate; None without both."""
    if surrogate is None or model is None or surrogate == 0.0:
        return None
    return 100.0 * (1.0 - model / surrogate)


def checked_weights(weights: FloatArray | None, n_values: int) -> FloatArray:
    """Return the outputs' weights checked; ones for None."""
    if weights is None:
        return np.ones(n_values)
    if weights.shape != (n_values,) or not np.isfinite(weights).all():
        raise ParameterError(
            f"`weights` has shape {weights.shape}; ({n_values},) of finite numbers is allowed"
        )
    return weights


def _run_all(
    objective: ModelPair | SurrogatePair,
    n_dimensions: int,
    settings: PairSettings,
    callback: Callback | None,
) -> list[GeneticResult]:
    """Run the genetic algorithm `n_runs` times, fewer if cancelled."""
    per_run = settings.n_generations
    results: list[GeneticResult] = []
    for run in range(settings.n_runs):

        def watch(generation: int, best: float, run: int = run) -> object:
            if callback is None:
                return False
            return callback(
                Progress(
                    stage="search",
                    done=run * per_run + generation,
                    total=settings.n_runs * per_run,
                    best=best if np.isfinite(best) else None,
                    run=run,
                )
            )

        results.append(
            maximize(
                objective,
                np.zeros(2 * n_dimensions),
                np.ones(2 * n_dimensions),
                pop_size=settings.pop_size,
                n_generations=per_run,
                options=settings.options,
                seed=settings.run_seed(run),
                callback=watch,
            )
        )
        if results[-1].stop_reason == "cancelled":
            break
    return results


def search_pair(
    objective: ModelPair | SurrogatePair,
    n_dimensions: int,
    settings: PairSettings,
    callback: Callback | None = None,
) -> Found:
    """Find the best pair for `objective` by the genetic algorithm."""
    results = _run_all(objective, n_dimensions, settings, callback)
    values = [r.value for r in results]
    if isinstance(objective, SurrogatePair):
        values = [objective.exact(r.x) for r in results]
    best_run = int(np.argmax(values))
    return Found(
        u=results[best_run].x.reshape(2, n_dimensions),
        run_values=tuple(values),
        best_run=best_run,
        history=results[best_run].history,
        n_evaluations=sum(r.n_evaluations for r in results),
        stop_reason=results[-1].stop_reason,
    )


def verified(
    model: UnitModel, found: Found, training: Training | None, weights: FloatArray, begun: float
) -> PairOutcome:
    """Return what was found, computed again in the true model.

    `begun` is when the search began, by `time.perf_counter`.
    """
    searched = time.perf_counter()
    y = outputs_of(model, found.u)
    f = pair_value(y, weights)
    return PairOutcome(
        u=found.u,
        y=y,
        y_surrogate=training.surrogate(found.u) if training else None,
        objective_surrogate=found.value if training else None,
        objective_model=f if np.isfinite(f) else None,
        training=training,
        run_values=found.run_values,
        best_run=found.best_run,
        history=found.history,
        n_evaluations=found.n_evaluations,
        stop_reason=found.stop_reason,
        seconds={
            "sampling": training.seconds_sampling if training else 0.0,
            "fit": training.seconds_fit if training else 0.0,
            "search": searched - begun,
            "verify": time.perf_counter() - searched,
        },
        evidence=found.evidence,
    )


def find_pair(
    model: UnitModel,
    n_dimensions: int,
    weights: FloatArray | None,
    settings: PairSettings,
    callback: Callback | None = None,
    threads: int | None = None,
) -> PairOutcome:
    """Find the two points of the unit cube whose outputs differ most.

    Parameters
    ----------
    model : callable
        Maps (n, d) in the unit cube to outputs (n, m); a row of NaN is a failure.
    n_dimensions : int
        d
    weights : ndarray, shape (m,), optional
        Weight of each output's difference; ones for None.
    settings : PairSettings
    callback : callable, optional
        Gets `Progress`; a true result cancels. A cancelled search returns the best pair so far.
    threads : int, optional
        Threads that share a search in the surrogate; all available cores for None.

    Raises
    ------
    Cancelled
        If it was cancelled before the genetic algorithm had begun.
    """
    training = None
    objective: ModelPair | SurrogatePair
    if settings.search_space == "surrogate":
        training = train(model, n_dimensions, settings, callback)
        wanted = checked_weights(weights, training.surrogate.n_values)
        objective = SurrogatePair(training.surrogate, wanted, threads)
    else:
        n_values = outputs_of(model, np.full((1, n_dimensions), 0.5)).shape[1]
        wanted = checked_weights(weights, n_values)
        objective = ModelPair(lambda u: outputs_of(model, u, n_values), wanted)
    begun = time.perf_counter()
    found = search_pair(objective, n_dimensions, settings, callback)
    if callback is not None:
        callback(Progress(stage="verify", done=0, total=2, best=found.value, run=found.best_run))
    return verified(model, found, training, wanted, begun)
