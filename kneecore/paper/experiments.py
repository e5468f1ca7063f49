"""The paper's computations again, and the influence of the parameters, which it leaves open."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import TypeVar

from kneecore.knee.model import Knee
from kneecore.knee.space import Case
from kneecore.progress import Callback, Cancelled, Progress
from kneecore.search.result import SearchResult
from kneecore.search.settings import SearchSettings, SearchSpace
from kneecore.search.warm_up import warm_up
from kneecore.search.worst_case import worst_case
from kneecore.study.influence import InfluenceResult, influence
from kneecore.study.monte_carlo import MonteCarloResult, monte_carlo
from kneecore.study.settings import InfluenceSettings, SamplingSettings

__all__ = ["PAPER_BUDGET", "QUICK_BUDGET", "Budget", "Experiments", "run_experiments"]

CASES: tuple[Case, ...] = ("both", "geometry", "material")
SPACES: tuple[SearchSpace, ...] = ("surrogate", "model")
_T = TypeVar("_T", SearchResult, MonteCarloResult, InfluenceResult)


@dataclass(frozen=True, kw_only=True)
class Budget:
    """How much is computed."""

    pop_size: int
    """Pairs in a generation of the main search."""
    n_generations: int
    n_repeats: int
    """Main searches of the case `both`, each with its own training knees; the paper has one."""
    validation_size: int
    """Pairs in a generation, and generations, of the searches that compare the two spaces."""
    n_validation: int
    """Searches in each of the two spaces."""
    n_samples: int
    """Monte-Carlo samples."""
    n_base: int
    """Base rows of the Sobol' indices."""


PAPER_BUDGET = Budget(
    pop_size=200,
    n_generations=800,
    n_repeats=10,
    validation_size=100,
    n_validation=4,
    n_samples=10_000,
    n_base=1024,
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
    surrogate_runs: tuple[SearchResult, ...]
    """Shorter searches in the surrogate, seed by seed."""
    model_runs: tuple[SearchResult, ...]
    """The same in the true model."""
    sampling: MonteCarloResult
    """Samples of the true model, case `both`."""
    influence: InfluenceResult
    """Sobol' indices of the true model, case `both`."""

    @property
    def main(self) -> SearchResult:
        """The main search with all parameters free."""
        return self.cases["both"]

    @property
    def searches(self) -> tuple[SearchResult, ...]:
        """All searches, each once."""
        others = tuple(run for case, run in self.cases.items() if case != "both")
        return (*self.repeats, *others, *self.surrogate_runs, *self.model_runs)


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
        sizes = self._budget.pop_size, self._budget.n_generations
        return self._search(stage, case, "surrogate", run, *sizes)

    def validation(self, where: SearchSpace, run: int) -> SearchResult:
        place = "the true model" if where == "model" else "the surrogate"
        size = self._budget.validation_size
        return self._search(f"searching {place} for comparison", "both", where, run, size, size)

    def _search(
        self,
        stage: str,
        case: Case,
        where: SearchSpace,
        run: int,
        pop_size: int,
        n_generations: int,
    ) -> SearchResult:
        settings = SearchSettings(
            search_space=where,
            pop_size=pop_size,
            n_generations=n_generations,
            seed=self._seed + run,
        )
        return self._steps.run(
            stage, lambda report: worst_case(self._knees[case], settings, callback=report)
        )


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
    n_steps = len(CASES) + (budget.n_repeats - 1) + 2 * budget.n_validation + 2
    steps = _Steps(callback, n_steps)
    knee = knee.with_space(replace(knee.space, case="both"))
    if steps.tell("compile"):
        raise Cancelled
    # Nothing is compiled while the steps are timed.
    for where in SPACES:
        warm_up(knee, SearchSettings(search_space=where))
    search = _Searches(knee, budget, seed, steps)
    cases: dict[str, SearchResult] = {case: search.main(case, 0) for case in CASES}
    again = tuple(search.main("both", run) for run in range(1, budget.n_repeats))
    shorter = {
        where: tuple(search.validation(where, run) for run in range(budget.n_validation))
        for where in SPACES
    }
    return Experiments(
        knee=knee,
        budget=budget,
        seed=seed,
        cases=cases,
        repeats=(cases["both"], *again),
        surrogate_runs=shorter["surrogate"],
        model_runs=shorter["model"],
        sampling=steps.run(
            "sampling",
            lambda report: monte_carlo(
                knee, SamplingSettings(n_samples=budget.n_samples, seed=seed), callback=report
            ),
        ),
        influence=steps.run(
            "finding the parameters that decide",
            lambda report: influence(
                knee, InfluenceSettings(n_base=budget.n_base, seed=seed), callback=report
            ),
        ),
    )
