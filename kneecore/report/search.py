"""A result for people: the tables that a terminal and a notebook show."""

from typing import TYPE_CHECKING

import numpy as np
from rich.console import RenderableType
from rich.table import Table
from rich.text import Text

from kneecore.knee.parameters import LIGAMENTS, STRUCTURE, display_values
from kneecore.knee.response import MOMENT
from kneecore.report.command import needs_file
from kneecore.report.tables import degrees, render, table
from kneecore.search.rival import METHOD_NAMES

if TYPE_CHECKING:
    from kneecore.search.repair_history import Repair
    from kneecore.search.result import PairResult, SearchResult
    from kneecore.search.sign_climb import Evidence


def _pose(flexion_deg: float) -> str:
    if flexion_deg < 0.0:
        return f"over-extends to {flexion_deg:.1f} deg"
    return f"stops at {flexion_deg:.1f} deg of flexion"


def summary_sentence(result: "SearchResult") -> str:
    """Return what differs, in one sentence."""
    from kneecore.search.result import LARGEST_EXTENSION

    failed = [n for n, r in result.models.items() if r.status == "failed"]
    if failed:
        told = f"The true model fails for {' and '.join(failed)}; no angles can be compared."
        if result.search_space == "surrogate":
            told += " A search in the true model leaves such knees out (--space model)."
        return told
    one, two = (np.degrees(m.flexion[LARGEST_EXTENSION]) for m in (result.model_1, result.model_2))
    moment = MOMENT[LARGEST_EXTENSION]
    return f"At {moment:+g} N m model 1 {_pose(one)} and model 2 {_pose(two)}."


def _headline(result: "SearchResult") -> str:
    lines = [result.summary()]
    if result.extension_difference_deg is not None:
        percent = result.extension_difference_percent
        share = "" if percent is None else f", {percent:.1f} % of the baseline's range of motion"
        lines.append(f"Difference in extension: {result.extension_difference_deg:.2f} deg{share}.")
    model = "failed" if result.objective_model is None else f"{result.objective_model:.2f} deg"
    if result.objective_surrogate is None:
        lines.append(f"f (true model): {model}.")
    else:
        gap = "" if result.gap_percent is None else f" (gap {result.gap_percent:.2f} %)"
        lines.append(f"f: surrogate {result.objective_surrogate:.2f} deg, true model {model}{gap}.")
    if result.repair is not None:
        lines.append(_repair(result.repair))
    if len(result.run_values) > 1:
        low, high = min(result.run_values), max(result.run_values)
        lines.append(f"{len(result.run_values)} runs: best f {high:.2f}, worst {low:.2f} deg.")
    if result.evidence is not None:
        lines += _evidence(result.evidence)
    lines += _comparison(result)
    if result.stop_reason == "cancelled":
        lines.append("The search was cancelled: this is the best pair until then.")
    return "\n".join(lines)


def _evidence(evidence: "Evidence") -> list[str]:
    lines = [
        f"{evidence.share_reached:.0%} of {evidence.n_climbs} climbs ended in this pair's f, to "
        "0.01 %. No proof that it is the largest."
    ]
    if evidence.second_best is not None:
        lines[0] += f" Second-best basin: {evidence.second_best:.2f} deg."
    if evidence.objective_before_climb is not None and evidence.objective_at_rest is not None:
        lines.append(
            f"Worst pair at rest: {evidence.objective_at_rest:.2f} deg. Before the climb in motion "
            f"the best of rest's pairs had {evidence.objective_before_climb:.2f} deg there."
        )
    return lines


def _repair(repair: "Repair") -> str:
    """Return how the surrogate's gap came down."""
    gaps = ["unknown" if r.gap_percent is None else f"{r.gap_percent:.2f}" for r in repair.rounds]
    told = f"below {repair.goal_percent:g} %" if repair.reached else "not repaired"
    failed = f", {repair.n_failed} of them failed" if repair.n_failed else ""
    return (
        f"Surrogate repaired with {repair.n_models} more models{failed}: gap at its optimum "
        f"{', '.join(gaps)} % ({told})."
    )


def _comparison(result: "SearchResult") -> list[str]:
    """Return the best f over all methods, and by how much each falls short of it."""
    best = result.best_of_all
    if not result.rivals or best is None:
        return []
    lines = [f"Best f of all methods in the true model: {best:.2f} deg. Below it:"]
    if result.objective_model is not None:
        lines.append(f"  this search: {100.0 * (1.0 - result.objective_model / best):.2f} %")
    for rival in result.rivals:
        short = rival.shortfall_percent(best)
        told = "the true model fails for its pair" if short is None else f"{short:.2f} %"
        if rival.n_models:
            told += f" after {rival.n_models[-1]:,.0f} models"
        if rival.promised is not None:
            told += f" (its surrogate promised {rival.promised:.2f} deg)"
        lines.append(f"  {METHOD_NAMES[rival.method]}: {told}")
    return lines


