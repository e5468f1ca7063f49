"""Our quantity beside each claim of the paper: one small function each.

A measure returns one number, or one for each seed of a repeated search, in the unit that
`assets/paper.toml` names. What a failed model leaves unknown is NaN.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from kneecore.knee.extension import extension_difference_percent as difference_percent
from kneecore.knee.parameters import LIGAMENTS, STRUCTURE
from kneecore.knee.physics.forces import THETA_0
from kneecore.knee.response import LARGEST_EXTENSION, LARGEST_FLEXION, MOMENT, Response
from kneecore.paper.experiments import PAPER_BUDGET, Experiments
from kneecore.paper.geometry_changes import geometry_changes, ligament_lines
from kneecore.search.result import SearchResult

__all__ = ["MEASURES", "ap_slopes"]

FloatArray = NDArray[np.float64]
Measure = Callable[[Experiments], float | FloatArray]
_ACL, _PCL = LIGAMENTS.index("acl"), LIGAMENTS.index("pcl")
_EXTENSION = np.flatnonzero(MOMENT > 0)
_GEOMETRY = np.array([kind == "geometry" for _, _, kind, _, _ in STRUCTURE])


def _number(value: float | None) -> float:
    return float("nan") if value is None else float(value)


def _degrees(response: Response, load: int) -> float:
    return float(np.degrees(response.flexion[load]))


def baseline_extension_deg(done: Experiments) -> float:
    """Angle of the baseline at 5 N m of extension."""
    return _degrees(done.main.responses["baseline"], LARGEST_EXTENSION)


def baseline_flexion_deg(done: Experiments) -> float:
    """Angle of the baseline at 5 N m of flexion."""
    return _degrees(done.main.responses["baseline"], LARGEST_FLEXION)


def baseline_settled_loads(done: Experiments) -> float:
    """Count the loads at which the baseline has come to rest."""
    return float(np.count_nonzero(done.main.responses["baseline"].settled))


def baseline_cruciate_force_n(done: Experiments) -> float:
    """Largest ACL or PCL tension of the baseline over the 12 loads."""
    return float(done.main.responses["baseline"].tension[:, [_ACL, _PCL]].max())


def cruciates_cross(done: Experiments) -> float:
    """Return 1 if the baseline's cruciates cross in the load-free pose, 0 if not."""
    lines = ligament_lines(
        done.knee.space.baseline, done.main.responses["baseline"].load_free_position
    )
    (a, b), (c, d) = lines[_ACL], lines[_PCL]
    parted = _side(a, b, c) * _side(a, b, d) < 0 and _side(c, d, a) * _side(c, d, b) < 0
    return float(parted)


def _side(start: FloatArray, end: FloatArray, point: FloatArray) -> float:
    """Tell on which side of a line a point lies, by the sign of an area."""
    along, off = end - start, point - start
    return float(along[0] * off[1] - along[1] * off[0])


def ap_slopes(response: Response) -> tuple[float, float]:
    """Return a knee's slope of contact position over angle, mm/deg, before and beyond 54.79 deg.

    By least squares through the loads on that side; negative: the contact moves back with flexion.
    NaN for a failed knee, and for one with less than two loads on that side.
    """
    angles = np.degrees(response.flexion)
    position = 1e3 * response.ap_position
    beyond = angles > np.degrees(THETA_0)
    before = _slope(angles[~beyond], position[~beyond])
    return before, _slope(angles[beyond], position[beyond])


def _slope(x: FloatArray, y: FloatArray) -> float:
    if len(x) < 2 or not np.isfinite([x, y]).all():
        return float("nan")
    return float(np.polyfit(x, y, 1)[0])


def ap_slope_ratio(done: Experiments) -> float:
    """Slope of the baseline's contact position beyond the load-free angle over that before it."""
    before, beyond = ap_slopes(done.main.responses["baseline"])
    return beyond / before


def model_1_extension_deg(done: Experiments) -> float:
    """Angle of the over-extending worst case at 5 N m of extension."""
    return _degrees(done.main.responses["model_1"], LARGEST_EXTENSION)


def model_2_extension_deg(done: Experiments) -> float:
    """Angle of the other worst case at 5 N m of extension."""
    return _degrees(done.main.responses["model_2"], LARGEST_EXTENSION)


