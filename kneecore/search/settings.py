"""How to search for the two most different models: the one list of its options."""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Literal, Self

from kneecore._arguments import flag, number, shown, text
from kneecore.budget import check_budget
from kneecore.errors import ParameterError
from kneecore.numerics.genetic_options import GeneticOptions
from kneecore.numerics.sampling_options import check_count, check_seed
from kneecore.options import check_choices, option, options_of
from kneecore.search.budget import search_budget

if TYPE_CHECKING:  # a command line shows its options without it
    from kneecore.model import Model

__all__ = ["MAX_COUNTING", "Method", "SearchSettings", "SearchSpace", "enough_samples"]

SearchSpace = Literal["surrogate", "model"]
Method = Literal["ga", "exact"]
MAX_COUNTING = 12
"""Outputs that count up to which `bound` looks at every pattern of their signs."""


def enough_samples(n_free: int) -> int:
    """Return the paper's 50 training samples, or as many as this many free inputs need."""
    return max(50, n_free + 2)


@dataclass(frozen=True, kw_only=True)
class SearchSettings:
    """How to search for the worst case. Defaults are the paper's main run.

    Raises
    ------
    ParameterError
        If a value is not allowed, or belongs to another method.
    """

    method: Method = option("ga")
    """The paper's genetic algorithm, or climbs with exact gradients (no pop-size, generations, runs
    or ga options)."""
    search_space: SearchSpace | None = option(None, key="space", metavar="{surrogate,model}")
    """Where to search: in the surrogate, or in the true model (slower with the genetic algorithm,
    exact values). Unset: the surrogate with ga or repair, the model with exact where it has
    gradients."""
    thorough: bool = option(False)
    """Search longer where bounds are so wide that knees lose their equilibrium (exact search in
    the true model)."""
    bound: bool = option(False)
    """Tell after the search how many inputs' slopes keep their sign within the bounds, and what f
    is at most if slopes stay near their sampled range: no proof (exact search in the true model;
    some 20 seconds more for the knee)."""
    repair: bool = option(False)
    """Repair the surrogate where it is trusted most: compute its optimum in the true model, add it
    to the samples, fit again, search again; then try one input at a time at its other bound."""
    repair_gap_percent: float = option(1.0, place=("repair", "goal_percent"))
    """Gap between surrogate and model at the optimum below which the surrogate counts as repaired,
    per cent."""
    repair_models: int = option(40, place=("repair", "max_models"))
    """Model runs that a repair may add. Those that the gap does not need look for a pair that is
    better in the true model."""
    repair_batch: int = option(4, place=("repair", "batch"))
    """Runs that a repair asks for at once (models of one's own; a knee is repaired one by one)."""
    training_samples: int = option(50, place=("search", "training_samples"))
    """Model runs that the surrogate is fitted to; at least one more than free parameters."""
    pop_size: int = option(200, place=("search", "pop_size"))
    """Pairs in a generation."""
    n_generations: int = option(800, key="generations", place=("search", "generations"))
    """How many generations are bred."""
    n_runs: int = option(1, key="runs", place=("search", "runs"))
    """Independent runs of the search; the best is kept and the spread shown."""
    objective: str = option("all")
    """Which of the model's outputs count: all, or a group or an output by its name (the knee's
    loads: extension or flexion)."""
    weights: tuple[float, ...] | None = option(None, metavar="W [W ...]")
    """Weight of each number that the model returns in the difference of two models; unset: 1
    each."""
    seed: int = option(0)
    """The same seed gives the same result, on any number of threads."""
    options: GeneticOptions = option(
        default_factory=GeneticOptions, key="ga", place=("search", "options")
    )
    """Constants of the genetic algorithm."""

    def __post_init__(self) -> None:
        check_choices(self)
        counts = ("training_samples", "pop_size", "n_generations", "n_runs")
        for name in (*counts, "repair_models", "repair_batch"):
            object.__setattr__(self, name, check_count(name, getattr(self, name)))
        object.__setattr__(self, "seed", check_seed(self.seed))
        object.__setattr__(self, "weights", _checked_weights(self.weights))
        if not isinstance(self.options, GeneticOptions):
            raise ParameterError(f"`options` is {shown(self.options)}; GeneticOptions are allowed")
        text("objective", self.objective, 200)
        for name in ("repair", "thorough", "bound"):
            object.__setattr__(self, name, flag(name, getattr(self, name)))
        self.options.split(self.pop_size)
        self._check_method()
        self._check_repair()

    def _refuse_others_than_usual(self, names: tuple[str, ...], why: str) -> None:
        usual = {o.name: o.default for o in options_of(type(self))}
        for name in names:
            if getattr(self, name) != usual[name]:
                raise ParameterError(f"`{name}` is {shown(getattr(self, name))}; {why}")

    def _check_method(self) -> None:
        """Raise if there are options that are another method's."""
        if self.method == "exact":
            self._refuse_others_than_usual(
                ("pop_size", "n_generations", "n_runs", "options"),
                "it is the genetic algorithm's, and the method 'exact' has none of it",
            )
        if self.bound and (self.method != "exact" or self.repair):
            other = "`repair`" if self.repair else f"the method {self.method!r}"
            raise ParameterError(
                f"`bound` is True; it needs the method 'exact' in the true model, not {other}"
            )

    def _check_repair(self) -> None:
        """Raise if the repair's options are not allowed, or are given without it."""
        gap = number("repair_gap_percent", self.repair_gap_percent)
        if not 0.0 < gap < 100.0:
            raise ParameterError(
                f"`repair_gap_percent` is {gap:g}; a number above 0 and below 100 is allowed"
            )
        if not self.repair:
            self._refuse_others_than_usual(
                ("repair_gap_percent", "repair_models", "repair_batch"), "it needs `repair`"
            )
        object.__setattr__(self, "repair_gap_percent", gap)
        if not self.repair:
            return
        if self.repair_models < 2:
            raise ParameterError(
                f"`repair_models` is {self.repair_models}; at least 2 are needed, for the "
                "surrogate's optimum is a pair"
            )
        if self.search_space == "model":
            raise ParameterError(
                "`search_space` is 'model'; with `repair` it is the surrogate that is searched"
            )

    def default_space(self, *, gradient: bool) -> SearchSpace:
        """Return where is searched if nothing else is asked for.

        `gradient` tells whether the model, or one near it, has exact gradients.
        """
        return "model" if self.method == "exact" and not self.repair and gradient else "surrogate"

    def of(self, model: "Model") -> Self:
        """Return the settings of a search of `model`, with nothing left open, and checked.

        Raises
        ------
        ParameterError
            If the model cannot be searched like that.
        """
        gradient = model.has_gradient or model.proxy is not None
        space = self.search_space or self.default_space(gradient=gradient)
        if self.method == "exact" and space == "model" and not gradient:
            raise ParameterError(
                "`search_space` is 'model'; the method 'exact' has no gradients of this model, "
                "and searches its surrogate"
            )
        weights = model.weights(self.objective, self.weights)
        if self.bound:
            self._check_bound(model, space, int((weights != 0.0).sum()))
        settings = replace(self, search_space=space)
        settings.check_training(model.n_free)
        check_budget(search_budget(settings, model))
        return settings

    def _check_bound(self, model: "Model", space: SearchSpace, n_counting: int) -> None:
        """Raise if the model has no slopes to bound f by, or too many outputs."""
        if space != "model":
            why = "the search is in the surrogate"
            if not model.has_gradient and model.proxy is None:
                why = "this model has none, and its surrogate is searched"
            raise ParameterError(
                f"`bound` is True; it needs gradients of the true model, and {why}"
            )
        if n_counting > MAX_COUNTING:
            raise ParameterError(
                f"`bound` is True and {n_counting} numbers that the model returns count; all "
                f"patterns of their signs are looked at, and at most {MAX_COUNTING} are allowed"
            )

    def check_training(self, n_dimensions: int) -> None:
        """Raise if the surrogate's linear tail needs more samples than there are."""
        if self.search_space != "model" and self.training_samples < n_dimensions + 1:
            raise ParameterError(
                f"`training_samples` is {self.training_samples}; with {n_dimensions} free "
                f"parameters at least {n_dimensions + 1} are needed"
            )


def _checked_weights(given: Any) -> tuple[float, ...] | None:
    if given is None:
        return None
    try:
        weights = [] if isinstance(given, str | bytes | dict) else list(given)
        weights = [number("weights", weight, least=0.0) for weight in weights]
    except Exception:  # whatever a stranger's __iter__ raises
        weights = []
    if not any(weights):
        raise ParameterError(
            f"`weights` is {shown(given)}; a row of finite numbers of at least 0, one above 0, is "
            "allowed"
        )
    return tuple(weights)
