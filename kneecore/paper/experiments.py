"""The paper's computations again, and the influence of the parameters, which it leaves open."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from kneecore.knee.model import Knee
from kneecore.knee.space import Case
from kneecore.knee.trajectory import Trajectory
from kneecore.numerics.sampling import uniform
from kneecore.paper.turned_round import turned_round_percent
from kneecore.progress import Callback, Cancelled, Progress
from kneecore.search.result import SearchResult
from kneecore.search.settings import PAPER_SAMPLES, SearchSettings, SearchSpace
from kneecore.search.warm_up import warm_up
from kneecore.search.worst_case import worst_case
from kneecore.study.influence import InfluenceResult, influence
from kneecore.study.monte_carlo import MonteCarloResult, monte_carlo
from kneecore.study.settings import (
    InfluenceSettings,
    SamplingSettings,
    SurrogateQualitySettings,
)
from kneecore.study.surrogate_quality import surrogate_quality

__all__ = ["PAPER_BUDGET", "QUICK_BUDGET", "Budget", "Experiments", "run_experiments"]

CASES: tuple[Case, ...] = ("both", "geometry", "material")
SPACES: tuple[SearchSpace, ...] = ("surrogate", "model")
EXACT_CASES: tuple[Case, ...] = ("both", "geometry")
_T = TypeVar("_T", SearchResult, MonteCarloResult, InfluenceResult, NDArray[np.float64])


@dataclass(frozen=True, kw_only=True)
class Budget:
    """How much is computed."""

    pop_size: int
    """Pairs in a generation of the main search."""
    n_generations: int
    n_repeats: int
    """Main searches of the cases `both` and `geometry`, each with its own training knees; the paper
    has one of each."""
    validation_size: int
    """Pairs in a generation, and generations, of the searches that compare the two spaces."""
    n_validation: int
    """Searches in each of the two spaces."""
    n_samples: int
    """Monte-Carlo samples."""
    n_base: int
    """Base rows of the Sobol' indices."""
    n_drawn: int
    """Knees drawn to see what single knees do at both ends of their motion."""


PAPER_BUDGET = Budget(
    pop_size=200,
    n_generations=800,
    n_repeats=10,
    validation_size=100,
    n_validation=4,
    n_samples=10_000,
    n_base=1024,
    n_drawn=2000,
)
"""The paper's, and ten seeds of the main search in the place of one."""
QUICK_BUDGET = Budget(
    pop_size=60,
    n_generations=60,
    n_repeats=3,
    validation_size=20,
    n_validation=2,
    n_samples=1000,
    n_base=64,
    n_drawn=500,
)


@dataclass(frozen=True, kw_only=True, eq=False)
class Experiments:
    """Everything that the claims are judged by."""

    knee: Knee
    """The knees of the case `both`."""
    budget: Budget
    seed: int
    cases: Mapping[str, SearchResult]
    """The main search in the surrogate for `both`, `geometry` and `material`."""
    repeats: tuple[SearchResult, ...]
    """The main search of the case `both` with this seed and the next; the first is in `cases`."""
    geometry_repeats: tuple[SearchResult, ...]
    """The same for the case `geometry`."""
    exact: Mapping[str, SearchResult]
    """The exact search in the true model for `both` and `geometry`: no surrogate's chance in it."""
    surrogate_runs: tuple[SearchResult, ...]
    """Shorter searches in the surrogate, seed by seed."""
    model_runs: tuple[SearchResult, ...]
    """The same in the true model."""
    larger_runs: tuple[SearchResult, ...]
    """Those in the surrogate with twice the training knees."""
    rank_f: NDArray[np.float64]
    """Spearman's rank correlation of the surrogate's f and the true f over new pairs of knees, for
    the surrogate of each of `repeats`."""
    turned_percent: NDArray[np.float64]
    """Change of f for each of `pairs`, model and ligament when the stiffness is turned round, shape
    (n, 2, 4)."""
    drawn: NDArray[np.float64]
    """Angles of knees drawn uniformly, by the true model, shape (n, 12), deg; NaN where one
    failed."""
    motion: Trajectory
    """The baseline in time."""
    sampling: MonteCarloResult
    """Samples of the true model, case `both`."""
    influence: InfluenceResult
    """Sobol' indices of the true model, case `both`."""

    @property
    def main(self) -> SearchResult:
        """The main search with all parameters free."""
        return self.cases["both"]

    @property
    def pairs(self) -> tuple[SearchResult, ...]:
        """The worst cases with all parameters free: the exact optimum, then seed by seed."""
        return (self.exact["both"], *self.repeats)

    @property
    def geometry_pairs(self) -> tuple[SearchResult, ...]:
        """The same with the geometry alone."""
        return (self.exact["geometry"], *self.geometry_repeats)

    @property
    def searches(self) -> tuple[SearchResult, ...]:
        """All searches, each once."""
        return (
            *self.repeats,
            *self.geometry_repeats,
            self.cases["material"],
            *self.exact.values(),
            *self.surrogate_runs,
            *self.model_runs,
            *self.larger_runs,
        )


class _Steps:
    """Counts steps for a callback, and passes its wish to stop on."""

    def __init__(self, callback: Callback | None, total: int) -> None:
        self._callback = callback
        self._total = total
        self._done = 0

    def tell(self, stage: str, best: float | None = None) -> bool:
        report = Progress(stage=stage, done=self._done, total=self._total, best=best)
        return bool(self._callback is not None and self._callback(report))

    def run(self, stage: str, work: Callable[[Callback], _T]) -> _T:
        """Do one step; a cancelled one is of no use here."""
        if self.tell(stage):
            raise Cancelled
        result = work(lambda report: self.tell(stage, report.best))
        if getattr(result, "stop_reason", "") == "cancelled":
            raise Cancelled
        self._done += 1
        return result