def _tension_at(response: Response, angle_deg: float) -> FloatArray:
    """Return the tensions at an angle in extension, shape (4,), N; NaN beyond the knee's reach."""
    order = _EXTENSION[np.argsort(response.flexion[_EXTENSION])]
    angles = np.append(np.degrees(response.flexion[order]), np.degrees(THETA_0))
    tensions = np.vstack([response.tension[order], np.zeros(len(LIGAMENTS))])
    return np.array(
        [np.interp(angle_deg, angles, column, left=np.nan, right=np.nan) for column in tensions.T]
    )


def force_ratio_at_minus_10_deg(done: Experiments) -> float:
    """Largest tension of the over-extending knee at -10 deg over the baseline's at 5 N m."""
    most = float(_tension_at(done.main.responses["model_1"], -10.0).max())
    return most / float(done.main.responses["baseline"].tension[LARGEST_EXTENSION].max())


def early_pcl_ratio(done: Experiments) -> float:
    """PCL tension of model 2 at 5 N m of extension over the baseline's at the same angle."""
    stopped = done.main.responses["model_2"]
    usual = _tension_at(done.main.responses["baseline"], _degrees(stopped, LARGEST_EXTENSION))[_PCL]
    return float(stopped.tension[LARGEST_EXTENSION, _PCL] / usual) if usual > 0.0 else float("nan")


def beyond_sampling_deg(done: Experiments) -> float:
    """How far the nearer worst case lies outside of mean +- 3 sd at 5 N m of extension."""
    spread = done.sampling.y
    below = spread.sigma_lower[LARGEST_EXTENSION] - model_1_extension_deg(done)
    above = model_2_extension_deg(done) - spread.sigma_upper[LARGEST_EXTENSION]
    return float(np.minimum(below, above))


def loads_in_order(done: Experiments) -> float:
    """Count the loads at which model 1 has the smaller angle."""
    one, two = done.main.responses["model_1"].flexion, done.main.responses["model_2"].flexion
    if not np.isfinite(one + two).all():
        return float("nan")
    return float(np.count_nonzero(one < two))


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


def sampling_seconds(done: Experiments) -> float:
    """Time of the Monte-Carlo samples; NaN if they are not as many as the paper's."""
    return done.sampling.seconds["sampling"] if done.budget == PAPER_BUDGET else float("nan")


def _n_opposite(one: FloatArray, two: FloatArray) -> float:
    return float(np.count_nonzero(one * two < 0.0))


def opposite_along_plateau(done: Experiments) -> float:
    """Attachments that the two worst cases move in opposite directions along the plateau."""
    one, two = geometry_changes(done.main)
    return _n_opposite(one.along_mm, two.along_mm)


def opposite_across_plateau(done: Experiments) -> float:
    """Attachments that they move in opposite directions across the plateau."""
    one, two = geometry_changes(done.main)
    return _n_opposite(one.across_mm, two.across_mm)


def opposite_ligament_angles(done: Experiments) -> float:
    """Ligaments that they turn in opposite directions."""
    one, two = geometry_changes(done.main)
    return _n_opposite(one.angle_deg, two.angle_deg)


def opposite_stiffnesses(done: Experiments) -> float:
    """Ligaments that are stiffer in one and softer in the other."""
    one, two = geometry_changes(done.main)
    return _n_opposite(one.stiffness_percent, two.stiffness_percent)


def geometry_on_bounds_percent(done: Experiments) -> float:
    """Share of the free geometric parameters of both worst cases that lie on a bound."""
    free = _GEOMETRY[: len(done.knee.free)] & done.knee.free
    on_bound = done.knee.at_bounds(done.main.x)[:, free] != 0
    return 100.0 * float(on_bound.mean()) if on_bound.size else float("nan")


MEASURES: dict[str, Measure] = {
    measure.__name__: measure
    for measure in (
        baseline_extension_deg,
        baseline_flexion_deg,
        baseline_settled_loads,
        baseline_cruciate_force_n,
        cruciates_cross,
        ap_slope_ratio,
        model_1_extension_deg,
        model_2_extension_deg,
        force_ratio_at_minus_10_deg,
        early_pcl_ratio,
        beyond_sampling_deg,
        loads_in_order,
        extension_difference_percent,
        geometry_share,
        material_share,
        sampled_upper_extension_deg,
        gap_percent,
        surrogate_to_model_percent,
        speed_ratio,
        opposite_along_plateau,
        opposite_across_plateau,
        opposite_ligament_angles,
        opposite_stiffnesses,
        geometry_on_bounds_percent,
        main_search_seconds,
        surrogate_search_seconds,
        model_search_seconds,
        sampling_seconds,
    )
}
"""By the names that `assets/paper.toml` uses."""
