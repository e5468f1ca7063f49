"""What a search says about how good its result is, in words."""

from kneecore.knee.model import Knee
from kneecore.model import Model
from kneecore.report.tables import significant, with_unit
from kneecore.search.result import METHOD_NAMES, Evidence, Repair, SearchResult

__all__ = ["comparison_lines", "evidence_lines", "repair_line", "way_found"]


def _f(model: Model, value: float) -> str:
    text = f"{value:.2f}" if isinstance(model, Knee) else significant(value)
    return with_unit(text, model.objective_unit)


def way_found(evidence: Evidence) -> str:
    """Return how an exact search came to its f, and that nothing is proven."""
    n = len(evidence.patterns)
    told = f"climbs with gradients from {n} pattern{'s' * (n != 1)} of signs"
    if evidence.n_models:
        told += ", in the model near it that has gradients (knees: at rest), then flips of inputs"
        told += " in the model itself"
        if evidence.many_failed:
            told += " and an evolution strategy for each of the two"
    if evidence.many_failed:
        share = evidence.n_failed / evidence.n_evaluations
        told += f"; {share:.0%} of the models looked at failed, and a longer search may find more"
    return f"Best known value, by {told}. Nothing is proven."


def evidence_lines(model: Model, evidence: Evidence) -> list[str]:
    """Return how f was reached, how many climbs came to the pair, and what else was found."""
    # In a model without gradients it was the one near it that was climbed.
    pair = "the worst pair at rest, by its f" if evidence.n_models else "this pair's f"
    lines = [
        way_found(evidence),
        f"{evidence.share_reached:.0%} of {evidence.n_climbs} climbs ended in {pair}, to 0.01 %. "
        "No proof that it is the largest.",
    ]
    if evidence.second_best is not None:
        lines[1] += f" Second-best basin: {_f(model, evidence.second_best)}."
    if evidence.objective_before_climb is not None and evidence.objective_proxy is not None:
        rest, before = evidence.objective_proxy, evidence.objective_before_climb
        lines.append(
            f"Worst pair at rest: {_f(model, rest)}. Before the climb in motion "
            f"the best of rest's pairs had {_f(model, before)} there."
        )
    return lines


def repair_line(repair: Repair) -> str:
    """Return how the surrogate's gap came down."""
    gaps = ["unknown" if r.gap_percent is None else f"{r.gap_percent:.2f}" for r in repair.rounds]
    told = f"below {repair.goal_percent:g} %" if repair.reached else "not repaired"
    failed = f", {repair.n_failed} of them failed" if repair.n_failed else ""
    checked = f" {repair.n_checked} more looked at the pair again." if repair.n_checked else ""
    return (
        f"Surrogate repaired with {repair.n_models} more models{failed}: gap at its optimum "
        f"{', '.join(gaps)} % ({told}).{checked}"
    )


def comparison_lines(result: SearchResult) -> list[str]:
    """Return the best f over all methods, and by how much each falls short of it."""
    best, model = result.best_of_all, result.model
    if not result.methods or best is None:
        return []
    lines = [f"Best f of all methods in the true model: {_f(model, best)}. Below it:"]
    if result.objective_model is not None:
        lines.append(f"  this search: {100.0 * (1.0 - result.objective_model / best):.2f} %")
    for trace in result.methods:
        short = trace.shortfall_percent(best)
        told = "the true model fails for its pair" if short is None else f"{short:.2f} %"
        if trace.n_models:
            told += f" after {trace.n_models[-1]:,.0f} models"
        if trace.promised is not None:
            told += f" (its surrogate promised {_f(model, trace.promised)})"
        lines.append(f"  {METHOD_NAMES[trace.method]}: {told}")
    return lines