class _Searches:
    """The searches of the paper, one step each."""

    def __init__(self, knee: Knee, budget: Budget, seed: int, steps: _Steps) -> None:
        self._knees = {case: knee.with_space(replace(knee.space, case=case)) for case in CASES}
        self._budget = budget
        self._seed = seed
        self._steps = steps

    def main(self, case: Case, run: int) -> SearchResult:
        stage = "searching the three cases" if run == 0 else "searching again with other seeds"
        settings = SearchSettings(
            search_space="surrogate",
            pop_size=self._budget.pop_size,
            n_generations=self._budget.n_generations,
            seed=self._seed + run,
        )
        return self._search(stage, case, settings)

    def validation(self, where: SearchSpace, run: int, *, times_samples: int = 1) -> SearchResult:
        place = "the true model" if where == "model" else "the surrogate"
        settings = SearchSettings(
            search_space=where,
            pop_size=self._budget.validation_size,
            n_generations=self._budget.validation_size,
            training_samples=times_samples * PAPER_SAMPLES,
            seed=self._seed + run,
        )
        return self._search(f"searching {place} for comparison", "both", settings)

    def exact(self, case: Case) -> SearchResult:
        settings = SearchSettings(method="exact", search_space="model", seed=self._seed)
        return self._search("searching with exact gradients", case, settings)

    def _search(self, stage: str, case: Case, settings: SearchSettings) -> SearchResult:
        return self._steps.run(
            stage, lambda report: worst_case(self._knees[case], settings, callback=report)
        )


def _warm_up(knee: Knee) -> None:
    """Compile all that is needed, so that nothing is compiled while the steps are timed."""
    for where in SPACES:
        warm_up(knee, SearchSettings(search_space=where))
    warm_up(knee, SearchSettings(method="exact", search_space="model"))


def _rank_f(knee: Knee, runs: tuple[SearchResult, ...], report: Callback) -> NDArray[np.float64]:
    """Return how well each run's surrogate ranks pairs that are new to it."""
    ranks = []
    for run in runs:
        settings = SurrogateQualitySettings(
            training_samples=run.settings.n_training, seed=run.settings.seed
        )
        ranks.append(surrogate_quality(knee, settings, callback=report).rank_f)
    return np.array(ranks)


def run_experiments(
    knee: Knee,
    budget: Budget = PAPER_BUDGET,
    *,
    seed: int = 0,
    callback: Callback | None = None,
) -> Experiments:
    """Run the paper's computations on a space of knees; its case does not count.

    Parameters
    ----------
    knee : Knee
    budget : Budget
    seed : int
        Of the main searches; repeated ones take the next whole numbers.
    callback : callable, optional
        Gets `Progress`; a true result cancels.

    Raises
    ------
    Cancelled
        If the callback cancelled.
    ParameterError, ModelError
        As for `worst_case` and `monte_carlo`.
    """
    n_searches = len(CASES) + len(EXACT_CASES) + 2 * (budget.n_repeats - 1)
    steps = _Steps(callback, n_searches + 3 * budget.n_validation + 5)
    knee = knee.with_space(replace(knee.space, case="both"))
    if steps.tell("compile"):
        raise Cancelled
    _warm_up(knee)
    search = _Searches(knee, budget, seed, steps)
    cases: dict[str, SearchResult] = {case: search.main(case, 0) for case in CASES}
    repeats, geometry = (
        (cases[case], *(search.main(case, run) for run in range(1, budget.n_repeats)))
        for case in EXACT_CASES
    )
    exact: dict[str, SearchResult] = {case: search.exact(case) for case in EXACT_CASES}
    validations = range(budget.n_validation)
    return Experiments(
        knee=knee,
        budget=budget,
        seed=seed,
        cases=cases,
        repeats=repeats,
        geometry_repeats=geometry,
        exact=exact,
        surrogate_runs=tuple(search.validation("surrogate", run) for run in validations),
        model_runs=tuple(search.validation("model", run) for run in validations),
        larger_runs=tuple(
            search.validation("surrogate", run, times_samples=2) for run in validations
        ),
        **_studies(knee, budget, seed, steps, (exact["both"], *repeats)),
    )


def _studies(
    knee: Knee, budget: Budget, seed: int, steps: _Steps, pairs: tuple[SearchResult, ...]
) -> dict[str, Any]:
    """Return all that is no search, by the names that `Experiments` gives it."""
    points = knee.from_free_unit(uniform(budget.n_drawn, knee.n_free, seed))
    return {
        "rank_f": steps.run("ranking new knees", lambda report: _rank_f(knee, pairs[1:], report)),
        "turned_percent": steps.run(
            "turning stiffnesses round", lambda _: turned_round_percent(knee, pairs)
        ),
        "drawn": steps.run("drawing single knees", lambda _: knee.examine(points).y),
        "motion": knee.trajectory(knee.space.baseline),
        "sampling": steps.run(
            "sampling",
            lambda report: monte_carlo(
                knee, SamplingSettings(n_samples=budget.n_samples, seed=seed), callback=report
            ),
        ),
        "influence": steps.run(
            "finding the parameters that decide",
            lambda report: influence(
                knee, InfluenceSettings(n_base=budget.n_base, seed=seed), callback=report
            ),
        ),
    }
