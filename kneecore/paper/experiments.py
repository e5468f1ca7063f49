"""The paper's computations again, and the influence of the parameters, which it leaves open."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import TypeVar

from kneecore.knee.space import Case, ParameterSpace
from kneecore.progress import Callback, Cancelled, Progress
from kneecore.search.result import SearchResult
from kneecore.search.settings import SearchSpace
from kneecore.search.warm_up import warm_up
from kneecore.search.worst_case import worst_case
from kneecore.study.influence import InfluenceResult, influence
from kneecore.study.monte_carlo import MonteCarloResult, monte_carlo

__all__ = ["PAPER_BUDGET", "QUICK_BUDGET", "Budget", "Experiments", "run_experiments"]

CASES: tuple[Case, ...] = ("both", "geometry", "material")
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

    space: ParameterSpace
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


def run_experiments(
    space: ParameterSpace,
    budget: Budget = PAPER_BUDGET,
    *,
    seed: int = 0,
    threads: int | None = None,
    callback: Callback | None = None,
) -> Experiments:
    """Run the paper's computations on a space of knees; its case does not count.

    Parameters
    ----------
    space : ParameterSpace
    budget : Budget
    seed : int
        Of the main searches; repeated ones take the next whole numbers.
    threads : int, optional
        As for `simulate_batch`; changes no number.
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
    spaces = {case: replace(space, case=case) for case in CASES}

    def search(
        stage: str, case: Case, where: SearchSpace, run: int, pop_size: int, n_generations: int
    ) -> SearchResult:
        return steps.run(
            stage,
            lambda report: worst_case(
                spaces[case],
                search_space=where,
                pop_size=pop_size,
                n_generations=n_generations,
                seed=seed + run,
                threads=threads,
                callback=report,
            ),
        )

    def main_search(case: Case, run: int) -> SearchResult:
        stage = "searching the three cases" if run == 0 else "searching again with other seeds"
        return search(stage, case, "surrogate", run, budget.pop_size, budget.n_generations)

    def validation(where: SearchSpace, run: int) -> SearchResult:
        size = budget.validation_size
        place = "the true model" if where == "model" else "the surrogate"
        return search(f"searching {place} for comparison", "both", where, run, size, size)

    if steps.tell("compile"):
        raise Cancelled
    # Nothing is compiled while the steps are timed.
    warm_up("surrogate")
    warm_up("model")
    cases: dict[str, SearchResult] = {case: main_search(case, 0) for case in CASES}
    again = tuple(main_search("both", run) for run in range(1, budget.n_repeats))
    return Experiments(
        space=spaces["both"],
        budget=budget,
        seed=seed,
        cases=cases,
        repeats=(cases["both"], *again),
        surrogate_runs=tuple(validation("surrogate", k) for k in range(budget.n_validation)),
        model_runs=tuple(validation("model", k) for k in range(budget.n_validation)),
        sampling=steps.run(
            "sampling",
            lambda report: monte_carlo(
                spaces["both"],
                n_samples=budget.n_samples,
                seed=seed,
                threads=threads,
                callback=report,
            ),
        ),
        influence=steps.run(
            "finding the parameters that decide",
            lambda report: influence(
                spaces["both"],
                n_base=budget.n_base,
                seed=seed,
                threads=threads,
                callback=report,
            ),
        ),
    )
