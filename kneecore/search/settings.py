"""How to search for the two most different models."""

from dataclasses import dataclass, field
from numbers import Real
from typing import Literal, get_args

import numpy as np

from kneecore.errors import ParameterError
from kneecore.numerics.genetic_options import GeneticOptions
from kneecore.numerics.sampling import check_count, check_seed

__all__ = ["Method", "PairSettings", "SearchSpace", "default_space"]

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
