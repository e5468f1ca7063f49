"""Measures of the searches and samples themselves: their f, their agreement, their times."""

import numpy as np
import scipy  # its subpackages are loaded when they are used: a page's start needs none
from numpy.typing import NDArray

from kneecore.knee.extension import extension_difference_percent as difference_percent
from kneecore.knee.parameters import STRUCTURE
from kneecore.knee.response import LARGEST_EXTENSION, LARGEST_FLEXION
from kneecore.paper.experiments import PAPER_BUDGET, Experiments
from kneecore.paper.finding import Finding
from kneecore.search.result import SearchResult

__all__ = [
    "change_tells_influence",
    "extension_difference_percent",
    "gap_percent",
    "geometry_share",
    "geometry_to_material",
    "larger_training_time_ratio",
    "main_search_seconds",
    "material_share",
    "model_search_seconds",
    "rank_correlation",
    "sampled_both_ends",
    "sampled_upper_extension_deg",
    "sampling_seconds",
    "speed_ratio",
    "surrogate_search_seconds",
    "surrogate_to_model_percent",
]

FloatArray = NDArray[np.float64]
_KIND = {name: kind for name, _, kind, _, _ in STRUCTURE}


def _number(value: float | None) -> float:
    return float("nan") if value is None else float(value)


def extension_difference_percent(done: Experiments) -> FloatArray:
    """Difference in extension in per cent of the baseline's range of motion, for each seed."""
    return np.array([_number(difference_percent(run.responses)) for run in done.repeats])


def _share(done: Experiments, case: str) -> float:
    return _number(done.cases[case].objective_model) / _number(done.main.objective_model)


def geometry_share(done: Experiments) -> float:
    """Return true f of the geometry's case over that of both."""
    return _share(done, "geometry")


def material_share(done: Experiments) -> float:
    """Return true f of the material's case over that of both."""
    return _share(done, "material")


def sampled_upper_extension_deg(done: Experiments) -> float:
    """Mean + 3 sd of the sampled angle at 5 N m of extension."""
    return float(done.sampling.y.sigma_upper[LARGEST_EXTENSION])


def sampled_both_ends(done: Experiments) -> Finding:
    """Count drawn knees more than 1 sd beyond the mean at both ends of the motion."""
    drawn = done.drawn[np.isfinite(done.drawn).all(axis=1)]
    if len(drawn) < 2:
        return Finding(values=np.array([np.nan]))
    ends = drawn[:, [LARGEST_EXTENSION, LARGEST_FLEXION]]
    n, beyond_2 = (_beyond_both(done, ends, width) for width in (1.0, 2.0))
    alike = float(scipy.stats.spearmanr(ends[:, 0], ends[:, 1]).statistic)
    return Finding(
        values=np.array([float(n)]),
        told=f"{n} of {len(drawn):,}, and {beyond_2} beyond 2 sd; the rank correlation of the two "
        f"angles is {alike:.2f}.",
    )


def _beyond_both(done: Experiments, ends: FloatArray, width: float) -> int:
    """Count knees that over-extend and over-flex by more than so many sd of the samples."""
    spread = done.sampling.y
    low, high = spread.mean - width * spread.sd, spread.mean + width * spread.sd
    over_extends = ends[:, 0] < low[LARGEST_EXTENSION]
    over_flexes = ends[:, 1] > high[LARGEST_FLEXION]
    return int(np.count_nonzero(over_extends & over_flexes))


def geometry_to_material(done: Experiments) -> float:
    """Total indices of all geometry over those of all material, at the load where it is least."""
    total = np.nan_to_num(done.influence.indices.total_order)
    material = np.array([_KIND[name] == "material" for name in done.influence.names])
    of_geometry, of_material = total[:, ~material].sum(axis=1), total[:, material].sum(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        return float(np.nanmin(of_geometry / of_material))


def change_tells_influence(done: Experiments) -> FloatArray:
    """Rank correlation of how far the two knees differ in a parameter, and its total index.

    For each pair. 0 where all parameters differ by the same share of their range: then the pair
    ranks none of them.
    """
    free = done.knee.free
    width = (done.knee.space.upper - done.knee.space.lower)[: len(free)][free]
    total = np.nan_to_num(done.influence.indices.total_order).mean(axis=0)
    found = []
    for pair in done.pairs:
        share = np.round(np.abs(pair.x[0] - pair.x[1])[: len(free)][free] / width, 6)
        alike = np.ptp(share) == 0.0 or np.ptp(total) == 0.0
        found.append(0.0 if alike else float(scipy.stats.spearmanr(share, total).statistic))
    return np.array(found)


def rank_correlation(done: Experiments) -> FloatArray:
    """Rank correlation of the surrogate's f and the true f over new pairs, for each seed."""
    return done.rank_f


def gap_percent(done: Experiments) -> FloatArray:
    """Return what the surrogate promises too much, in per cent of its f, for each seed."""
    return np.array([_number(run.gap_percent) for run in done.repeats])


def surrogate_to_model_percent(done: Experiments) -> FloatArray:
    """Return true f of the surrogate's best in per cent of the true search's, for each seed."""
    pairs = zip(done.surrogate_runs, done.model_runs, strict=True)
    return np.array(
        [100.0 * _number(s.objective_model) / _number(m.objective_model) for s, m in pairs]
    )


def _median_seconds(runs: tuple[SearchResult, ...]) -> float:
    """Return the median time of the searches alone: what else the machine does disturbs it less."""
    return float(np.median([run.seconds["search"] for run in runs]))


def main_search_seconds(done: Experiments) -> float:
    """Time of the main search, the optimisation alone; NaN if it has not the paper's size."""
    return _median_seconds(done.repeats) if done.budget == PAPER_BUDGET else float("nan")


def surrogate_search_seconds(done: Experiments) -> float:
    """Time of a shorter search in the surrogate; NaN if it has not the paper's size."""
    return _median_seconds(done.surrogate_runs) if done.budget == PAPER_BUDGET else float("nan")


def model_search_seconds(done: Experiments) -> float:
    """Time of a shorter search in the true model; NaN if it has not the paper's size."""
    return _median_seconds(done.model_runs) if done.budget == PAPER_BUDGET else float("nan")


def speed_ratio(done: Experiments) -> float:
    """How much faster a search in the surrogate is than one in the true model."""
    return _median_seconds(done.model_runs) / _median_seconds(done.surrogate_runs)


def larger_training_time_ratio(done: Experiments) -> float:
    """Time of a search with twice the training knees over that with the paper's number."""
    return _median_seconds(done.larger_runs) / _median_seconds(done.surrogate_runs)


def sampling_seconds(done: Experiments) -> float:
    """Time of the Monte-Carlo samples; NaN if they are not as many as the paper's."""
    return done.sampling.seconds["sampling"] if done.budget == PAPER_BUDGET else float("nan")
