"""What a search found, in words and a table."""

import numpy as np
from numpy.typing import NDArray

from kneecore import LIGAMENTS, Response, SearchResult
from kneecore.report.bound_evidence import premise
from kneecore.report.evidence import way_found
from kneeviz.state import results
from kneeviz.views import theme
from kneeviz.views.html.labels import parameter_label
from kneeviz.views.html.marks import signs
from kneeviz.views.html.pieces import coloured, faint, number, table

WIDE_GAP = 10.0
"""Per cent between a surrogate's f and the true model's, from where on it is warned about."""
_F = "f, the angles between the two summed over the loads"


def _sides(result: SearchResult) -> NDArray[np.int8]:
    """Return at which bound each parameter of both knees lies, shape (2, n): -1, 0 or 1."""
    space = results.space(result)
    return np.stack([space.at_bounds(x) for x, _ in results.knees(result)])


def differences(result: SearchResult, colours: theme.Palette) -> str:
    """Return the table of what differs between the two worst cases."""
    (_, one), (_, two) = results.knees(result)
    head = ("", coloured("model 1", colours.model_1), coloured("model 2", colours.model_2))
    straight = [float(np.degrees(r.flexion[5])) for r in (one, two)]
    rows = [
        ("Angle at +5 N·m", *(_marked(r, 5) for r in (one, two))),
        ("Over-extension", *(number(max(-a, 0.0), 1, "°") for a in straight)),
        ("Extension deficit", *(number(max(a, 0.0), 1, "°") for a in straight)),
        ("Angle at \u22125 N·m", *(_marked(r, 11) for r in (one, two))),
    ]
    for i, name in enumerate(LIGAMENTS):
        rows.append(
            (f"{name.upper()} at +5 N·m", *(number(r.tension[5, i], 0, "N") for r in (one, two)))
        )
    rows.append(("Contact at +5 N·m", *(number(r.contact_force[5], 0, "N") for r in (one, two))))
    free = results.space(result).n_free
    on_bound = (int((sides != 0).sum()) for sides in _sides(result))
    rows.append(("Parameters at a bound", *(f"{n} of {free}" for n in on_bound)))
    return table(head, rows)


def _marked(response: Response, k: int) -> str:
    """Return the angle at load `k` with the signs behind it, which tell what they mean."""
    return number(float(np.degrees(response.flexion[k])), 1, "°") + signs(response, k)


def objective_line(result: SearchResult) -> str:
    """Return what f is, the true model's beside the surrogate's: never one without the other."""
    model = result.objective_model
    true = "not known (the model failed there)" if model is None else number(model, 0, "°")
    rest = " at rest" if results.solver(result) == "equilibrium" else ""
    if result.objective_surrogate is None:
        return f"{_F} = <b>{true}</b>, searched in the true model{rest}."
    gap = "" if result.gap_percent is None else f" (gap {number(result.gap_percent, 1, '%')})"
    return (
        f"{_F}: surrogate {number(result.objective_surrogate, 0, '°')}, "
        f"true model{rest} <b>{true}</b>{gap}.{_warning(result.gap_percent)}"
    )


def _warning(gap_percent: float | None) -> str:
    """Return what a wide gap means, in words."""
    if gap_percent is None or gap_percent <= WIDE_GAP:
        return ""
    return (
        " <b>The surrogate is not to be trusted here:</b> go by the true model's value, "
        "or search with exact gradients or “Repair”."
    )


def reconciled(at_rest: float, in_motion: float, same_pair: float | None) -> str:
    """Return why a search at rest and one in motion of the same bounds differ, in a line.

    Parameters
    ----------
    at_rest, in_motion : float
        f that each has found, deg.
    same_pair : float or None
        f of the pair found in motion, were both knees at rest.
    """
    words = (
        f"Two answers: at rest {number(at_rest, 1, '°')}, "
        f"in motion, when the paper\u2019s 23 s are over, {number(in_motion, 1, '°')}."
    )
    if same_pair is not None:
        words += (
            f" The pair found in motion would be {number(same_pair, 1, '°')} apart at rest: of the "
            f"difference of {number(at_rest - in_motion, 1, '°')}, "
            f"{number(same_pair - in_motion, 1, '°')} are motion that has not ended, "
            f"{number(at_rest - same_pair, 1, '°')} another pair."
        )
    return f"<br>{faint(words)}"


