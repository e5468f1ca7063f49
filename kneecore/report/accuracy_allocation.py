"""Which measurement must be how good, for people."""

from collections.abc import Callable, Sequence

import numpy as np
from rich.console import RenderableType
from rich.table import Table
from rich.text import Text

from kneecore.knee.model import Knee
from kneecore.presented import Words
from kneecore.report.bound_sweep import how_searched
from kneecore.report.outputs import origin, shown
from kneecore.report.tables import render, table, with_unit
from kneecore.study.accuracy_allocation import ENLARGED, AccuracyAllocation

__all__ = ["WORDS", "checks", "cost_model", "summary"]


def _value(found: AccuracyAllocation, value: float) -> str:
    unit = found.model.columns[found.column].output.unit
    return with_unit(shown(found.model, value), unit)


def _limit(found: AccuracyAllocation) -> str:
    within = found.settings.within
    assert within is not None
    if isinstance(found.model, Knee):
        return f"every knee extends to within {within:g} deg"
    return f"{found.model.columns[found.column].title} is at most {_value(found, within)}"


def _goal(found: AccuracyAllocation) -> str:
    """Return what holds, as the beginning of a sentence; a model's own name stays as it is."""
    limit = _limit(found)
    return limit[0].upper() + limit[1:] if isinstance(found.model, Knee) else limit


def _saved(found: AccuracyAllocation) -> str:
    """Return what the cheapest save against one tolerance for all, as the end of a sentence."""
    if found.cost is None or found.equal_cost is None or found.equal.size is None:
        return ""
    share = 100.0 * (1.0 - found.cost / found.equal_cost)
    size = with_unit(f"{found.equal.size:.3g}", found.model.size_unit)
    less = f"{share:.0f} % less" if share >= 0.0 else f"{-share:.0f} % more"
    where = size if isinstance(found.model, Knee) else f"{found.model.size_name} {size}"
    return f"; that costs {less} than one tolerance for all ({where})"


def summary(found: AccuracyAllocation, *, called: Callable[[str], str] = str) -> str:
    """Return the answer in one sentence; `called` gives the measurements other names."""
    if found.factors is None:
        value = _value(found, found.nominal_value)
        return f"Not {_limit(found)} even if all is known exactly: {value}."
    if found.as_stated.all():
        return (
            f"{_goal(found)} even if no measurement is better than stated; the largest is "
            f"{_value(found, found.largest_value)}."
        )
    k = int(np.argmin(found.factors))
    tightest = with_unit(f"{found.stated[k] * found.factors[k]:.3g}", found.units[k])
    name = called(found.names[k])
    return (
        f"{_goal(found)} with a tolerance for each measurement, the tightest {name} "
        f"to within {tightest}{_saved(found)}."
    )


def cost_model() -> str:
    """Return what a tolerance costs, in a sentence."""
    return (
        "A measurement costs its cost times stated / tolerance: half the tolerance, twice the "
        "cost; none is made wider than stated."
    )


def checks(found: AccuracyAllocation) -> list[str]:
    """Return what was held against the cheapest tolerances, a sentence each."""
    if found.factors is None or found.enlarged is None:
        return []
    within, told = found.settings.within, []
    failed = f" ({found.n_sampled_failed:,} failed)" * (found.n_sampled_failed > 0)
    sampled = "gave no answer"
    if found.sampled_value is not None:
        sampled = f"reach at most {_value(found, found.sampled_value)}"
    what = "knees" if isinstance(found.model, Knee) else "models"
    told.append(
        f"Within the cheapest tolerances the searches find {_value(found, found.largest_value)} at "
        f"most; {found.n_sampled:,} random {what}{failed} {sampled}."
    )
    open_ones = np.flatnonzero(~found.as_stated)
    if len(open_ones):
        roomy = [k for k in open_ones if not found.enlarged[k] > within]
        percent = 100.0 * (ENLARGED - 1.0)
        told.append(
            f"{percent:.0f} % wider alone (at most as stated), {len(open_ones) - len(roomy)} of "
            f"{len(open_ones)} tolerances pass the limit; the others are as stated."
        )
        told += [
            f"{found.names[k]} has room: {_value(found, found.enlarged[k])} then." for k in roomy
        ]
    return told


def _tolerance(found: AccuracyAllocation, factors: np.ndarray | None, k: int) -> str:
    return "-" if factors is None else f"{found.stated[k] * factors[k]:.3g}"


def _rows(found: AccuracyAllocation) -> Table:
    unit = found.model.columns[found.column].output.unit
    rows = table(
        "How good each measurement must be: within +-",
        "measurement",
        "unit",
        "stated",
        "equal",
        "cheapest",
        "",
        "cost",
        f"adds {unit}".rstrip(),
        f"10 % wider {unit}".rstrip(),
    )
    for k, name in enumerate(found.names):
        gain = "-" if found.gains is None else shown(found.model, found.gains[k])
        alone = "-"
        if found.enlarged is not None and np.isfinite(found.enlarged[k]):
            alone = shown(found.model, found.enlarged[k])
        rows.add_row(
            name,
            found.units[k],
            f"{found.stated[k]:.3g}",
            _tolerance(found, found.equal_factors, k),
            _tolerance(found, found.factors, k),
            "as stated" if found.as_stated[k] else "",
            f"{found.costs[k]:g}",
            gain,
            alone,
        )
    total = ["-" if c is None else f"{c:.4g}" for c in (found.equal_cost, found.cost)]
    rows.add_section()
    rows.add_row("cost in all", "", f"{found.costs.sum():.4g}", *total, "", "", "", "")
    return rows


def _footer(found: AccuracyAllocation) -> str:
    n = found.n_searches + found.equal.n_searches
    lines = [
        f"{cost_model()} Adds: to the output of the worst model, by its slopes.",
        *checks(found),
        f"{n} searches, {found.seconds:.2f} s, seed {found.settings.seed}. "
        f"{how_searched(in_model=found.in_model)}",
        origin(found.model),
    ]
    return "\n".join(lines)


def _parts(found: AccuracyAllocation) -> Sequence[RenderableType]:
    return [Text(summary(found)), Text(""), _rows(found), Text(_footer(found))]


WORDS = Words(
    summary=summary,
    text=lambda found: render(_parts(found)),
    html=lambda found: render(_parts(found), html=True),
)
