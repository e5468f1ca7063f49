"""What slopes over the whole bounds say about a search's f, in words. Nothing of it is a proof."""

from kneecore.knee.model import Knee
from kneecore.model import Model
from kneecore.report.tables import significant, with_unit
from kneecore.search.half_bound import MAX_ENUMERATED
from kneecore.search.result import BoundEvidence, SampledBound, SearchResult

__all__ = ["bound_lines", "premise"]


def premise(one: SampledBound) -> str:
    """Return under which condition a sampled bound holds."""
    within = "" if one.widening_percent == 0.0 else f"{one.widening_percent:g} % of "
    return f"sampled bound, if slopes stay within {within}their sampled range"


def _f(model: Model, value: float) -> str:
    text = f"{value:.2f}" if isinstance(model, Knee) else significant(value)
    return with_unit(text, model.objective_unit)


def _above(value: float, found: float | None) -> str:
    """Return by how much a value is above the one that was found, or below it."""
    if not found:
        return ""
    percent = 100.0 * (value / found - 1.0)
    if abs(percent) < 0.005:
        return " (the search's own f)"
    return f" ({abs(percent):.2f} % {'above' if percent > 0.0 else 'below'} the search's f)"


def bound_lines(result: SearchResult) -> list[str]:
    """Return what slopes say, or that it was asked for and is not there; nothing if not asked."""
    evidence = result.evidence
    if not result.settings.bound or evidence is None:
        return []
    bound = evidence.bound
    if bound is None:
        return ["The sampled bound was cancelled."]
    at_rest = isinstance(result.model, Knee) and evidence.n_models > 0
    lines = [_signs_line(bound, at_rest=at_rest)]
    lines.append(_vertices_line(result, bound, evidence.objective_proxy, at_rest=at_rest))
    if not bound.bounds:
        return [*lines, _no_bound_line(bound)]
    where = " at rest (motion has no slopes)" if at_rest else ""
    looks = max(one.n_looks for one in bound.bounds)
    near = ""
    if looks:
        near = (
            f"; at most {looks} of them needed a closer look, over faces and halves of the bounds, "
            "each with a sampled range of its own"
        )
    lines.append(
        f"f{where} is at most, over all {bound.n_patterns:,} patterns of signs (by slopes over the "
        f"whole bounds{near}):"
    )
    for one in bound.bounds:
        above = _above(one.objective, evidence.objective_proxy)
        lines.append(f"  {_f(result.model, one.objective)}{above}: {premise(one)}")
    return lines


def _signs_line(bound: BoundEvidence, *, at_rest: bool) -> str:
    lost = f", {bound.n_failed:,} of which failed" if bound.n_failed else ""
    rest = " at rest" if at_rest else ""
    told = (
        f"{bound.n_one_signed} of {bound.n_inputs} inputs have a slope that keeps its sign over "
        f"{bound.n_models:,} models{rest} within the bounds{lost}"
    )
    if not bound.n_one_signed_sampled:
        return f"{told}."
    random = bound.n_one_signed_sampled
    return f"{told}: {random} over random ones, and then {bound.n_one_signed} under attack."


def _vertices_line(
    result: SearchResult, bound: BoundEvidence, found: float | None, *, at_rest: bool
) -> str:
    left = bound.n_inputs - bound.n_one_signed
    if bound.n_vertices is None:
        return (
            f"{left} inputs are not one-signed, too many to enumerate their vertices (at most "
            f"{MAX_ENUMERATED}): nothing is said of them."
        )
    told = f"The {bound.n_vertices:,} vertices that are left by the other {left}, all computed"
    if bound.vertices_objective is None:
        return f"{told}: models fail on some, and nothing is said of them."
    rest = " at rest" if at_rest else ""
    told += f": at most f = {_f(result.model, bound.vertices_objective)}{rest}"
    told += _above(bound.vertices_objective, found)
    if bound.vertices_in_motion is not None:
        told += f", {_f(result.model, bound.vertices_in_motion)} in motion"
        told += _above(bound.vertices_in_motion, result.objective_model)
    return f"{told}."


def _no_bound_line(bound: BoundEvidence) -> str:
    share = bound.n_failed / max(bound.n_models, 1)
    many = f" ({share:.1%} of those looked at)" if bound.n_failed else ""
    return f"No sampled bound: models within the bounds fail{many}."
