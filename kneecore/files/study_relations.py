"""What must agree in each study's result."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from kneecore.errors import FileFormatError
from kneecore.files.bound_study import BoundStudy
from kneecore.files.consistent import check_equal, check_holds
from kneecore.files.knee_relations import check_status
from kneecore.files.model import digits_of
from kneecore.files.search_relations import check_search, check_within
from kneecore.files.study import Study
from kneecore.knee.model import Knee
from kneecore.numerics.sampling import n_drawn
from kneecore.numerics.sampling_options import check_count
from kneecore.numerics.sensitivity import BATCH
from kneecore.paper.finding import Finding
from kneecore.paper.result import PaperReport
from kneecore.paper.verdict import judge
from kneecore.study.accuracy_allocation import AccuracyAllocation, members_of, stated_tolerances
from kneecore.study.bound_sweep import BoundSweep
from kneecore.study.comparison import Comparison
from kneecore.study.influence import InfluenceResult
from kneecore.study.landscape import Landscape
from kneecore.study.monte_carlo import MonteCarloResult, Spread
from kneecore.study.needed_accuracy import NeededAccuracy
from kneecore.study.settings import SamplingSettings
from kneecore.study.surrogate_quality import SurrogateQuality, rank_correlation
from kneecore.study.training_sweep import N_TEST, TrainingSweep

__all__ = ["check_relations"]

_WHOLE = 1e-9
"""By which a share may miss a whole number of samples."""
_RANKED = 1e-3
"""Numbers with ten decimals may have a tie that all their digits have not."""
_EXACT = 1e-9
_OF_BAND = 1e-6
"""A narrow band has lost digits."""


def _between(where: str, values: Any, low: float, high: float) -> None:
    """Check numbers; those that are not known pass."""
    array = np.asarray(values, dtype=np.float64)
    inside = ~np.isfinite(array) | ((array >= low - 1e-9) & (array <= high + 1e-9))
    check_holds(where, inside, f"{low:g} to {high:g} is allowed")


def _not_below(where: str, values: Any, least: Any, what: str) -> None:
    with np.errstate(invalid="ignore"):
        check_holds(where, ~(np.asarray(values) < np.asarray(least) - 1e-9), what)


def _spread(where: str, spread: Spread, digits: int | None) -> None:
    _between(f"{where}.sd", spread.sd, 0.0, np.inf)
    size = np.abs(spread.mean) + 3.0 * np.abs(spread.sd)
    for side, sign in (("lower", -3.0), ("upper", 3.0)):
        said, follows = getattr(spread, f"sigma_{side}"), spread.mean + sign * spread.sd
        check_equal(f"{where}.sigma.{side}", said, follows, digits=digits, size=size)
    lower, upper = spread.percentile_lower, spread.percentile_upper
    _not_below(f"{where}.percentile", upper, lower, "lower is at most upper")


def _monte_carlo(study: MonteCarloResult) -> None:
    digits, drawn = digits_of(study.model), _drawn(study.settings)
    _spread("mean", study.y, digits)
    for name, spread in study.observed.items():
        _spread(name, spread, digits)
    check_count("n_samples", study.n_samples)
    fits = study.n_samples == drawn or (
        study.stop_reason == "cancelled" and study.n_samples < drawn
    )
    check_holds("n_samples", fits, f"{drawn} follows from what was asked for")
    for name, count in study.counts.items():
        check_holds(f"n_{name}", count <= study.n_samples, "at most `n_samples`")
    if study.below is not None:
        _between("share_of_samples_below", study.below, 0.0, 1.0)
        n_good = study.n_samples - study.n_failed
        whole = np.abs(study.below * n_good - np.round(study.below * n_good)) < _WHOLE * n_good
        check_holds("share_of_samples_below", whole, "a share of the samples that did not fail")


def _counts(counts: Mapping[str, int], n_runs: int) -> None:
    for name, count in counts.items():
        check_holds(f"counts.{name}", count <= n_runs, f"at most the {n_runs} models that were run")


def _drawn(settings: SamplingSettings) -> int:
    return n_drawn(settings.n_samples, settings.sampling)


def _influence(found: InfluenceResult) -> None:
    used = found.indices
    check_equal("n_base", used.n_base, found.settings.n_base)
    rows, rest = divmod(used.n_evaluations, len(found.names) + 2)
    check_holds("n_evaluations", rest == 0, f"{len(found.names) + 2} are a row")
    spare = rows - used.n_base - used.n_failed_rows  # of the last batch that replaced failed rows
    fits = 0 <= spare < BATCH if used.n_failed_rows else spare == 0
    check_holds("n_failed_rows", fits, "the others of the rows that were evaluated are `n_base`")
    _counts(found.counts, used.n_evaluations)
    least, in_a_row = used.n_failed_rows, len(found.names) + 2
    failed, partial = found.counts.get("failed", least), found.counts.get("partial", 0)
    in_rows = failed <= least * in_a_row and least <= failed + partial
    check_holds("counts.failed", in_rows, "they are in failed rows")
    if used.n_used is not None:
        _between("n_used", used.n_used, 0, used.n_base)
        check_holds("n_used", (used.n_used < used.n_base).any(), "below `n_base` for some output")
        check_holds("n_used", partial > 0, "some runs failed in some outputs only")
        has = np.isfinite(used.total_order).any(axis=1)
        check_holds("n_used", ~(has & used.unknown), "less than a quarter has no indices")
    for name in ("first_order", "total_order"):
        both = getattr(used, f"{name}_interval")
        if both is not None:
            _not_below(f"interval_95.{name}", both[1], both[0], "lower is at most upper")
    for group, sums in found.groups.items():
        mine = [j for j, n in enumerate(found.names) if found.model.groups.get(n) == group]
        if mine:  # a model that is no knee has lost its groups
            parts = used.first_order[:, mine]
            check_equal(
                f"groups_first_order.{group}",
                sums,
                parts.sum(axis=1),
                digits=digits_of(found.model),
                size=np.abs(parts).sum(axis=1),
            )


def _landscape(found: Landscape) -> None:
    _counts(found.counts, found.n_models)
    gappy = int(np.count_nonzero(~np.isfinite(found.y).all(axis=-1)))
    told = sum(found.counts.get(name, 0) for name in ("failed", "partial"))
    check_equal("counts.failed", told if found.counts else gappy, gappy)
    check_within("x", found.model, found.x[None])
    for name, axis in zip(found.names, found.axes, strict=True):
        check_holds("axes", np.diff(axis) > 0.0, "they rise")
        points = np.repeat(found.x[None], len(axis), axis=0)
        points[:, found.model.names.index(name)] = axis
        check_within("axes", found.model, points)


def _bound_sweep(sweep: BoundSweep) -> None:
    for name, counts in sweep.marks.items():
        _between(f"marks.{name}", counts, 0.0, 4.0)  # the worst pair and the range's two ends
    _between("objective_model", sweep.objective, 0.0, np.inf)
    low, high = sweep.pair.T
    _not_below("pair", high, low, "the smaller value is the first")
    _not_below("extremes", low, sweep.extremes[:, 0], "least is at most the pair's")
    _not_below("extremes", sweep.extremes[:, 1], high, "largest is at least the pair's")
    weight = sweep.model.weights()[sweep.column]
    least = weight * (high - low) * (1.0 - 1e-9)
    _not_below("objective_model", sweep.objective, least, "at least the watched difference")


def _needed_accuracy(need: NeededAccuracy) -> None:
    sizes, values = need.tried.T
    within, largest = need.settings.within, need.settings.largest
    assert within is not None
    check_holds("tried", np.diff(sizes) > 0.0, "sizes rise")
    check_holds("tried", sizes[:1] == 0.0, "the first size is 0")
    check_holds("tried", sizes[-1:] == largest, "the last size is the largest that was asked for")
    good = values <= within
    size = float(sizes[good].max()) if good[:1].all() else None
    if size is not None and not good[-1]:  # a bisection, with one passage from good to not good
        size = float(sizes[np.argmin(good) - 1])
    check_equal("size", need.size, size)
    check_equal("largest_value", need.largest_value, values[sizes == (size or 0.0)][0])
    next_one = None if size is None or good[-1] else int(np.argmin(good))
    beyond = (None, None) if next_one is None else (sizes[next_one], values[next_one])
    check_equal("beyond", need.beyond, beyond[0])
    check_equal("beyond_value", need.beyond_value, beyond[1])
    reaches = size is not None and bool(good[-1])
    check_holds("reaches_largest", need.reaches_largest == reaches, "it follows from `tried`")
    if need.beyond is not None and size is not None:
        near = need.beyond - size <= need.settings.tolerance * (1.0 + 1e-9)
        check_holds("beyond", near, "within the tolerance of `size`")
    sampled = need.sampled_value is not None
    check_holds("n_sampled", (need.n_sampled > 0) == sampled, "it stands beside the sampled value")
    check_holds("n_sampled", sampled == bool(size), "the size that was found is sampled")


def _accuracy_allocation(found: AccuracyAllocation) -> None:
    _needed_accuracy(found.equal)
    check_equal("equal.largest", found.equal.settings.largest, found.model.size)
    check_holds("n_sampled_failed", found.n_sampled_failed <= found.n_sampled, "at most all")
    model, within = found.model, found.settings.within
    costs = found.settings.costs or {}
    check_equal("measurements.cost", found.costs, [costs.get(n, 1.0) for n in found.names])
    members = members_of(model)
    told = isinstance(model, Knee) or any(one.measurement for one in model.inputs)
    if told and found.names != tuple(members):  # older files of other models do not tell
        raise FileFormatError(f"`measurements` must be {', '.join(members)}, in this order")
    if isinstance(model, Knee):  # of others it is not told whether they were per cent
        stated = [tolerance for tolerance, _ in stated_tolerances(model, members.values())]
        check_equal("measurements.stated", found.stated, stated)
    known = sorted(name for group in found.inputs for name in group)
    check_holds("measurements.inputs", known == sorted(model.free_names), "each input once")
    if found.factors is None or found.enlarged is None or within is None:
        check_holds("nominal_value", within is None or found.nominal_value >= within, "too large")
        return
    _between("measurements.cheapest_share", found.factors, 0.0, 1.0)
    _not_below("within", within, found.largest_value, "the largest value is at most as large")
    alone = np.isfinite(found.enlarged)
    check_holds("enlarged", alone == ~found.as_stated, "a number where it is not as stated")


def _training_sweep(sweep: TrainingSweep) -> None:
    with np.errstate(divide="ignore", invalid="ignore"):
        gap = 100.0 * (1.0 - sweep.objective_model / sweep.objective_surrogate)
    check_equal("gap_percent", sweep.gap_percent, gap, digits=digits_of(sweep.model), size=100.0)
    check_holds("n_test", 4 <= sweep.n_test <= N_TEST, f"4 to {N_TEST} is allowed")
    _between("rank_correlation_pairs", sweep.rank_f, -1.0, 1.0)
    _between("rank_correlation_worst", sweep.rank_outputs, -1.0, 1.0)
    _between("rms_error", sweep.rms_error, 0.0, np.inf)
    wanted = np.array(sweep.settings.sizes)[:, None]
    check_holds("n_failed", sweep.n_failed <= wanted, "at most `training_samples`")
    in_training = sweep.settings.n_seeds * sum(sweep.settings.sizes)
    _counts(sweep.counts, N_TEST + in_training + 2 * sweep.n_failed.size)


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
    check_equal("rms_error_all", judged.rms_all, follows, digits=digits_of(quality.model))
    check_holds("pairs", judged.f_surrogate >= 0.0, "f is 0 or above")
    check_holds("pairs", judged.f_model >= 0.0, "f is 0 or above")
    both = (judged.f_surrogate, judged.f_model)
    rounding = _RANKED if any(len(set(f.tolist())) < len(f) for f in both) else _EXACT
    check_equal(
        "rank_correlation_pairs",
        judged.rank_f,
        rank_correlation(*both),
        size=1.0,
        rounding=rounding,
    )
    n_training = quality.settings.training_samples
    check_holds("n_failed", quality.n_failed < n_training, "below `training_samples`")
    _counts(quality.counts, n_training + quality.settings.n_test)
    failed = quality.n_failed + quality.settings.n_test - quality.n_test
    check_equal("counts.failed", quality.counts.get("failed", failed), failed)


def _comparison(found: Comparison) -> None:
    _between("excess", found.excess, 0.0, np.inf)
    _between("excess_share", found.excess_share, 0.0, np.inf)
    with np.errstate(invalid="ignore"):
        inside = (found.excess == 0.0) & (found.excess_share > 0.0)
        outside = (found.excess > 1e-6) & (found.excess_share == 0.0)
    check_holds("excess_share", ~inside & ~outside, "0 inside of the band and above it outside")
    if found.below is not None:
        _between("share_of_samples_below", found.below, 0.0, 1.0)


def _study(study: Study) -> None:
    """Check the parts, and the comparison against the band of the samples beside it."""
    for part in (study.sampled, study.comparison, study.influence):
        if part is not None:
            check_relations(part)
    compared, band = study.comparison, study.sampled.y
    if compared is None:
        return
    with np.errstate(divide="ignore", invalid="ignore"):
        share = compared.excess / (band.percentile_upper - band.percentile_lower)
    share[~np.isfinite(share)] = np.nan  # of a band without a width
    check_equal(
        "comparison.excess_share",
        compared.excess_share,
        share,
        digits=digits_of(study.sampled.model),
        rounding=_OF_BAND,
    )
    check_equal("comparison.share_of_samples_below", compared.below, study.sampled.below)


def _bound_study(study: BoundStudy) -> None:
    check_relations(study.sweep)
    if study.need is not None:
        check_relations(study.need)


def _paper(report: PaperReport) -> None:
    for verdict in report.verdicts:
        claim = verdict.claim
        if claim.rule != "none" and claim.limit is None:
            raise FileFormatError(f"`limit` of the claim {claim.id!r} is missing; its rule has one")
        # What f does when a parameter is turned round is not in the file but in words.
        told = Finding(values=verdict.values, indifferent=verdict.outcome == "indifferent")
        outcome = judge(verdict.claim, told).outcome
        if verdict.outcome != outcome:
            raise FileFormatError(
                f"`outcome` of the claim {verdict.claim.id!r} is {verdict.outcome!r}; {outcome!r} "
                "follows from `ours`"
            )


_CHECKS: dict[str, Any] = {
    "SearchResult": check_search,
    "Response": check_status,
    "MonteCarloResult": _monte_carlo,
    "InfluenceResult": _influence,
    "Landscape": _landscape,
    "BoundSweep": _bound_sweep,
    "NeededAccuracy": _needed_accuracy,
    "AccuracyAllocation": _accuracy_allocation,
    "TrainingSweep": _training_sweep,
    "SurrogateQuality": _surrogate_quality,
    "Comparison": _comparison,
    "PaperReport": _paper,
    "Study": _study,
    "BoundStudy": _bound_study,
}


def check_relations(result: Any) -> None:
    """Raise a `FileFormatError` if a result, or one of several in a file, contradicts itself."""
    _CHECKS[type(result).__name__](result)