def _angles(result: "SearchResult") -> Table:
    predicted = result.predicted_flexion
    columns = ["moment N m", "baseline", "model 1", "model 2", "difference"]
    if predicted is not None:
        columns += ["surrogate 1", "surrogate 2"]
    rows = table("Flexion angle, deg (* not settled)", *columns)
    for k in np.argsort(-MOMENT):
        angles = [m.flexion[k] for m in result.models.values()]
        marks = ["" if m.settled[k] else "*" for m in result.models.values()]
        row = [f"{MOMENT[k]:+g}"]
        row += [degrees(a) + mark for a, mark in zip(angles, marks, strict=True)]
        row.append(degrees(angles[2] - angles[1]))
        if predicted is not None:
            row += [degrees(predicted[0, k]), degrees(predicted[1, k])]
        rows.add_row(*row)
    return rows


def _forces(result: "SearchResult") -> Table:
    columns = [f"{name.upper()}" for name in LIGAMENTS]
    rows = table(
        "Forces, N, and contact position, mm", "moment N m", "model", *columns, "contact", "AP"
    )
    for k in (int(np.argmax(MOMENT)), int(np.argmin(MOMENT))):
        for name, model in result.models.items():
            forces = [*model.tension[k], model.contact_force[k]]
            rows.add_row(
                f"{MOMENT[k]:+g}",
                name.replace("_", " "),
                *(f"{force:.0f}" for force in forces),
                f"{1e3 * model.ap_position[k]:.2f}",
            )
    return rows


def _parameters(result: "SearchResult") -> Table:
    rows = table(
        "Parameters (v lower bound, ^ upper bound)",
        "parameter",
        "unit",
        "baseline",
        "model 1",
        "model 2",
    )
    values = [display_values(x) for x in (result.space.baseline, *result.x)]
    sides = result.space.at_bounds(result.x)
    marks = {-1: " v", 0: "  ", 1: " ^"}
    for i, name in enumerate(result.space.names):
        if not result.space.free[i]:
            continue
        row = [f"{values[0][i]:.3f}"]
        row += [f"{values[m + 1][i]:.3f}{marks[int(sides[m][i])]}" for m in range(2)]
        rows.add_row(name, STRUCTURE[i][3], *row)
    return rows


def _footer(result: "SearchResult") -> str:
    counts, seconds = result.counts, result.seconds
    held = len(result.space.names) - result.space.n_free
    lines = [f"Held at the baseline: {held} parameters."] if held else []
    if result.training_x is not None:
        error = "unknown (too few samples)"
        if result.loo_rms_deg is not None:
            error = f"{result.loo_rms_deg:.2f} deg (root mean square)"
        lines.append(f"Surrogate: {len(result.training_x)} samples, leave-one-out error {error}.")
    pairs = f"{counts['pairs_evaluated']:,} pairs evaluated, " if result.method == "ga" else ""
    lines += [
        f"Method: {result.method}, solver: {result.solver}.",
        f"{pairs}{counts['models_simulated']:,} models simulated: {counts['models_failed']} "
        f"failed, {counts['models_refined']} refined, {counts['models_unsettled']} with an "
        "unsettled load.",
        "Seconds: " + ", ".join(f"{name} {value:.3f}" for name, value in seconds.items()) + ".",
        f"Baseline: {result.space.title}. {result.space.note or ''}".rstrip(),
    ]
    return "\n".join(lines)


def _again(result: "SearchResult") -> list[RenderableType]:
    """Return the command that gives the result again, on one line, to be copied."""
    if result.stop_reason == "cancelled":
        return []
    file = " (knee.toml is written with the result's files)" if needs_file(result.space) else ""
    return [Text(f"Again{file}:"), Text(result.command(), no_wrap=True)]


def _parts(result: "SearchResult") -> list[RenderableType]:
    return [
        Text(_headline(result)),
        Text(""),
        _angles(result),
        _forces(result),
        _parameters(result),
        Text(_footer(result)),
        *_again(result),
    ]


def result_report(result: "SearchResult") -> str:
    """Return the whole result as text."""
    return render(_parts(result))


def result_html(result: "SearchResult") -> str:
    """Return the whole result as HTML."""
    return render(_parts(result), html=True)


def pair_report(result: "PairResult", *, html: bool = False) -> str:
    """Return the result for a model of the user's own as text, or as HTML."""
    model = "failed" if result.objective_model is None else f"{result.objective_model:.6g}"
    lines = [f"f (model): {model}"]
    if result.objective_surrogate is not None:
        gap = "" if result.gap_percent is None else f", gap {result.gap_percent:.2f} %"
        lines.append(f"f (surrogate): {result.objective_surrogate:.6g}{gap}")
    if result.repair is not None:
        lines.append(_repair(result.repair))
    rows = table("Inputs", "input", "lower", "upper", "model 1", "model 2")
    for k, name in enumerate(result.names):
        numbers = (result.lower[k], result.upper[k], result.x[0, k], result.x[1, k])
        rows.add_row(name, *(f"{v:.6g}" for v in numbers))
    outputs = table("Outputs", "output", "model 1", "model 2", "difference")
    for j, (a, b) in enumerate(result.y.T):
        outputs.add_row(str(j), *(f"{v:.6g}" for v in (a, b, b - a)))
    return render([Text("\n".join(lines)), rows, outputs], html=html)
