"""What the paper asks of the machine when it is redone."""

from typing import Any

from kneecore.budget import Budget
from kneecore.knee.model import Knee
from kneecore.paper.experiments import CASES, PAPER_BUDGET, QUICK_BUDGET
from kneecore.search.budget import search_budget
from kneecore.search.settings import SearchSettings
from kneecore.study.budget import study_budget
from kneecore.study.settings import InfluenceSettings, SamplingSettings

__all__ = ["paper_budgets"]


def paper_budgets(knee: Knee, *, quick: bool, seed: int) -> list[Budget | None]:
    """Return what each search and study asks for.

    Raises
    ------
    ParameterError
        If the seed is none.
    """
    size = QUICK_BUDGET if quick else PAPER_BUDGET

    def search(**asked: Any) -> Budget:
        return search_budget(SearchSettings(seed=seed, **asked).of(knee), knee)

    main = search(pop_size=size.pop_size, n_generations=size.n_generations)
    shorter = {"pop_size": size.validation_size, "n_generations": size.validation_size}
    again = [search(search_space=space, **shorter) for space in ("surrogate", "model")]
    studies = (
        SamplingSettings(n_samples=size.n_samples, seed=seed),
        InfluenceSettings(n_base=size.n_base, seed=seed),
    )
    return [
        *(len(CASES) + 2 * (size.n_repeats - 1)) * [main],
        *size.n_validation * again,
        *(study_budget(one, knee) for one in studies),
    ]