def evidence_line(result: SearchResult) -> str:
    """Return what an exact search says about how good its f is; nothing for another."""
    evidence = result.evidence
    if evidence is None:
        return ""
    where = "" if result.settings.search_space == "model" else " in the surrogate"
    share = number(100.0 * evidence.share_reached, 0, "%")
    place = "in the worst pair at rest" if evidence.n_models else "here"
    parts = [f"{share} of {evidence.n_climbs} climbs{where} end {place}"]
    if evidence.second_best is not None:
        parts.append(f"second basin {number(evidence.second_best, 1, '°')}")
    space = results.space(result)
    inside = int((_sides(result) == 0)[:, space.free].sum())
    total = 2 * space.n_free
    parts.append(f"{total - inside} of {total} values on a bound")
    if evidence.objective_before_climb is not None and result.objective_model is not None:
        gain = result.objective_model - evidence.objective_before_climb
        parts.append(f"{number(gain, 1, '°')} gained in motion")
    if evidence.n_failed:
        parts.append(f"{evidence.n_failed:,} knees without an equilibrium left out")
    parts += _bound_parts(result)
    told = "; ".join(parts)
    return f"<br>{faint(f'{way_found(evidence)} {told}.')}"


def _bound_parts(result: SearchResult) -> list[str]:
    """Return what slopes over the whole bounds say; nothing if they were not looked at."""
    bound = None if result.evidence is None else result.evidence.bound
    if bound is None:
        return []
    rest = "" if results.solver(result) == "equilibrium" else " at rest"
    parts = [f"{bound.n_one_signed} of {bound.n_inputs} slopes{rest} keep their sign"]
    if bound.vertices_objective is not None:
        value = number(bound.vertices_objective, 1, "°")
        parts.append(f"{bound.n_vertices:,} vertices of the others: at most {value}{rest}")
        if bound.vertices_in_motion is not None:
            parts[-1] += f", {number(bound.vertices_in_motion, 1, '°')} in motion"
    parts += [f"{number(b.objective, 1, '°')}{rest}: {premise(b)}" for b in bound.bounds]
    if not bound.bounds:
        parts.append("no sampled bound, since knees within the bounds lose their equilibrium")
    return parts


def repair_line(result: SearchResult) -> str:
    """Return how a surrogate was repaired; nothing for one that was not."""
    repair = result.repair
    if repair is None:
        return ""
    gaps = [r.gap_percent for r in repair.rounds if r.gap_percent is not None]
    first = (
        f": the gap went from {number(gaps[0], 1)} to {number(gaps[-1], 1, '%')}" if gaps else ""
    )
    missed = "" if repair.reached else f" (its goal, {repair.goal_percent:g} %, was not reached)"
    return f"<br>{faint(f'Repaired with {repair.n_models} more models{first}{missed}.')}"


IMPROVING_NOTE = (
    "Live, improving \u2026 The best two knees at rest until now, within the bounds around yours; "
    "the search goes on, and the band of other knees follows."
)
"""What stands beside the live answer while its search goes on."""


def unfinished_line(result: SearchResult, *, improving: bool) -> str:
    """Return that a result is the best until now, or until it was stopped; nothing for an end."""
    if result.stop_reason != "cancelled":
        return ""
    if improving:
        return "<br><b>improving \u2026</b>"
    return f"<br>{faint('The search was stopped: this is the best pair until then.')}"


def live_note(sampled: str) -> str:
    """Return what the live search shows, in words."""
    return (
        "Live, settled: every knee at rest under its load, within the bounds around yours. "
        f"The pale band holds 99.7 % of {sampled}."
    )


def bound_names(result: SearchResult) -> str:
    """Return which parameters have the two models at opposite bounds."""
    one, two = _sides(result).astype(int)
    names = results.space(result).names
    opposite = [parameter_label(names[i]) for i in np.flatnonzero(one * two < 0)]
    if not opposite:
        return "No parameter lies at opposite bounds in the two."
    return f"At opposite bounds ({len(opposite)}): {', '.join(opposite)}."
