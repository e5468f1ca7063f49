"""A search's result for people: the tables that a terminal and a notebook show."""

from collections.abc import Sequence

import numpy as np
from rich.console import RenderableType
from rich.table import Table
from rich.text import Text

from kneecore.knee.bounds import needs_file
from kneecore.knee.model import Knee
from kneecore.model import Model
from kneecore.presented import Words
from kneecore.report.bound_evidence import bound_lines
from kneecore.report.command import command_line
from kneecore.report.evidence import comparison_lines, evidence_lines, repair_line
from kneecore.report.knee_pair import difference_lines, knee_footer, knee_summary, knee_tables
from kneecore.report.marks import counted, legend
from kneecore.report.outputs import failure_lines, quantile_line
from kneecore.report.step_check import step_lines
from kneecore.report.tables import render, significant, table, with_unit
from kneecore.search.result import SearchResult

__all__ = ["WORDS", "objective_text"]


def objective_text(model: Model, value: float) -> str:
    """Return a value of f with its unit; a knee's has two decimals."""
    text = f"{value:.2f}" if isinstance(model, Knee) else significant(value)
    return with_unit(text, model.objective_unit)


def summary(result: SearchResult) -> str:
    """Return what differs, in one sentence."""
    if isinstance(result.model, Knee):
        return knee_summary(result)
    if not np.isfinite(result.y).all():
        return "The true model fails for one of the two models; their outputs cannot be compared."
    settings = result.settings
    weights = result.model.weights(settings.objective, settings.weights)
    k = int(np.argmax(weights * np.abs(result.y[0] - result.y[1])))
    column = result.model.columns[k]
    one, two = (with_unit(significant(v), column.output.unit) for v in result.y[:, k])
    part = "" if result.model.n_outputs == 1 else ", the largest part of f"
    return f"{column.title}: model 1 gives {one}, model 2 {two}{part}."


def _objective_line(result: SearchResult) -> str:
    model = "failed"
    if result.objective_model is not None:
        model = objective_text(result.model, result.objective_model)
    if result.objective_surrogate is None:
        return f"f (true model): {model}."
    gap = "" if result.gap_percent is None else f" (gap {result.gap_percent:.2f} %)"
    surrogate = objective_text(result.model, result.objective_surrogate)
    return f"f: surrogate {surrogate}, true model {model}{gap}."


def _headline(result: SearchResult) -> str:
    lines = [summary(result)]
    if isinstance(result.model, Knee):
        lines += difference_lines(result)
    lines.append(_objective_line(result))
    if result.repair is not None:
        lines.append(repair_line(result.repair))
    if result.verdict is not None:
        lines.append(str(result.verdict))
        if result.verdict.outlook:
            lines.append(result.verdict.outlook)
    if len(result.run_values) > 1:
        high, low = (f(result.run_values) for f in (max, min))
        best, worst = (objective_text(result.model, v) for v in (high, low))
        lines.append(f"{len(result.run_values)} runs: best f {best}, worst {worst}.")
    if result.evidence is not None:
        lines += evidence_lines(result.model, result.evidence)
    lines += bound_lines(result)
    lines += comparison_lines(result)
    if result.stop_reason == "cancelled":
        lines.append("The search was cancelled: this is the best pair until then.")
    return "\n".join(lines)


def _outputs(result: SearchResult) -> list[Table]:
    """Return one table an output, with its axis."""
    tables, first = [], 0
    for output in result.model.outputs:
        columns = ["baseline", "model 1", "model 2", "difference"]
        if result.y_surrogate is not None:
            columns += ["surrogate 1", "surrogate 2"]
        axis = with_unit(output.axis_name or "at", output.axis_unit)
        rows = table(with_unit(f"{output.name},", output.unit).rstrip(","), axis, *columns)
        for k, at in enumerate(output.axis or (None,), start=first):
            one, two = result.y[:, k]
            values = [result.y_nominal[k], one, two, two - one]
            if result.y_surrogate is not None:
                values += result.y_surrogate[:, k].tolist()
            rows.add_row("" if at is None else f"{at:g}", *map(significant, values))
        first += output.n_columns
        tables.append(rows)
    return tables


def _shown(model: Model, column: int, value: float) -> str:
    one = model.inputs[column]
    return f"{one.shown(value):.3f}" if isinstance(model, Knee) else significant(one.shown(value))


def _parameters(result: SearchResult) -> Table:
    rows = table(
        "Parameters (v lower bound, ^ upper bound)",
        *("parameter", "unit", "baseline", "model 1", "model 2"),
    )
    model = result.model
    sides = model.at_bounds(result.x)
    marks = {-1: " v", 0: "  ", 1: " ^"}
    for i, one in enumerate(model.inputs):
        if not model.free[i]:
            continue
        row = [_shown(model, i, model.nominal[i])]
        row += [f"{_shown(model, i, result.x[m][i])}{marks[int(sides[m][i])]}" for m in range(2)]
        rows.add_row(one.name, one.label, *row)
    return rows


def _counts(result: SearchResult) -> str:
    counts = result.counts
    told = [f"{counts['models_failed']} failed", *counted(counts, "models_")]
    pairs = ""
    if result.settings.method == "ga":
        pairs = f"{counts['pairs_evaluated']:,} pairs evaluated, "
    return f"{pairs}{counts['models_simulated']:,} models simulated: {', '.join(told)}."


def _footer(result: SearchResult) -> str:
    model = result.model
    held = len(model.inputs) - model.n_free
    lines = legend(result.responses.values()) + step_lines(result.responses)
    lines += [f"Held at the baseline: {held} parameters."] if held else []
    lines += quantile_line(model)
    if result.training_x is not None:
        error = "unknown (too few samples)"
        if result.loo_rms is not None:
            error = f"{objective_text(model, result.loo_rms)} (root mean square)"
        lines.append(f"Surrogate: {len(result.training_x)} samples, leave-one-out error {error}.")
    method = f"Method: {result.settings.method}"
    solver = f", solver: {model.solver}" if isinstance(model, Knee) else ""
    seconds = ", ".join(f"{name} {value:.3f}" for name, value in result.seconds.items())
    lines += [f"{method}{solver}.", _counts(result), *failure_lines(model)]
    lines.append(f"Seconds: {seconds}.")
    lines.append(knee_footer(model) if isinstance(model, Knee) else f"Model: {model.name}.")
    return "\n".join(lines)


def _again(result: SearchResult) -> list[RenderableType]:
    """Return the command that gives the result again, on one line, to be copied."""
    command = command_line(result)
    if command is None or result.stop_reason == "cancelled":
        return []
    assert isinstance(result.model, Knee)
    written = needs_file(result.model.space)
    file = " (knee.toml is written with the result's files)" if written else ""
    return [Text(f"Again{file}:"), Text(command, no_wrap=True)]


def _parts(result: SearchResult) -> Sequence[RenderableType]:
    tables = knee_tables(result) if isinstance(result.model, Knee) else _outputs(result)
    return [
        Text(_headline(result)),
        Text(""),
        *tables,
        _parameters(result),
        Text(_footer(result)),
        *_again(result),
    ]


WORDS = Words(
    summary=summary,
    text=lambda result: render(_parts(result)),
    html=lambda result: render(_parts(result), html=True),
)
