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
GENETIC = ("pop_size", "n_generations", "n_runs", "options")
"""Options of the genetic algorithm."""
MAX_COUNTING = 12
"""Outputs that count up to which `bound` looks at every pattern of their signs."""
PAPER_SAMPLES = 50
"""Training samples of the paper."""
_PAIR = 2


def enough_samples(n_free: int) -> int:
    """Return the paper's 50 training samples, or as many as this many free inputs need."""
    return max(PAPER_SAMPLES, n_free + 2)


@dataclass(frozen=True, kw_only=True)
class SearchSettings:
    """How to search for the worst case. Defaults are the paper's main run for a knee.

    Raises
    ------
    ParameterError
        If a value is not allowed, or belongs to another method.
    """

    method: Method | None = option(None, metavar="{ga,exact}")
    """The paper's genetic algorithm, or climbs with exact gradients (no pop-size, generations, runs
    or ga options). Unset: ga for knees and where one of its options is given, else exact."""
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
    repair: bool | None = option(None)
    """Repair the surrogate where it is trusted most: compute its optimum in the true model, add it
    to the samples, fit again, search again; then look where it is unsure. Unset: not for knees, nor
    with ga or gradients; else repaired, with a verdict on the pair."""
    repair_gap_percent: float = option(1.0, place=("repair", "goal_percent"))
    """Gap between surrogate and model at the optimum below which the surrogate counts as repaired,
    per cent."""
    repair_models: int | None = option(None, place=("repair", "max_models"), metavar="INT")
    """Model runs that a repair may add. Those that the gap does not need look for a pair that is
    better in the true model. Unset: 40 for knees, else 99 or what `max_runs` leaves."""
    repair_batch: int = option(4, place=("repair", "batch"))
    """Runs that a repair asks for at once (models of one's own; a knee is repaired one by one)."""
    max_runs: int | None = option(None, place=("search", "max_runs"), metavar="INT")
    """Runs of the model that a search in a surrogate may take, all in all. Unset: what its other
    options come to."""
    training_samples: int | None = option(None, place=("search", "training_samples"), metavar="INT")
    """Model runs that the surrogate is fitted to; at least one more than free parameters. Unset:
    50; for models of one's own as many as they need, or a third of `max_runs`."""
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
        left_open = ("training_samples", "repair_models", "max_runs")
        for name in ("pop_size", "n_generations", "n_runs", "repair_batch", *left_open):
            if name not in left_open or getattr(self, name) is not None:
                object.__setattr__(self, name, check_count(name, getattr(self, name)))
        object.__setattr__(self, "seed", check_seed(self.seed))
        object.__setattr__(self, "weights", _checked_weights(self.weights))
        if not isinstance(self.options, GeneticOptions):
            raise ParameterError(f"`options` is {shown(self.options)}; GeneticOptions are allowed")
        text("objective", self.objective, 200)
        if self.repair is not None:
            object.__setattr__(self, "repair", flag("repair", self.repair))
        for name in ("thorough", "bound"):
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
                GENETIC,
                "it is the genetic algorithm's, and the method 'exact' has none of it",
            )
        if self.bound and (self.method != "exact" or self.repair):
            other = "`repair`" if self.repair else f"the method {self.method or 'ga'!r}"
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
        if self.repair is False:
            self._refuse_repairs()
        object.__setattr__(self, "repair_gap_percent", gap)
        if self.repair_models is not None and self.repair_models < 2:
            raise ParameterError(
                f"`repair_models` is {self.repair_models}; at least 2 are needed, for the "
                "surrogate's optimum is a pair"
            )
        if self.repair and self.search_space == "model":
            raise ParameterError(
                "`search_space` is 'model'; with `repair` it is the surrogate that is searched"
            )

    def _refuse_repairs(self) -> None:
        names = ("repair_gap_percent", "repair_models", "repair_batch")
        self._refuse_others_than_usual(names, "it needs `repair`")

    @property
    def n_training(self) -> int:
        """Runs that the surrogate is fitted to, once that is decided (`of`)."""
        assert self.training_samples is not None
        return self.training_samples

    @property
    def n_repair(self) -> int:
        """Runs that a repair may add, once that is decided (`of`); 0 without one."""
        return self.repair_models or 0

    def usual(self, *, in_corners: bool, gradient: bool, n_free: int) -> dict[str, Any]:
        """Return what each option that may be left open is then: the one place that decides.

        Parameters
        ----------
        in_corners : bool
            Whether the model's worst pairs are known to lie in corners, as the knee's do.
        gradient : bool
            Whether the model, or one near it, has exact gradients.
        n_free : int
            Inputs that vary.
        """
        genetic = in_corners or self._genetic
        method = self.method or ("ga" if genetic else "exact")
        own = not in_corners and not gradient and method == "exact"
        unasked = own and self.search_space != "model" and not self.bound
        repair = unasked if self.repair is None else self.repair
        in_model = method == "exact" and not repair and gradient
        samples = PAPER_SAMPLES if in_corners else enough_samples(n_free)
        if self.max_runs is not None:
            if repair:
                samples = min(samples, max(n_free + 2, self.max_runs // 3))
            else:
                samples = min(samples, max(self.max_runs - _PAIR - 1, 1))
        added = 40 if in_corners else 99
        if self.max_runs is not None:
            added = max(self.max_runs - (self.training_samples or samples) - 1, 2)
        return {
            "method": method,
            "repair": repair,
            "search_space": "model" if in_model else "surrogate",
            "training_samples": samples,
            "repair_models": added,
        }

    @property
    def _genetic(self) -> bool:
        """Whether the genetic algorithm is asked for by one of its options."""
        usual = {o.name: o.default for o in options_of(type(self))}
        return any(getattr(self, name) != usual[name] for name in GENETIC)

    def _decided(self, model: "Model") -> Self:
        usual = self.usual(
            in_corners=model.in_corners,
            gradient=model.has_gradient or model.proxy is not None,
            n_free=model.n_free,
        )
        open_ = {name: value for name, value in usual.items() if getattr(self, name) is None}
        if not (self.repair if self.repair is not None else usual["repair"]):
            self._refuse_repairs()
            open_.pop("repair_models", None)
        return replace(self, **open_)

    def of(self, model: "Model") -> Self:
        """Return the settings of a search of `model`, with nothing left open, and checked.

        Raises
        ------
        ParameterError
            If the model cannot be searched like that.
        """
        gradient = model.has_gradient or model.proxy is not None
        if self.method == "exact" and self.search_space == "model" and not gradient:
            raise ParameterError(
                "`search_space` is 'model'; the method 'exact' has no gradients of this model, "
                "and searches its surrogate"
            )
        settings = self._decided(model)
        weights = model.weights(self.objective, self.weights)
        if self.bound:
            assert settings.search_space is not None
            self._check_bound(model, settings.search_space, int((weights != 0.0).sum()))
        settings._check_runs(model.n_free)
        settings.check_training(model.n_free)
        check_budget(search_budget(settings, model))
        return settings

    def _check_runs(self, n_free: int) -> None:
        """Raise if more runs are needed than are allowed."""
        if self.max_runs is None:
            return
        if self.search_space == "model":
            raise ParameterError(
                f"`max_runs` is {self.max_runs}; it is for searches in a surrogate, and this one "
                "is in the model"
            )
        samples, added = max(self.n_training, n_free + 1), self.n_repair or _PAIR
        if samples + added + 1 > self.max_runs:
            raise ParameterError(
                f"`max_runs` is {self.max_runs}; at least {samples + added + 1} are needed: "
                f"{samples} to fit a surrogate of {n_free} free parameters, {added} for the pair, "
                "and the nominal one"
            )

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
        samples = self.training_samples
        if self.search_space != "model" and samples is not None and samples < n_dimensions + 1:
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
