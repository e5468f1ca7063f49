"""What must agree in each study's result."""

from typing import Any

import numpy as np

from kneecore.errors import FileFormatError
from kneecore.files.consistent import check_equal, check_holds
from kneecore.files.search_relations import check_response, check_search, check_within
from kneecore.numerics.sampling_options import check_count
from kneecore.paper.result import PaperReport
from kneecore.paper.verdict import judge
from kneecore.study.bound_sweep import BoundSweep
from kneecore.study.comparison import Comparison
from kneecore.study.influence import InfluenceResult
from kneecore.study.landscape import Landscape
from kneecore.study.monte_carlo import MonteCarloResult, Spread
from kneecore.study.needed_accuracy import NeededAccuracy
from kneecore.study.surrogate_quality import SurrogateQuality
from kneecore.study.training_sweep import TrainingSweep

__all__ = ["check_relations"]


def _between(where: str, values: Any, low: float, high: float) -> None:
    """Check numbers; those that are not known pass."""
    array = np.asarray(values, dtype=np.float64)
    inside = ~np.isfinite(array) | ((array >= low - 1e-9) & (array <= high + 1e-9))
    check_holds(where, inside, f"{low:g} to {high:g} is allowed")


def _not_below(where: str, values: Any, least: Any, what: str) -> None:
    with np.errstate(invalid="ignore"):
        check_holds(where, ~(np.asarray(values) < np.asarray(least) - 1e-9), what)


def _spread(where: str, spread: Spread) -> None:
    _between(f"{where}.sd", spread.sd, 0.0, np.inf)
    check_equal(f"{where}.sigma.lower", spread.sigma_lower, spread.mean - 3.0 * spread.sd)
    check_equal(f"{where}.sigma.upper", spread.sigma_upper, spread.mean + 3.0 * spread.sd)
    lower, upper = spread.percentile_lower, spread.percentile_upper
    _not_below(f"{where}.percentile", upper, lower, "lower is at most upper")


def _monte_carlo(study: MonteCarloResult) -> None:
    _spread("mean", study.y)
    for name, spread in study.observed.items():
        _spread(name, spread)
    check_count("n_samples", study.n_samples)
    for name, count in study.counts.items():
        check_holds(f"n_{name}", count <= study.n_samples, "at most `n_samples`")
    if study.below is not None:
        _between("share_of_samples_below", study.below, 0.0, 1.0)


def _influence(found: InfluenceResult) -> None:
    used = found.indices
    check_equal("n_base", used.n_base, found.settings.n_base)
    check_equal("n_evaluations", used.n_evaluations, used.n_base * (len(found.names) + 2))
    check_holds("n_failed_rows", used.n_failed_rows <= used.n_base, "at most `n_base`")
    for name in ("first_order", "total_order"):
        both = getattr(used, f"{name}_interval")
        if both is not None:
            _not_below(f"interval_95.{name}", both[1], both[0], "lower is at most upper")
    for group, sums in found.groups.items():
        mine = [j for j, n in enumerate(found.names) if found.model.groups.get(n) == group]
        if mine:  # a model that is no knee has lost its groups
            check_equal(f"groups_first_order.{group}", sums, used.first_order[:, mine].sum(axis=1))


def _landscape(found: Landscape) -> None:
    check_within("x", found.model, found.x[None])
    for name, axis in zip(found.names, found.axes, strict=True):
        check_holds("axes", np.diff(axis) > 0.0, "they rise")
        points = np.repeat(found.x[None], len(axis), axis=0)
        points[:, found.model.names.index(name)] = axis
        check_within("axes", found.model, points)


def _bound_sweep(sweep: BoundSweep) -> None:
    _between("objective_model", sweep.objective, 0.0, np.inf)
    _not_below("extremes", sweep.extremes[:, 1], sweep.extremes[:, 0], "least is at most largest")


def _needed_accuracy(need: NeededAccuracy) -> None:
    largest = need.settings.largest
    if need.size is not None and largest is not None:
        _between("size", need.size, 0.0, largest)
    if need.beyond_value is not None and need.settings.within is not None:
        _not_below("beyond_value", need.beyond_value, need.settings.within, "above what is allowed")


def _training_sweep(sweep: TrainingSweep) -> None:
    with np.errstate(divide="ignore", invalid="ignore"):
        gap = 100.0 * (1.0 - sweep.objective_model / sweep.objective_surrogate)
    check_equal("gap_percent", sweep.gap_percent, gap)
    _between("rank_correlation_pairs", sweep.rank_f, -1.0, 1.0)
    _between("rank_correlation_worst", sweep.rank_outputs, -1.0, 1.0)
    _between("rms_error", sweep.rms_error, 0.0, np.inf)
    wanted = np.array(sweep.settings.sizes)[:, None]
    check_holds("n_failed", sweep.n_failed <= wanted, "at most `training_samples`")


def _surrogate_quality(quality: SurrogateQuality) -> None:
    judged = quality.judgement
    _between("loo_rms", quality.loo_rms, 0.0, np.inf)
    _between("rms_error", judged.rms, 0.0, np.inf)
    _between("rank_correlation", judged.rank, -1.0, 1.0)
    _between("rank_correlation_pairs", judged.rank_f, -1.0, 1.0)
    _between("variance_explained", judged.explained, -np.inf, 1.0)
    check_equal("pairs", len(judged.f_surrogate), quality.n_test // 2)
    check_holds("n_test", quality.n_test <= quality.settings.n_test, "at most `test_points`")
    weights = quality.model.weights()
    follows = np.sqrt(np.mean((judged.rms * weights) ** 2))
    check_equal("rms_error_all", judged.rms_all, follows)


def _comparison(found: Comparison) -> None:
    _between("excess", found.excess, 0.0, np.inf)
    if found.below is not None:
        _between("share_of_samples_below", found.below, 0.0, 1.0)


def _paper(report: PaperReport) -> None:
    for verdict in report.verdicts:
        claim = verdict.claim
        if claim.rule != "none" and claim.limit is None:
            raise FileFormatError(f"`limit` of the claim {claim.id!r} is missing; its rule has one")
        outcome = judge(verdict.claim, verdict.values).outcome
        if verdict.outcome != outcome:
            raise FileFormatError(
                f"`outcome` of the claim {verdict.claim.id!r} is {verdict.outcome!r}; {outcome!r} "
                "follows from `ours`"
            )


_CHECKS: dict[str, Any] = {
    "SearchResult": check_search,
    "Response": check_response,
    "MonteCarloResult": _monte_carlo,
    "InfluenceResult": _influence,
    "Landscape": _landscape,
    "BoundSweep": _bound_sweep,
    "NeededAccuracy": _needed_accuracy,
    "TrainingSweep": _training_sweep,
    "SurrogateQuality": _surrogate_quality,
    "Comparison": _comparison,
    "PaperReport": _paper,
}


def check_relations(result: Any) -> None:
    """Raise a `FileFormatError` if a result, or one of several in a file, contradicts itself."""
    check = _CHECKS.get(type(result).__name__)
    if check is not None:
        check(result)
        return
    for part in vars(result).values():  # several results in one file
        if type(part).__name__ in _CHECKS:
            check_relations(part)
